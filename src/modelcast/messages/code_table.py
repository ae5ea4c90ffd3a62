"""The table of a bank's codes: for every parameter of every sub-model, where it stands and what a code means.

It is made of the fields of Part I (`bsm_fields`) and of each sub-model's payload layout, as `codes_kernels`
takes it.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.messages import codes_kernels as kernels
from modelcast.messages.bsm_batch import CORE_MEANING
from modelcast.messages.bsm_fields import CORE_FIELDS, CORE_INDEX
from modelcast.messages.fields import Outside
from modelcast.models.bank import Bank
from modelcast.models.base import AbstractSubModel
from modelcast.models.payload import CORE_PARAMETERS, PayloadField
from modelcast.models.predicted_path import carried_layout

__all__ = ["MOTION_FIELDS", "CodeTable", "code_table", "coefficient_meaning"]

MOTION_FIELDS: Final = ("speed_mps", "heading_rad", "acceleration_forward_mps2", "yaw_rate_radps")
"""Fields of Part I that say how a vehicle moves, in the order of `CORE_PARAMETERS`."""

_FIELDS: Final = dict(zip(CORE_PARAMETERS, MOTION_FIELDS, strict=True))
"""Fields of Part I by the parameters they carry; the velocity's two by its east and its north."""

_NOTHING: Final = (0.0, 0.0, np.nan, 1.0, 1.0, 1.0, float(Outside.CLAMP))
"""Meaning of the one code of what no message carries: zero."""


@dataclass(frozen=True, eq=False, slots=True)
class CodeTable:
    """What the parameters of a bank are on the wire.

    Parameters
    ----------
    rows
        One a parameter, sub-models in turn, (P, `codes_kernels.COLUMNS`).
    offsets
        Bounds of each sub-model's rows, (M + 1,).
    names
        ``sub-model.parameter``, P of them.
    wire
        Rows of the coefficients in the order of the extension, sub-models in turn, (C,).
    wire_offsets
        Bounds of each sub-model's part of `wire`, (M + 1,).
    """

    rows: FloatArray
    offsets: IntArray
    names: tuple[str, ...]
    wire: IntArray
    wire_offsets: IntArray

    def quantise(self, parameters: FloatArray) -> tuple[IntArray, FloatArray]:
        """Codes of parameters, and what receivers hold, (B, P) both.

        Parameters
        ----------
        parameters
            Of all sub-models in turn, (B, P).

        Raises
        ------
        ValueError
            Where the shape is wrong, or one is not a number: nothing stands for "not known".

        Examples
        --------
        >>> from modelcast.models.constant_velocity import ConstantVelocity
        >>> codes, held = code_table(Bank((ConstantVelocity(),))).quantise(np.array([[10.004, 0.0]]))
        >>> codes.tolist(), held.round(9).tolist()
        ([[500, 7200]], [[10.0, 0.0]])
        """
        if parameters.ndim != 2 or parameters.shape[1] != len(self.names):
            raise ValueError(f"parameters must be (B, {len(self.names)}), got {parameters.shape}")
        given = np.require(parameters, np.float64, ["C", "W"])
        codes, held = np.zeros(given.shape, np.int64), np.zeros(given.shape)
        row, at = kernels.quantise_rows(self.rows, self.offsets, given, codes, held)
        if row >= 0:
            raise ValueError(f"row {row}: {self.names[at]} is not a number, and no code stands for that")
        return codes, held

    def decoded(self, core: IntArray, codes: IntArray) -> FloatArray:
        """What receivers hold, (B, P): 0 for what no code came of.

        Parameters
        ----------
        core
            Codes of Part I, (B, 25).
        codes
            Codes of the coefficients at their parameters' places, (B, P); those of Part I are filled in.
        """
        held = np.zeros(codes.shape)
        kernels.decoded_rows(self.rows, np.require(core, np.int64, ["C", "W"]), codes, held)
        return held


def coefficient_meaning(field: PayloadField) -> tuple[float, ...]:
    """What the codes of a coefficient stand for, as `field_kernels` takes it.

    Parameters
    ----------
    field
        Of a payload layout.
    """
    return (field.low, field.high, np.nan, field.step, 1.0, 1.0, float(Outside.CLAMP))


def code_table(bank: Bank) -> CodeTable:
    """Table of a bank.

    Parameters
    ----------
    bank
        Its sub-models; of one without a layout the predicted path is carried.

    Raises
    ------
    ValueError
        Where no message carries a parameter, or a sub-model has a velocity that is not east, then north.
    """
    members = bank.carried().members
    rows = [row for member in members for row in _rows(member)]
    names = tuple(f"{member.name}.{name}" for member in members for name in member.parameter_names)
    offsets = np.cumsum([0] + [len(member.parameter_names) for member in members], dtype=np.int64)
    wire = [
        first + member.parameter_names.index(name)
        for member, first in zip(members, offsets.tolist(), strict=False)
        for name in carried_layout(member).names
    ]
    counts = [0] + [len(carried_layout(member).names) for member in members]
    return CodeTable(
        np.array(rows, dtype=np.float64),
        offsets,
        names,
        np.array(wire, dtype=np.int64),
        np.cumsum(counts, dtype=np.int64),
    )


def _rows(member: AbstractSubModel) -> list[tuple[float, ...]]:
    """Rows of a sub-model."""
    names, layout = member.parameter_names, carried_layout(member)
    unknown = [name for name in layout.names if name not in names]
    if unknown:
        raise ValueError(f"{member.name}: the layout has {', '.join(unknown)}, and the sub-model has not")
    east, north = (names.index(name) if name in names else -1 for name in CORE_PARAMETERS[:2])
    if (east < 0) != (north < 0) or (east >= 0 and north != east + 1):
        raise ValueError(f"{member.name}: velocity must be east, then north, got {', '.join(names)}")
    fields = {field.name: field for field in layout.fields}
    rows: list[tuple[float, ...]] = []
    for name in names:
        if name in _FIELDS:
            place = CORE_INDEX[_FIELDS[name]]
            rows.append((*CORE_MEANING[place].tolist(), place, CORE_FIELDS[place].width_bits))
        elif name in fields:
            rows.append((*coefficient_meaning(fields[name]), kernels.IN_EXTENSION, fields[name].bits))
        elif name in member.held_parameters:
            rows.append((*_NOTHING, kernels.IN_EXTENSION, 0))
        else:
            raise ValueError(
                f"{member.name}: no message carries {name}: it is neither in Part I nor in the layout"
            )
    return rows

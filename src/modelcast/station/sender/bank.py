"""A sender's bank made ready: point functions, codes and sizes as compiled steps take them."""

from dataclasses import dataclass

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.messages.quantisation import CoreSteps, core_steps
from modelcast.messages.sizes import SizeModel
from modelcast.models.bank import Bank
from modelcast.models.base import AbstractSubModel
from modelcast.models.learned import Selector
from modelcast.models.members import ReadyBank
from modelcast.models.payload import CORE_PARAMETERS
from modelcast.models.predicted_path import carried_form
from modelcast.station.policy.guard import GUARD
from modelcast.station.sender.fitting_kernels import Codes, SenderModels

__all__ = ["SenderBank", "codes_of"]


@dataclass(frozen=True, slots=True)
class SenderBank:
    """A bank for one sampling interval, as a sender fits it and as its receivers hold it.

    It may go to another process: addresses are asked for where compiled steps are called (`models`).

    Parameters
    ----------
    bank
        The sub-models in the forms that messages carry; one that does with a single sample is added last
        where there is none, and then serves only for want of another.
    ready
        Their point functions.
    codes
        What a message can say of their parameters.
    sizes
        Bytes of an update by the sub-model in use, (M,).
    fallback
        The member added, -1 where none was.
    dt_s
        Sampling interval [s].
    selector
        Predicts which member lasts; None for none.
    """

    bank: Bank
    ready: ReadyBank
    codes: Codes
    sizes: IntArray
    fallback: int
    dt_s: float
    selector: Selector | None = None

    @classmethod
    def of(
        cls,
        bank: Bank,
        dt_s: float,
        *,
        quantised: bool = True,
        identify: str = "never",
        sizes: SizeModel | None = None,
        selector: Selector | None = None,
    ) -> "SenderBank":
        """Make a bank ready.

        Parameters
        ----------
        bank
            Its sub-models.
        dt_s
            Sampling interval [s].
        quantised
            Whether parameters go through the codes of the wire; else they stay as fitted.
        identify
            The policy's rule, which says whether all parameters are sent.
        sizes
            Bytes of messages; None for the codec's.
        selector
            Predicts which member lasts.

        Raises
        ------
        ValueError
            Where the selector was trained for another bank.
        """
        carried = Bank(tuple(map(carried_form, bank.members)), bank.name) if quantised else bank
        whole = carried.complete()
        if selector is not None:
            selector.check_members(tuple(member.name for member in whole.members))
        return cls(
            whole,
            ReadyBank.of(whole, dt_s),
            codes_of(whole, core_steps() if quantised else None),
            (SizeModel() if sizes is None else sizes).each_update_bytes(whole, identify),
            -1 if whole is carried else len(carried.members),
            dt_s,
            selector,
        )

    @property
    def guard(self) -> int:
        """The member that a guarded sender falls back on, -1 where the bank has none of its own to guard.

        Raises
        ------
        ValueError
            Where a bank of several lacks it.
        """
        if len(self.bank.members) == 1 or self.fallback == 1:
            return -1  # one sub-model and what stands in for it: nothing to guard
        place = self.bank.place_of(GUARD)
        if place == self.fallback:
            raise ValueError(f"start 'guarded' needs {GUARD} as a member of its own: add it")
        return place

    def models(self, guard: int = -1) -> SenderModels:
        """What compiled steps take; it means something in this process alone.

        Parameters
        ----------
        guard
            The member that guarded lanes fall back on.
        """
        selector = self.selector
        return SenderModels(
            self.ready.members,
            self.codes,
            self.sizes,
            self.fallback,
            guard,
            0 if selector is None else selector.address,
            1 if selector is None else selector.window_at(self.dt_s),
            self.dt_s,
        )


def codes_of(bank: Bank, steps: CoreSteps | None) -> Codes:
    """Return what a message can say of a bank's parameters.

    Parameters
    ----------
    bank
        Members in the forms that messages carry.
    steps
        Those of Part I; None for parameters as they were fitted.

    Raises
    ------
    ValueError
        Where a member's velocity is not east, then north.
    """
    names = [member.parameter_names for member in bank.members]
    velocity = np.full(len(names), -1, dtype=np.int64)
    for m, own in enumerate(names):
        if CORE_PARAMETERS[0] in own:
            velocity[m] = own.index(CORE_PARAMETERS[0])
        if (CORE_PARAMETERS[0] in own or CORE_PARAMETERS[1] in own) and own[velocity[m] :][
            :2
        ] != CORE_PARAMETERS[:2]:
            raise ValueError(
                f"{bank.members[m].name}: velocity must be east, then north, got {', '.join(own)}"
            )
    fields = [
        _field(member, name, steps) for member, own in zip(bank.members, names, strict=True) for name in own
    ]
    polar = (0.0, 0.0, 0.0) if steps is None else (steps.speed_mps, steps.last_speed, steps.heading_rad)
    table: FloatArray = np.array(fields, dtype=np.float64).reshape(-1, 3)
    return Codes(table, velocity, np.array(polar, dtype=np.float64))


def _field(member: AbstractSubModel, name: str, steps: CoreSteps | None) -> tuple[float, float, float]:
    """Step, lowest and highest code of a parameter; step 0 where it has none of its own."""
    layout = member.payload_layout
    if steps is None:
        return 0.0, 0.0, 0.0
    if name == "acceleration_mps2":
        return steps.acceleration_mps2, -float(steps.last_acceleration), float(steps.last_acceleration)
    if name == "yaw_rate_radps":
        return steps.yaw_rate_radps, -float(steps.last_yaw_rate), float(steps.last_yaw_rate)
    if layout is not None and name in layout.names:
        step, low, high = layout.table[layout.names.index(name)].tolist()
        return step, low, high
    return 0.0, 0.0, 0.0

"""A bank of sub-models is one more model: it fits them all and predicts with the one in use."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.models.base import AbstractMotionModel, AbstractSubModel, Windows
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.plain_meaning import is_free, plain_place, same_receiver
from modelcast.models.predicted_path import carried_form

__all__ = ["Bank"]


@dataclass(frozen=True)
class Bank(AbstractMotionModel):
    """Sub-models in order; the first that has a full window serves unless a message names another.

    The parameters are the index of the sub-model in use, then the parameters of every member in turn. Members
    without a full window have zeros there and are not used.

    Parameters
    ----------
    members
        The sub-models, M >= 1, with distinct names.
    label
        Name of the bank; the members' names joined by ``+`` where empty.
    plain
        The member that a plain message is coasted by, a free one (`modelcast.models.plain_meaning`); where
        empty, the first that is free.

    Raises
    ------
    ValueError
        Where there is no member, two share a name, or the one named for plain messages is not free.

    Examples
    --------
    >>> from modelcast.models.constant_velocity import ConstantVelocity
    >>> Bank((ConstantVelocity(),)).parameter_names
    ('in_use', 'cv.velocity_east_mps', 'cv.velocity_north_mps')
    """

    members: tuple[AbstractSubModel, ...]
    label: str = ""
    plain: str = ""

    def __post_init__(self) -> None:
        names = [member.name for member in self.members]
        if not names:
            raise ValueError("a bank needs at least one sub-model")
        if len(set(names)) != len(names):
            raise ValueError(f"sub-models of a bank must have distinct names, got {', '.join(names)}")
        if self.plain:
            plain_place(self.members, self.plain)

    def place_of(self, name: str) -> int:
        """Index of the member of this name.

        Parameters
        ----------
        name
            Its short name.

        Raises
        ------
        ValueError
            Where there is none.
        """
        names = [member.name for member in self.members]
        if name not in names:
            raise ValueError(f"the bank has no {name}, only {', '.join(names)}")
        return names.index(name)

    @property
    def name(self) -> str:
        """The label, or the members' names joined by ``+``."""
        return self.label or "+".join(member.name for member in self.members)

    @property
    def window(self) -> int:
        """The shortest window any member can do with."""
        return min(member.window for member in self.members)

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """``in_use``, then every member's names behind its own."""
        inner = (f"{member.name}.{name}" for member in self.members for name in member.parameter_names)
        return ("in_use", *inner)

    @cached_property
    def windows(self) -> IntArray:
        """Samples each member's window must hold, (M,)."""
        return np.array([member.window for member in self.members], dtype=np.int64)

    @cached_property
    def offsets(self) -> IntArray:
        """Bounds of each member's parameters after ``in_use``, (M + 1,), from 0."""
        return np.cumsum([0] + [len(member.parameter_names) for member in self.members], dtype=np.int64)

    @cached_property
    def trust(self) -> FloatArray:
        """Trusted horizon of each member, and how long it goes on turning beyond, (M, 2) [s]."""
        return np.array([[member.trusted_horizon_s, member.trusted_turn_s] for member in self.members])

    @cached_property
    def plain_place(self) -> int:
        """Index of the member that a plain message is coasted by, -1 where none is free.

        Examples
        --------
        >>> from modelcast.models.kinematic import ConstantTurnRateAcceleration
        >>> Bank((ConstantTurnRateAcceleration(), ConstantVelocity())).plain_place
        0
        """
        return plain_place(self.members, self.plain)

    @cached_property
    def sent_plain(self) -> tuple[bool, ...]:
        """With which members a plain message says all: those that do at a receiver what it is coasted by."""
        if self.plain_place < 0:
            return (False,) * len(self.members)
        meaning = self.members[self.plain_place]
        return tuple(is_free(member) and same_receiver(member, meaning) for member in self.members)

    def complete(self) -> "Bank":
        """The bank itself, or with one more member added last where none does with one sample.

        A sender must have something to say at a start and after a gap. What is added serves only there: a
        sender uses it where no other member has a full window. It is the starter of the member that a plain
        message is coasted by, where that has one, else constant velocity.
        """
        if self.window == 1:
            return self
        starter = self.members[self.plain_place].starter if self.plain_place >= 0 else None
        return Bank((*self.members, starter or ConstantVelocity()), self.name, self.plain)

    def carried(self) -> "Bank":
        """The bank in the forms that messages carry, not rounded: what a receiver predicts with.

        Members that have a layout stay as they are; of the others the predicted path is sent.

        Examples
        --------
        >>> from modelcast.models.gp import GaussianProcess
        >>> Bank((GaussianProcess(),)).carried().parameter_names[3]
        'gp-anchored.east_0_m'
        """
        return Bank(tuple(map(carried_form, self.members)), self.label, self.plain)

    def fit(self, windows: Windows) -> FloatArray:
        """Parameters of all members, (B, 1 + sum P)."""
        self.require_window(windows)
        given = windows.samples.shape[1]
        out = np.zeros((windows.samples.shape[0], len(self.parameter_names)))
        out[:, 0] = int(np.argmax(self.windows <= given))
        for m, member in enumerate(self.members):
            if member.window <= given:
                out[:, self._columns(m)] = member.fit(windows)
        return out

    def predict(self, parameters: FloatArray, horizons_s: FloatArray, *, dt_s: float) -> FloatArray:
        """Mean displacement by the sub-model in use, (B, H, 2) [m]."""
        parameters = self.checked(parameters)
        out = np.empty((parameters.shape[0], horizons_s.size, 2))
        for m, rows in self._rows(parameters):
            own = parameters[rows, self._columns(m)]
            out[rows] = self.members[m].predict(own, horizons_s, dt_s=dt_s)
        return out

    def predict_at(self, parameters: FloatArray, ages_s: FloatArray, *, dt_s: float) -> FloatArray:
        """Mean displacement by the sub-model in use, each row at its own age, (B, 2) [m]."""
        parameters = self.checked(parameters, ages_s)
        out = np.empty((parameters.shape[0], 2))
        for m, rows in self._rows(parameters):
            own = parameters[rows, self._columns(m)]
            out[rows] = self.members[m].predict_at(own, ages_s[rows], dt_s=dt_s)
        return out

    def covariance(self, parameters: FloatArray, horizons_s: FloatArray, *, dt_s: float) -> FloatArray:
        """Predictive covariance of the sub-model in use, (B, H, 2, 2) [m²]."""
        parameters = self.checked(parameters)
        out = np.empty((parameters.shape[0], horizons_s.size, 2, 2))
        for m, rows in self._rows(parameters):
            own = parameters[rows, self._columns(m)]
            out[rows] = self.members[m].covariance(own, horizons_s, dt_s=dt_s)
        return out

    def _columns(self, member: int) -> slice:
        return slice(1 + int(self.offsets[member]), 1 + int(self.offsets[member + 1]))

    def _rows(self, parameters: FloatArray) -> list[tuple[int, IntArray]]:
        """Members in use, each with its rows."""
        wanted = parameters[:, 0]
        known = np.isin(wanted, np.arange(len(self.members)))
        if not known.all():
            raise ValueError(f"in_use must be from 0 to {len(self.members) - 1}, got {wanted[~known][0]}")
        in_use = wanted.astype(np.int64)
        return [(int(m), np.flatnonzero(in_use == m)) for m in np.unique(in_use)]

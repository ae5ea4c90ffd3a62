"""A bank made ready for one sampling interval, and its members as compiled loops take them."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.models.bank import Bank
from modelcast.models.base import PointFunctions, made_functions
from modelcast.models.context_columns import CONTEXT_COLUMNS
from modelcast.models.member_kernels import Members
from modelcast.models.point_kernels import SAMPLE_COLUMNS
from modelcast.models.python_function import keeping

__all__ = ["ReadyBank"]


@dataclass(frozen=True, slots=True)
class ReadyBank:
    """The point functions of a bank's members, with what loops need to know of each.

    It may go to another process: addresses are asked for where a loop is called (`members`).

    Parameters
    ----------
    functions
        Of each member, M of them.
    windows
        Samples each member's window must hold, (M,).
    offsets
        Bounds of each member's parameters in a row of all, (M + 1,).
    trust
        Trusted horizon of each member, and how long it goes on turning beyond, (M, 2) [s].

    Examples
    --------
    >>> from modelcast.models.constant_velocity import ConstantVelocity
    >>> ready = ReadyBank.of(Bank((ConstantVelocity(),)), 0.1)
    >>> ready.members.windows, ready.members.offsets
    (array([1]), array([0, 2]))
    """

    functions: Sequence[PointFunctions]
    windows: IntArray
    offsets: IntArray
    trust: FloatArray
    _members: Members | None = field(default=None, init=False, repr=False, compare=False)

    def __reduce__(self) -> tuple[type["ReadyBank"], tuple[object, ...]]:
        """Leave addresses behind: in another process they mean nothing."""
        return ReadyBank, (self.functions, self.windows, self.offsets, self.trust)

    @classmethod
    def of(cls, bank: Bank, dt_s: float) -> "ReadyBank":
        """Make a bank ready.

        Parameters
        ----------
        bank
            Its members.
        dt_s
            Sampling interval [s].
        """
        functions = tuple(made_functions(member, dt_s) for member in bank.members)
        return cls(functions, bank.windows, bank.offsets, bank.trust)

    @classmethod
    def joined(cls, banks: "Sequence[ReadyBank]") -> "ReadyBank":
        """Return several banks as one, the members of each behind those before.

        Parameters
        ----------
        banks
            At least one.
        """
        counts = np.concatenate([np.diff(one.offsets) for one in banks])
        return cls(
            tuple(function for one in banks for function in one.functions),
            np.concatenate([one.windows for one in banks]),
            np.concatenate([np.zeros(1, dtype=np.int64), np.cumsum(counts)]),
            np.concatenate([one.trust for one in banks]),
        )

    @property
    def reads_context(self) -> bool:
        """Whether a member reads the vehicle ahead or the road (`modelcast.models.context_columns`)."""
        return any(one.context_at is not None for one in self.functions)

    @property
    def state_column(self) -> int:
        """First column of the members' state: behind what is measured, and the context where one reads it."""
        return SAMPLE_COLUMNS + (CONTEXT_COLUMNS if self.reads_context else 0)

    @property
    def sample_columns(self) -> int:
        """Columns of a sample: measured, the context where a member reads it, the state of all members."""
        return self.state_column + sum(one.stream.columns for one in self.functions if one.stream is not None)

    @property
    def members(self) -> Members:
        """What compiled loops take, made once; it means something in this process alone."""
        if self._members is None:
            object.__setattr__(self, "_members", self._made_members())
        assert self._members is not None  # noqa: S101 - just made
        return self._members

    def _made_members(self) -> Members:
        column = self.state_column
        constants = [one.reading_context(SAMPLE_COLUMNS) for one in self.functions]
        bounds = np.cumsum([0] + [one.size for one in constants], dtype=np.int64)
        streams = np.zeros((len(constants), 4), dtype=np.int64)
        for m, one in enumerate(self.functions):
            if one.stream is not None:
                end = column + one.stream.columns
                streams[m] = one.stream.observe_address, bounds[m] + one.stream.start, column, end
                constants[m] = constants[m].copy()
                constants[m][one.stream.at] = column
                column = end
        return Members(
            fits=np.array([one.fit_address for one in self.functions], dtype=np.int64),
            predicts=np.array([one.predict_address for one in self.functions], dtype=np.int64),
            constants=keeping(np.concatenate(constants), tuple(one.calls for one in self.functions)),
            bounds=bounds,
            windows=self.windows,
            offsets=self.offsets,
            trust=self.trust,
            streams=streams,
            absorbs=np.array([one.absorb_address for one in self.functions], dtype=np.int64),
        )

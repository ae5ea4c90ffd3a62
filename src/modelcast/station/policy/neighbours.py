"""The remotes that each host hears, with what vehicle density and packet error ratio are counted from.

`Neighbours` is the public form: state in, state out. It copies its tables at every call; a compiled loop
that owns them calls `neighbours_kernels` directly.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.station.policy import neighbours_kernels as kernels
from modelcast.station.policy.j2945_parameters import J2945Parameters
from modelcast.station.policy.neighbours_kernels import NeighbourTables

__all__ = ["Neighbours", "neighbour_tables"]


def neighbour_tables(
    hosts: int, capacity: int, *, sub_intervals: int = 5, phase_s: FloatArray | None = None
) -> NeighbourTables:
    """Return empty tables.

    Parameters
    ----------
    hosts
        How many, H.
    capacity
        Remotes a host can hold at once, C, up to 32767. Messages of further ones are refused and counted.
    sub_intervals
        How many a packet error ratio covers, `J2945Parameters.sub_intervals`, up to 9; one more is kept.
    phase_s
        When each host's sub-intervals start, (H,) [s]; None for 0.

    Raises
    ------
    ValueError
        Where a number is out of its range, or there is not one phase a host.

    Notes
    -----
    A slot takes 66 bytes, and its share of the index 4 to 8.
    """
    if min(hosts, capacity, sub_intervals) < 1:
        raise ValueError(
            f"hosts, capacity and sub_intervals must be at least 1, got {hosts}, {capacity}, {sub_intervals}"
        )
    if sub_intervals >= kernels.MOST_KEPT:
        raise ValueError(f"sub_intervals must be below {kernels.MOST_KEPT}, got {sub_intervals}")
    if capacity >= 2**15:
        raise ValueError(f"capacity must be below {2**15}, got {capacity}")
    phase = np.zeros(hosts) if phase_s is None else np.array(phase_s, dtype=np.float64)
    if phase.shape != (hosts,):
        raise ValueError(f"phase_s must be ({hosts},), one a host, got {phase.shape}")
    about: Any = np.zeros(hosts, dtype=kernels.HOST_TYPE)
    about["phase_s"], about["kept"] = phase, sub_intervals + 1
    slots: Any = np.zeros((hosts, capacity), dtype=kernels.SLOT_TYPE)
    slots["remote"] = -1
    return NeighbourTables(
        hosts=about,
        slots=slots,
        lookup=np.full((hosts, 1 << (2 * capacity - 1).bit_length()), -1, dtype=np.int16),
        free=np.zeros((hosts, capacity), dtype=np.int16),
    )


@dataclass(frozen=True, slots=True)
class Neighbours:
    """What H hosts hold of the remotes they hear.

    Parameters
    ----------
    tables
        From `neighbour_tables`.
    parameters
        Sub-interval and range.

    Examples
    --------
    One remote, of whose messages 0 to 4 the third was lost:

    >>> heard = Neighbours(neighbour_tables(1, 8)).heard(
    ...     np.zeros(4, dtype=np.int64),
    ...     np.full(4, 7),
    ...     message_count=np.array([0, 1, 3, 4]),
    ...     heard_s=np.array([0.1, 0.3, 0.7, 0.9]),
    ...     position_m=np.zeros((4, 2)),
    ... )
    >>> count, ratio = heard.survey(np.array([1.0]), np.array([[30.0, 40.0]]))
    >>> count.tolist(), ratio.tolist()
    ([1], [0.2])
    """

    tables: NeighbourTables
    parameters: J2945Parameters = field(default_factory=J2945Parameters)

    def heard(
        self,
        host: IntArray,
        remote: IntArray,
        *,
        message_count: IntArray,
        heard_s: FloatArray,
        position_m: FloatArray,
    ) -> "Neighbours":
        """The tables after K receptions, in the order of time for each host.

        Parameters
        ----------
        host
            Who received, (K,) in 0..H-1.
        remote
            Whose message it was, (K,) in 0..2^31-1.
        message_count
            Its DE_MsgCount, (K,) in 0..127.
        heard_s
            When it was received, (K,) [s].
        position_m
            The position it states, (K, 2) [m].

        Raises
        ------
        ValueError
            Where a number is out of its range.
        """
        hosts = self.tables.hosts.size
        for name, values, end in (
            ("host", host, hosts),
            ("remote", remote, 2**31),
            ("message_count", message_count, kernels.MESSAGE_COUNTS),
        ):
            if values.size and not (values.min() >= 0 and values.max() < end):
                raise ValueError(f"{name} must lie in 0..{end - 1}, got {values.min()}..{values.max()}")
        tables = NeighbourTables(*(column.copy() for column in self.tables))
        kernels.hear_each(
            *tables,
            host,
            remote,
            message_count,
            np.ascontiguousarray(heard_s, dtype=np.float64),
            np.ascontiguousarray(position_m, dtype=np.float64),
            self.parameters.per_sub_interval_s,
            np.empty(host.size, dtype=np.int64),
        )
        return Neighbours(tables, self.parameters)

    def survey(self, t_s: FloatArray, position_m: FloatArray) -> tuple[IntArray, FloatArray]:
        """Remotes heard within the last sub-interval and in range, and their mean packet error ratio.

        Parameters
        ----------
        t_s
            Now, (H,) [s].
        position_m
            Where the hosts are, (H, 2) [m].

        Returns
        -------
        count
            (H,).
        packet_error_ratio
            Over the sub-intervals that are over, NaN where no remote in range has two messages, (H,).
        """
        count = np.empty(t_s.size, dtype=np.int64)
        ratio = np.empty(t_s.size)
        kernels.survey_each(
            self.tables.hosts,
            self.tables.slots,
            np.ascontiguousarray(t_s, dtype=np.float64),
            np.ascontiguousarray(position_m, dtype=np.float64),
            self.parameters.per_sub_interval_s,
            self.parameters.per_range_m,
            count,
            ratio,
        )
        return count, ratio

"""Rows of a network evaluation; definitions are in ``docs/nomenclature.md``."""

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass, field, fields
from math import isfinite, nan

from modelcast.study.network.people_rows import PeopleRow
from modelcast.study.network.roadside_rows import RoadsideDistanceRow, RoadsideRow
from modelcast.study.network.warning_rows import PooledWarnings, WarnedEventRow, WarnedHostRow, WarningRow

__all__ = [
    "CASE_KEYS",
    "HEADLINE_M",
    "NO_BANK",
    "NO_THRESHOLD",
    "CaseResult",
    "DistanceRow",
    "NetworkCase",
    "NetworkResult",
    "OutcomeRow",
    "PairingRow",
    "PenetrationRow",
    "PooledRow",
    "RunRow",
    "SecondRow",
    "SenderRow",
]

HEADLINE_M = (50.0, 150.0)
"""Distances of the headline figures [m]."""

NO_BANK = "none"
"""Bank of a policy that sends no model: a basic safety message belongs to no bank, and runs once."""

NO_THRESHOLD = nan
"""Threshold of a policy that has none: its runs are made once, whatever thresholds are asked for [m]."""


@dataclass(frozen=True, slots=True, order=True)
class NetworkCase:
    """One run: what is varied.

    Parameters
    ----------
    density_per_km
        As asked for; NaN where the scenario has its own [1/km].
    radio, policy
        Names.
    bank
        Name of the sub-models sent; `NO_BANK` where the policy sends none.
    threshold_m
        Tracking error that calls for a message; `NO_THRESHOLD` where the policy knows none [m].
    run
        Number of the seed, from 0.
    """

    density_per_km: float
    radio: str
    policy: str
    bank: str
    threshold_m: float = field(default=NO_THRESHOLD, kw_only=True)
    run: int


CASE_KEYS = tuple(key.name for key in fields(NetworkCase))
"""Names of what is varied, which every row of a run holds."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RunRow:
    """One run; a number that does not exist is NaN.

    Parameters
    ----------
    density_per_km, radio, policy, bank, threshold_m, run
        As in `NetworkCase`.
    vehicles
        Mean number.
    message_rate_hz
        Messages handed to the radio a vehicle and second [Hz].
    update_rate_hz, identification_rate_hz
        Of these, those that state a position and motion anew, and those that name another sub-model of an
        update sent before [Hz].
    time_ratio, dynamics_ratio, critical_ratio
        Shares of the messages by cause; rules without causes count under time.
    model_ratio, certificate_ratio
        Shares of the messages with a model and with a certificate.
    payload_bytes, frame_bytes
        Mean bytes of a message, and of its frame on the air.
    bytes_per_s
        Bytes of frames a vehicle and second.
    airtime_ratio
        Share of time that a vehicle is on the air.
    power_dbm
        Mean transmit power [dBm].
    busy_ratio
        Mean channel busy ratio.
    expired_ratio
        Share of the messages that were never sent, since a newer one took their place.
    delivery_ratio, collision_ratio, hidden_ratio, concurrent_ratio, half_duplex_ratio, weak_ratio
        Of all pairs of frame and vehicle 50 m to 150 m apart: received; lost to other frames, and of these
        the hidden and the concurrent ones; lost because the receiver was sending; too weak by themselves.
    held_ratio
        Share of the samples of pairs 50 m to 150 m apart in which the host held a live track.
    pte_p50_m, pte_p90_m, pte_p95_m, pte_p99_m
        Tracking error, all pairs 50 m to 150 m apart [m].
    relative_p50_m, relative_p90_m, relative_p99_m
        Error of the place of the remote as the host sees it from where it takes itself to be, same pairs [m].
    age_p50_s, age_p90_s
        Information age, 50 m to 150 m [s].
    gap_p50_s, gap_p90_s, gap_p99_s
        Inter-packet gap, 50 m to 150 m [s].
    neighbours, inter_transmit_time_s, channel_quality
        Means of the state of J2945/1: smoothed density, longest time between messages [s], believed loss.
    tracks_per_s
        Tracks sampled a second: a measure of the work done.
    """

    density_per_km: float
    radio: str
    policy: str
    bank: str
    threshold_m: float
    run: int
    vehicles: float
    message_rate_hz: float
    update_rate_hz: float
    identification_rate_hz: float
    time_ratio: float
    dynamics_ratio: float
    critical_ratio: float
    model_ratio: float
    certificate_ratio: float
    payload_bytes: float
    frame_bytes: float
    bytes_per_s: float
    airtime_ratio: float
    power_dbm: float
    busy_ratio: float
    expired_ratio: float
    delivery_ratio: float
    collision_ratio: float
    hidden_ratio: float
    concurrent_ratio: float
    half_duplex_ratio: float
    weak_ratio: float
    held_ratio: float
    pte_p50_m: float
    pte_p90_m: float
    pte_p95_m: float
    pte_p99_m: float
    relative_p50_m: float
    relative_p90_m: float
    relative_p99_m: float
    age_p50_s: float
    age_p90_s: float
    gap_p50_s: float
    gap_p90_s: float
    gap_p99_s: float
    neighbours: float
    inter_transmit_time_s: float
    channel_quality: float
    tracks_per_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class DistanceRow:
    """What hosts held of remotes at one distance in one run.

    Parameters
    ----------
    density_per_km, radio, policy, bank, threshold_m, run
        As in `NetworkCase`.
    low_m, high_m
        Bounds of the distance [m].
    pairs
        Samples of pairs of vehicles, whether tracked or not.
    held_ratio, pte_p50_m, pte_p90_m, pte_p95_m, pte_p99_m, age_p50_s, age_p90_s, gap_p50_s, gap_p90_s
        As in `RunRow`, at this distance.
    """

    density_per_km: float
    radio: str
    policy: str
    bank: str
    threshold_m: float
    run: int
    low_m: float
    high_m: float
    pairs: int
    held_ratio: float
    pte_p50_m: float
    pte_p90_m: float
    pte_p95_m: float
    pte_p99_m: float
    age_p50_s: float
    age_p90_s: float
    gap_p50_s: float
    gap_p90_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class OutcomeRow:
    """What became of frames at one distance in one run: shares of all pairs of frame and vehicle in reach.

    Parameters
    ----------
    density_per_km, radio, policy, bank, threshold_m, run
        As in `NetworkCase`.
    low_m, high_m
        Bounds of the distance [m].
    pairs
        Pairs of frame and vehicle.
    received_ratio, half_duplex_ratio, weak_ratio, hidden_ratio, concurrent_ratio
        By `modelcast.channel.radio.OUTCOMES`.
    """

    density_per_km: float
    radio: str
    policy: str
    bank: str
    threshold_m: float
    run: int
    low_m: float
    high_m: float
    pairs: int
    received_ratio: float
    half_duplex_ratio: float
    weak_ratio: float
    hidden_ratio: float
    concurrent_ratio: float


@dataclass(frozen=True, slots=True, kw_only=True)
class SecondRow:
    """One second of one run, the warm-up among them.

    Parameters
    ----------
    density_per_km, radio, policy, bank, threshold_m, run
        As in `NetworkCase`.
    t_s
        Its end [s].
    message_rate_hz, busy_ratio, power_dbm, neighbours, inter_transmit_time_s, channel_quality, pte_p90_m
        As in `RunRow`, in this second.
    """

    density_per_km: float
    radio: str
    policy: str
    bank: str
    threshold_m: float
    run: int
    t_s: float
    message_rate_hz: float
    busy_ratio: float
    power_dbm: float
    neighbours: float
    inter_transmit_time_s: float
    channel_quality: float
    pte_p90_m: float


@dataclass(frozen=True, slots=True, kw_only=True)
class PooledRow:
    """One figure of one density and sender over all seeds: mean and 95 % Student-t interval.

    Parameters
    ----------
    density_per_km, radio, policy, bank, threshold_m
        As in `NetworkCase`.
    seeds
        Runs pooled.
    figure
        Name of a field of `RunRow`.
    value, low, high
        Mean and bounds; bounds are None for a single run.
    """

    density_per_km: float
    radio: str
    policy: str
    bank: str
    threshold_m: float
    seeds: int
    figure: str
    value: float
    low: float | None
    high: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class SenderRow:
    """What a policy sends of a bank.

    Parameters
    ----------
    policy, bank
        As in `NetworkCase`.
    sub_models
        Names of the bank's members in order, joined by ``+``.
    start, identify
        Rules in effect.
    """

    policy: str
    bank: str
    sub_models: str
    start: str
    identify: str


@dataclass(frozen=True, slots=True, kw_only=True)
class PairingRow:
    """How vehicles of one sender are tracked by those that read in one way, in a run of a mixed fleet.

    Parameters
    ----------
    density_per_km, radio, policy, bank, threshold_m, run
        As in `NetworkCase`.
    senders_ratio
        Share of the vehicles that send by the last of the policies.
    sender, reading
        Who is tracked, and by whom: ``legacy``, ``free`` or ``model`` receivers.
    message_rate_hz, bytes_per_s, airtime_ratio
        Of a vehicle of that sender, whoever hears it.
    held_ratio, pte_p50_m, pte_p90_m, pte_p99_m, age_p50_s, age_p90_s
        As in `RunRow`, at the headline distances, over pairs of these.
    pairs
        How many samples of pairs there were.
    """

    density_per_km: float
    radio: str
    policy: str
    bank: str
    threshold_m: float
    run: int
    senders_ratio: float
    sender: str
    reading: str
    message_rate_hz: float
    bytes_per_s: float
    airtime_ratio: float
    held_ratio: float
    pte_p50_m: float
    pte_p90_m: float
    pte_p99_m: float
    age_p50_s: float
    age_p90_s: float
    pairs: int


@dataclass(frozen=True, slots=True, kw_only=True)
class PenetrationRow:
    """Tracking errors over all pairs of a fleet of which shares send and read models.

    What is read changes nothing that is sent, so one run serves all shares of receivers.

    Parameters
    ----------
    density_per_km, radio, policy, bank, threshold_m, run
        As in `NetworkCase`.
    senders_ratio
        Share of the vehicles that send by the last of the policies.
    receivers_ratio
        Share of the vehicles that read models; the others read as legacy receivers do.
    pte_p50_m, pte_p90_m, pte_p99_m
        At the headline distances.
    """

    density_per_km: float
    radio: str
    policy: str
    bank: str
    threshold_m: float
    run: int
    senders_ratio: float
    receivers_ratio: float
    pte_p50_m: float
    pte_p90_m: float
    pte_p99_m: float


@dataclass(frozen=True, slots=True)
class CaseResult:
    """All rows of one run.

    Pairings and penetration are those of mixed fleets, warnings of hosts that have applications.
    """

    run: RunRow
    distances: Sequence[DistanceRow]
    _: KW_ONLY
    outcomes: Sequence[OutcomeRow]
    seconds: Sequence[SecondRow]
    pairings: Sequence[PairingRow] = ()
    penetration: Sequence[PenetrationRow] = ()
    warnings: Sequence[WarningRow] = ()
    warned_hosts: Sequence[WarnedHostRow] = ()
    warned_events: Sequence[WarnedEventRow] = ()
    roadside: Sequence[RoadsideRow] = ()
    roadside_distances: Sequence[RoadsideDistanceRow] = ()
    people: Sequence[PeopleRow] = ()


@dataclass(frozen=True, slots=True)
class NetworkResult:
    """Rows of all runs, in order of density, radio, policy, bank, threshold and seed; and who sent."""

    runs: Sequence[RunRow]
    distances: Sequence[DistanceRow]
    _: KW_ONLY
    outcomes: Sequence[OutcomeRow]
    seconds: Sequence[SecondRow]
    pooled: Sequence[PooledRow] = field(default=())
    senders: Sequence[SenderRow] = field(default=())
    pairings: Sequence[PairingRow] = field(default=())
    penetration: Sequence[PenetrationRow] = field(default=())
    warnings: Sequence[WarningRow] = field(default=())
    warned_hosts: Sequence[WarnedHostRow] = field(default=())
    warned_events: Sequence[WarnedEventRow] = field(default=())
    pooled_warnings: Sequence[PooledWarnings] = field(default=())
    roadside: Sequence[RoadsideRow] = field(default=())
    roadside_distances: Sequence[RoadsideDistanceRow] = field(default=())
    people: Sequence[PeopleRow] = field(default=())

    @property
    def banks(self) -> tuple[str, ...]:
        """Names of the banks whose models were sent, in the order of the rows."""
        return tuple(dict.fromkeys(row.bank for row in self.runs if row.bank != NO_BANK))

    @property
    def thresholds_m(self) -> tuple[float, ...]:
        """Thresholds of those policies that have one, rising [m]."""
        return tuple(sorted({row.threshold_m for row in self.runs if isfinite(row.threshold_m)}))

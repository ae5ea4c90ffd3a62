"""Rows of what hosts of a fleet on the air warned of: of single runs, their hosts and events, and pooled."""

from dataclasses import dataclass

__all__ = ["ALL_SENDERS", "PooledWarnings", "WarnedEventRow", "WarnedHostRow", "WarningRow"]

ALL_SENDERS = "all"
"""Stands for remotes of every sender of a mixed fleet."""


@dataclass(frozen=True, slots=True, kw_only=True)
class WarningRow:
    """What the hosts of one run, reading in one way, warned of remotes of one sender.

    Parameters
    ----------
    density_per_km, radio, policy, bank, threshold_m, run
        As in `modelcast.study.network.rows.NetworkCase`.
    application
        Its name.
    sender, reading
        Of whom, and how hosts read it: ``legacy``, ``free`` or ``model``.
    host_s
        Time that hosts were observed [s].
    counted
        Instants of pairs near the decision.
    events, never
        True warnings, and those of them that no host's warning met.
    positives, missed
        Instants of true warnings that count, and those of them at which the host did not warn.
    negatives, false
        The other instants near the decision, and those of them at which the host warned.
    false_warnings
        Whole warnings with no true one near in time.
    """

    density_per_km: float
    radio: str
    policy: str
    bank: str
    threshold_m: float
    run: int
    application: str
    sender: str
    reading: str
    host_s: float
    counted: int
    events: int
    never: int
    positives: int
    missed: int
    negatives: int
    false: int
    false_warnings: int


@dataclass(frozen=True, slots=True, kw_only=True)
class WarnedHostRow:
    """What one host warned of without reason; hosts with nothing to count are left out.

    Parameters
    ----------
    density_per_km, radio, policy, bank, threshold_m, run, application, sender, reading
        As in `WarningRow`.
    host
        Identifier of the vehicle.
    negatives, false, false_warnings
        As in `WarningRow`, of this host.
    """

    density_per_km: float
    radio: str
    policy: str
    bank: str
    threshold_m: float
    run: int
    application: str
    sender: str
    reading: str
    host: int
    negatives: int
    false: int
    false_warnings: int


@dataclass(frozen=True, slots=True, kw_only=True)
class WarnedEventRow:
    """One true warning, and what became of it.

    Parameters
    ----------
    density_per_km, radio, policy, bank, threshold_m, run, application, sender, reading
        As in `WarningRow`.
    host, remote
        Identifiers of the vehicles.
    t_s
        When it begins [s].
    positives, missed
        As in `WarningRow`, of this one.
    delay_s
        How late the host warned [s]; not a number where it never did.
    """

    density_per_km: float
    radio: str
    policy: str
    bank: str
    threshold_m: float
    run: int
    application: str
    sender: str
    reading: str
    host: int
    remote: int
    t_s: float
    positives: int
    missed: int
    delay_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class PooledWarnings:
    """What hosts warned of over all seeds.

    Parameters
    ----------
    density_per_km, radio, policy, bank, threshold_m, application, reading
        As in `WarningRow`.
    sender
        Of whom; `ALL_SENDERS` for every sender of a mixed fleet.
    seeds
        Runs pooled.
    message_rate_hz, busy_ratio
        Of the whole fleet, means over the runs.
    events, positives, negatives
        Sums over the runs.
    missed_ratio, missed_low, missed_high
        Share of the true warnings' instants without a warning, and its 95 % interval over warnings and runs.
    false_ratio, false_low, false_high
        Share of the other instants near the decision with one, and its interval over hosts and runs.
    false_per_hour
        Warnings without a true one near, an hour of a host [1/h].
    never_ratio
        Share of the true warnings that never came.
    delay_p50_s, delay_p90_s, delay_p99_s
        Of all true warnings; infinite where more were missed [s].
    missed_over, missed_over_low, missed_over_high, false_over, false_over_low, false_over_high
        Missed and false instants over those of the rival; not a number where it met other warnings.
    """

    density_per_km: float
    radio: str
    policy: str
    bank: str
    threshold_m: float
    application: str
    sender: str
    reading: str
    seeds: int
    message_rate_hz: float
    busy_ratio: float
    events: int
    positives: int
    negatives: int
    missed_ratio: float
    missed_low: float | None
    missed_high: float | None
    false_ratio: float
    false_low: float | None
    false_high: float | None
    false_per_hour: float
    never_ratio: float
    delay_p50_s: float
    delay_p90_s: float
    delay_p99_s: float
    missed_over: float
    missed_over_low: float | None
    missed_over_high: float | None
    false_over: float
    false_over_low: float | None
    false_over_high: float | None

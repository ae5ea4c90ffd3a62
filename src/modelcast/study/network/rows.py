"""Tables of a network evaluation; definitions are in ``docs/nomenclature.md``."""

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field, replace
from math import isfinite, nan
from types import MappingProxyType
from typing import Any

from modelcast.study.network.columns import (
    AGE,
    AIRTIME,
    BUSY,
    BYTES,
    CASE,
    DELIVERY,
    GAP,
    HELD,
    LOST,
    MESSAGES,
    POWER,
    PTE,
    SETTING,
    SPAN,
    STATE,
)
from modelcast.study.network.people_rows import PEOPLE
from modelcast.study.network.roadside_rows import ROADSIDE, ROADSIDE_DISTANCES
from modelcast.study.network.warning_rows import POOLED_WARNINGS, WARNED_EVENTS, WARNED_HOSTS, WARNINGS
from modelcast.study.table import Row, Table, TableSchema, count, quantity, ratio, text

__all__ = [
    "CASE_KEYS",
    "CASE_TABLES",
    "DISTANCES",
    "HEADLINE_M",
    "NO_BANK",
    "NO_THRESHOLD",
    "OUTCOMES",
    "PAIRINGS",
    "PENETRATION",
    "POOLED",
    "RUNS",
    "SECONDS",
    "SENDERS",
    "SETTING_KEYS",
    "CaseResult",
    "NetworkCase",
    "NetworkResult",
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

    def values(self) -> dict[str, Any]:
        """What is varied, by the names of its columns."""
        return {name: getattr(self, name) for name in CASE_KEYS}


CASE_KEYS = tuple(column.name for column in CASE)
"""Names of what is varied, which every row of a run holds."""

SETTING_KEYS = tuple(column.name for column in SETTING)
"""The same without the seed, which every row over all seeds holds."""


RUNS = TableSchema(
    "runs",
    "One run; figures of frames, tracks, gaps and ages are of vehicles 50 m to 150 m apart.",
    (
        *CASE,
        quantity("vehicles", "1", "Mean number of vehicles."),
        MESSAGES,
        quantity(
            "update_rate_hz",
            "1/s",
            "Of these, those that state a position and motion anew.",
            heading="updates [1/s]",
        ),
        quantity(
            "identification_rate_hz",
            "1/s",
            "Of these, those that name another sub-model of an update sent before.",
            heading="identifications [1/s]",
        ),
        ratio("time_ratio", "Share of the messages caused by time; rules without causes count here."),
        ratio("dynamics_ratio", "Share of the messages caused by the vehicle's motion."),
        ratio("critical_ratio", "Share of the messages caused by critical events."),
        ratio("model_ratio", "Share of the messages with a model.", heading="with model [%]"),
        ratio("certificate_ratio", "Share of the messages with a certificate."),
        quantity("payload_bytes", "byte", "Mean bytes of a message."),
        quantity("frame_bytes", "byte", "Mean bytes of its frame on the air.", heading="bytes a frame"),
        BYTES,
        AIRTIME,
        POWER,
        BUSY,
        quantity(
            "expired_ratio",
            "1",
            "Messages never sent, since a newer one took their place, over those handed to the radio.",
        ),
        DELIVERY,
        ratio("collision_ratio", "Share lost to other frames, hidden or concurrent.", heading="collided [%]"),
        *LOST.values(),
        HELD,
        *PTE,
        *(
            quantity(
                f"relative_p{at}_m",
                "m",
                "Error of the place of the remote as the host sees it from where it takes itself to be: "
                f"percentile {at}.",
            )
            for at in (50, 90, 99)
        ),
        *AGE,
        *GAP,
        quantity("gap_p99_s", "s", "Inter-packet gap: percentile 99.", heading="IPG p99 [s]"),
        *STATE,
        quantity("tracks_per_s", "1/s", "Tracks sampled a second: a measure of the work done."),
    ),
)
"""Runs: a row each."""

DISTANCES = TableSchema(
    "distances",
    "What hosts held of remotes at one distance in one run.",
    (
        *CASE,
        *SPAN,
        count("pairs", "Samples of pairs of vehicles, whether tracked or not."),
        HELD,
        *PTE,
        *AGE,
        *GAP,
    ),
)
"""Tracks by distance: a row a run and bin."""

OUTCOMES = TableSchema(
    "outcomes",
    "What became of frames at one distance in one run: shares of all pairs of frame and vehicle in reach.",
    (
        *CASE,
        *SPAN,
        count("pairs", "Pairs of frame and vehicle."),
        ratio("received_ratio", "Share received."),
        LOST["half_duplex"],
        LOST["weak"],
        LOST["hidden"],
        LOST["concurrent"],
    ),
)
"""Frames by distance: a row a run and bin of the radio."""

SECONDS = TableSchema(
    "seconds",
    "One second of one run, the warm-up among them.",
    (*CASE, quantity("t_s", "s", "Its end."), MESSAGES, BUSY, POWER, *STATE, PTE[1]),
)
"""Seconds: a row a run and second."""

POOLED = TableSchema(
    "pooled",
    "One figure of one setting over all seeds.",
    (
        *SETTING,
        count("seeds", "Runs pooled."),
        text("figure", "Name of a column of the table of runs."),
        quantity("value", "", "Mean, in the unit of that column."),
        quantity("low", "", "Lower 95 % Student-t limit.", missing="one run has no interval"),
        quantity("high", "", "Upper 95 % Student-t limit.", missing="one run has no interval"),
    ),
)
"""Figures over all seeds: a row each."""

SENDERS = TableSchema(
    "senders",
    "What a policy sends of a bank.",
    (
        text("policy", "Name of the policy."),
        text("bank", "Name of the bank."),
        text("sub_models", "Names of the bank's members in order, joined by +.", heading="sub-models"),
        text("start", "Rule in effect of where an update starts."),
        text("identify", "Rule in effect of when another sub-model is named."),
    ),
)
"""Senders: a row a policy and bank."""

_NEW_SENDERS = ratio("senders_ratio", "Share of the vehicles that send by the last of the policies.")

PAIRINGS = TableSchema(
    "pairings",
    "How vehicles of one sender, 50 m to 150 m away, are tracked by those that read in one way.",
    (
        *CASE,
        _NEW_SENDERS,
        text("sender", "Who is tracked."),
        text("reading", "By whom: legacy, free or model receivers."),
        MESSAGES,
        BYTES,
        replace(AIRTIME, heading="airtime [%]"),
        replace(HELD, heading="held [%]"),
        PTE[0],
        replace(PTE[1], heading="p90 [m]"),
        replace(PTE[3], heading="p99 [m]"),
        *AGE,
        count("pairs", "How many samples of pairs there were."),
    ),
)
"""Mixed fleets: a row a run, sender and reading."""

PENETRATION = TableSchema(
    "penetration",
    "Tracking errors over all pairs of a fleet of which shares send and read models; what is read changes "
    "nothing that is sent, so one run serves all shares of receivers.",
    (
        *CASE,
        _NEW_SENDERS,
        ratio("receivers_ratio", "Share of the vehicles that read models; the others read as legacy do."),
        PTE[0],
        PTE[1],
        PTE[3],
    ),
)
"""Mixed fleets: a row a run and share of model receivers."""

CASE_TABLES: Mapping[str, TableSchema] = MappingProxyType(
    {
        schema.name: schema
        for schema in (
            DISTANCES,
            OUTCOMES,
            SECONDS,
            PAIRINGS,
            PENETRATION,
            WARNINGS,
            WARNED_HOSTS,
            WARNED_EVENTS,
            ROADSIDE,
            ROADSIDE_DISTANCES,
            PEOPLE,
        )
    }
)
"""Tables of one run beside its own row, by the fields of `CaseResult` and `NetworkResult`."""


@dataclass(frozen=True, slots=True)
class CaseResult:
    """All rows of one run, by the tables of `CASE_TABLES`.

    Pairings and penetration are those of mixed fleets, warnings of hosts that have applications.
    """

    run: Row
    distances: Sequence[Row]
    _: KW_ONLY
    outcomes: Sequence[Row]
    seconds: Sequence[Row]
    pairings: Sequence[Row] = ()
    penetration: Sequence[Row] = ()
    warnings: Sequence[Row] = ()
    warned_hosts: Sequence[Row] = ()
    warned_events: Sequence[Row] = ()
    roadside: Sequence[Row] = ()
    roadside_distances: Sequence[Row] = ()
    people: Sequence[Row] = ()


@dataclass(frozen=True, slots=True)
class NetworkResult:
    """Tables of all runs, in order of density, radio, policy, bank, threshold and seed; and who sent."""

    runs: Table
    distances: Table
    _: KW_ONLY
    outcomes: Table
    seconds: Table
    pooled: Table = field(default_factory=POOLED.table)
    senders: Table = field(default_factory=SENDERS.table)
    pairings: Table = field(default_factory=PAIRINGS.table)
    penetration: Table = field(default_factory=PENETRATION.table)
    warnings: Table = field(default_factory=WARNINGS.table)
    warned_hosts: Table = field(default_factory=WARNED_HOSTS.table)
    warned_events: Table = field(default_factory=WARNED_EVENTS.table)
    pooled_warnings: Table = field(default_factory=POOLED_WARNINGS.table)
    roadside: Table = field(default_factory=ROADSIDE.table)
    roadside_distances: Table = field(default_factory=ROADSIDE_DISTANCES.table)
    people: Table = field(default_factory=PEOPLE.table)

    @property
    def banks(self) -> tuple[str, ...]:
        """Names of the banks whose models were sent, in the order of the rows."""
        return tuple(dict.fromkeys(row.bank for row in self.runs if row.bank != NO_BANK))

    @property
    def thresholds_m(self) -> tuple[float, ...]:
        """Thresholds of those policies that have one, rising [m]."""
        return tuple(sorted({row.threshold_m for row in self.runs if isfinite(row.threshold_m)}))

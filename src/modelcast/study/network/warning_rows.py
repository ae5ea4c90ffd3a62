"""What hosts of a fleet on the air warned of, as tables: of runs, their hosts and events, and pooled."""

from dataclasses import replace

from modelcast.study.network.columns import BUSY, CASE, MESSAGES, SETTING, WARNED
from modelcast.study.safety.result import DELAYS, over_columns
from modelcast.study.table import TableSchema, count, quantity, ratio

__all__ = ["ALL_SENDERS", "POOLED_WARNINGS", "WARNED_EVENTS", "WARNED_HOSTS", "WARNINGS"]

ALL_SENDERS = "all"
"""Stands for remotes of every sender of a mixed fleet."""

_POSITIVES = count("positives", "Instants of true warnings that count.")
_MISSED = count("missed", "Those of them at which the host did not warn.")
_NEGATIVES = count("negatives", "The other instants near the decision.")
_FALSE = (
    _NEGATIVES,
    count("false", "Those of them at which the host warned."),
    count("false_warnings", "Whole warnings with no true one near in time."),
)
_FEW = "too few units to draw from"

WARNINGS = TableSchema(
    "warnings",
    "What the hosts of one run, reading in one way, warned of remotes of one sender.",
    (
        *CASE,
        *WARNED,
        quantity("host_s", "s", "Time that hosts were observed."),
        count("counted", "Instants of pairs near the decision."),
        count("events", "True warnings."),
        count("never", "Those of them that no host's warning met."),
        _POSITIVES,
        _MISSED,
        *_FALSE,
    ),
)
"""Warnings: a row a run, application, sender and reading."""

WARNED_HOSTS = TableSchema(
    "warned_hosts",
    "What one host warned of without reason; hosts with nothing to count are left out.",
    (*CASE, *WARNED, count("host", "Identifier of the vehicle."), *_FALSE),
)
"""Hosts that warned: a row each."""

WARNED_EVENTS = TableSchema(
    "warned_events",
    "One true warning, and what became of it.",
    (
        *CASE,
        *WARNED,
        count("host", "Identifier of the host."),
        count("remote", "Identifier of the remote."),
        quantity("t_s", "s", "When it begins."),
        _POSITIVES,
        _MISSED,
        quantity("delay_s", "s", "How late the host warned; NaN where it never did."),
    ),
)
"""True warnings: a row each."""

POOLED_WARNINGS = TableSchema(
    "pooled_warnings",
    "What hosts warned of over all seeds; intervals are of 95 %.",
    (
        *SETTING,
        *WARNED,
        count("seeds", "Runs pooled."),
        replace(MESSAGES, description="Messages of the whole fleet, mean over the runs."),
        BUSY,
        count("events", "True warnings, sum over the runs."),
        replace(_POSITIVES, description="Their instants that count, sum over the runs."),
        replace(_NEGATIVES, description="The other instants near the decision, sum over the runs."),
        ratio("missed_ratio", "Share of the true warnings' instants without a warning."),
        ratio("missed_low", "Lower end of its interval over warnings and runs.", missing=_FEW),
        ratio("missed_high", "Upper end of its interval over warnings and runs.", missing=_FEW),
        ratio("false_ratio", "Share of the other instants near the decision with a warning."),
        ratio("false_low", "Lower end of its interval over hosts and runs.", missing=_FEW),
        ratio("false_high", "Upper end of its interval over hosts and runs.", missing=_FEW),
        quantity("false_per_hour", "1/h", "Warnings without a true one near, an hour of a host."),
        ratio("never_ratio", "Share of the true warnings that never came."),
        *DELAYS,
        *over_columns("missed", "the rival's; NaN where it met other warnings"),
        *over_columns("false", "the rival's; NaN where it met other warnings"),
    ),
)
"""Warnings over all seeds: a row a setting, application, sender and reading."""

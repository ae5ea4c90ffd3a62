"""Claims about the sentences that a report of warnings begins with."""

from typing import Any

from made_rows import filled
from modelcast.report.safety import safety_headline
from modelcast.study.safety.result import POOLED_SAFETY, SafetyResult
from modelcast.study.table import Row

NAN = float("nan")
RATES = {"default": 1.9, "cv": 2.9, "free": 2.0}


def sent(candidate: str, basis: str, **own: Any) -> Row:
    """A row of a sender, which misses half of what the other misses and is as often false."""
    values = {"missed_over": 0.5, "false_over": 1.0, "missed_ratio": 0.1, "false_ratio": 0.2, **own}
    return filled(
        POOLED_SAFETY,
        1.0,
        sensor="none",
        mean_burst_s=None,
        loss_log="",
        packet_error_ratio=0.4,
        basis=basis,
        candidate=candidate,
        message_rate_hz=RATES[candidate],
        **{f"{what}_over_{end}": None for what in ("missed", "false") for end in ("low", "high")},
        **values,
    )


def told(*rows: Row) -> dict[str, str]:
    """What is said of each sender at the same threshold, after the colon that ends the condition."""
    result = SafetyResult(
        {"against": "cv", "budget": "default"},
        recordings=(),
        pooled=POOLED_SAFETY.table(rows),
        events=100,
        pairs=2,
        counted=1000,
        positives=500,
        failures={},
        skipped={},
    )
    lines = [line.partition("at the same threshold ")[2] for line in safety_headline(result)]
    return dict(line.split("): ", 1) for line in lines if line)


def both(**own: Any) -> tuple[Row, ...]:
    """Three senders at the same airtime and the same threshold; the one with the budget as given."""
    return tuple(
        sent(name, basis, **(own if name == "default" else {}))
        for basis in ("airtime", "threshold")
        for name in RATES
    )


def test_at_the_same_threshold_everybody_s_rate_is_told() -> None:
    assert told(*both(missed_ratio=0.05)) == {
        "(messages a second: default 1.90, cv 2.90, free 2.00": "default misses 0.50 of what cv misses, with "
        "1.00 of its false ones; over free's 0.50 missed and 1.00 false, for which there is no interval"
    }
    alone = tuple(row for row in both() if row.candidate != "free")
    assert list(told(*alone)) == ["(messages a second: default 1.90, cv 2.90"]


def test_a_part_without_a_ratio_is_left_out() -> None:
    (said,) = told(*both(false_over=NAN)).values()
    assert said.startswith("default misses 0.50 of what cv misses; over free's 1.00 missed and 1.00 false")
    (said,) = told(*both(missed_over=NAN)).values()
    assert said.startswith("default has 1.00 of cv's false ones; over")
    (said,) = told(*both(missed_over=NAN, false_over=NAN, missed_ratio=NAN, false_ratio=NAN)).values()
    assert said == "default has no ratio over cv"
    never = (row.replaced(false_ratio=0.0) if row.candidate == "free" else row for row in both())
    (said,) = told(*never).values()
    assert said.endswith("; over free's 1.00 missed, for which there is no interval")

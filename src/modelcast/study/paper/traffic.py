"""The claims about traffic, which the paper asserts without measuring, and a reproduction that has them."""

from collections.abc import Sequence
from dataclasses import replace

from modelcast.station.banks import PAPER_BANK
from modelcast.study.network.densities import counted_verdicts
from modelcast.study.paper.choices import PLAIN_LABEL
from modelcast.study.paper.claims import COMMAND
from modelcast.study.paper.result import ClaimRow, PaperResult
from modelcast.study.paper.verdict import Verdict
from modelcast.study.table import Row
from modelcast.study.wording import centimetres

__all__ = ["traffic_claims", "with_traffic"]

_SAME = 1e-9
"""Rates that differ by less are the same: they are sums of whole messages over the same time."""

_UNDER = "with a noisy sensor, a keep-alive of 2 s and models rounded as sent"


def with_traffic(result: PaperResult, rows: Sequence[Row]) -> PaperResult:
    """The reproduction with the claims about traffic judged.

    Parameters
    ----------
    result
        Of trips alone.
    rows
        As `modelcast.study.network.pairs.traffic_rows` gives them, those of the paper's bank; empty where no
        traffic was run.
    """
    judged = traffic_claims(rows)
    names = {row.name for row in judged}
    others = tuple(row for row in result.claims if row.name not in names)
    return replace(result, claims=(*others, *judged), traffic=tuple(rows))


def traffic_claims(rows: Sequence[Row]) -> tuple[ClaimRow, ...]:
    """The claims about traffic, which the paper asserts without measuring.

    Parameters
    ----------
    rows
        As `modelcast.study.network.pairs.traffic_rows` gives them, those of the paper's bank; empty where no
        traffic was run.
    """
    rows = tuple(row for row in rows if row.bank == PAPER_BANK.name)
    judged = tuple(
        ClaimRow(
            name,
            "conclusion",
            sentence,
            measure=f"{what}, of the hybrid less the baseline at the same threshold, {_UNDER}; holds where "
            "the 95 % interval over the seeds lies below zero at every density, radio and threshold.",
            figure=_counted(rows, figure),
            worst=_worst_traffic(rows, figure),
            verdicts={PLAIN_LABEL: _traffic_verdict(rows, figure)},
            shown_in="traffic_load",
            command=f"{COMMAND} --traffic",
        )
        for name, figure, what, sentence in (
            (
                "fewer collisions",
                "collision_rate_hz",
                "Frames of one remote, 50 m to 150 m away, that are lost to others in a second",
                "Fewer messages collide at every density of traffic.",
            ),
            (
                "a channel less busy",
                "busy_ratio",
                "Share of time in which the channel is busy",
                "The load of the channel is lower at every density, so the system scales.",
            ),
        )
    )
    return (_any_radio(rows), *judged)


def _any_radio(rows: Sequence[Row]) -> ClaimRow:
    """Whether the same senders send the same over each radio: what they say does not depend on it."""
    sent: dict[tuple[float, float], dict[str, float]] = {}
    for row in rows:
        if row.figure == "message_rate_hz" and not row.by_range:
            sent.setdefault((row.density_per_km, row.threshold_m), {})[row.radio] = row.hybrid
    compared = [list(one.values()) for one in sent.values() if len(one) > 1]
    apart = max((max(one) / min(one) - 1.0 for one in compared), default=0.0)
    radios = sorted({row.radio for row in rows})
    verdict: Verdict = "not run" if not compared else "holds" if apart <= _SAME else "fails"
    return ClaimRow(
        "any radio",
        "system",
        "The architecture is indifferent to the radio below it.",
        measure="The hybrid's message rates over each radio, at equal density and threshold, are the same; "
        "octets and beliefs over four technologies are compared in tests/runtime/test_technologies.py.",
        figure=f"{', '.join(radios)}: {100 * apart:.2g} % apart" if compared else "no traffic was run",
        worst="",
        verdicts={PLAIN_LABEL: verdict},
        shown_in="traffic_reception",
        command=f"{COMMAND} --traffic",
    )


def _counted(rows: Sequence[Row], figure: str) -> str:
    radios = sorted({row.radio for row in rows})
    texts = [
        f"{radio}: "
        + ", ".join(
            f"{word} {count}" for word, count in sorted(counted_verdicts(rows, figure, radio).items())
        )
        for radio in radios
    ]
    return "; ".join(texts) if texts else "no traffic was run"


def _traffic_verdict(rows: Sequence[Row], figure: str) -> Verdict:
    counts = counted_verdicts(rows, figure)
    fewer, more = counts.get("fewer", 0), counts.get("more", 0)
    if not counts:
        return "not run"
    if fewer == sum(counts.values()):
        return "holds"
    if more == sum(counts.values()):
        return "fails"
    return "in part" if fewer or more else "not shown"


def _worst_traffic(rows: Sequence[Row], figure: str) -> str:
    own = [row for row in rows if row.figure == figure and not row.by_range and row.baseline > 0]
    if not own:
        return ""
    worst = max(own, key=lambda row: row.hybrid / row.baseline)
    return (
        f"{worst.radio}, {worst.density_per_km:g}/km, {centimetres(worst.threshold_m)}: "
        f"{worst.hybrid / worst.baseline:.2f} times the baseline's"
    )

"""The headline of the published network table: what remains of the gain where.

All sentences are made of the runs that there are, and say of no density that was not run.
"""

from collections.abc import Mapping

from network_table_cells import RECEIVERS
from network_table_rows import Mean, Rows, density_said, listed, mean_of, spans, verdict

__all__ = ["headline_block", "verdicts"]

PLAIN, FILTERED, FREE, MODELS = "j2945", "j2945-filtered", "j2945-free", "j2945-mbc"
RELAXED, RELAXED_FREE = "j2945-mbc-relaxed", "j2945-free-relaxed"
ERROR_DRIVEN, ERROR_FREE = "mbc", "free"
SMALL_CUT = 0.05
"""Less is said to be little [of p90]."""

Ratios = Mapping[float, Mean]
"""Ratios by density."""


def verdicts(ratios: Ratios) -> str:
    """Where the interval of a ratio leaves 1 out, and to which side.

    Examples
    --------
    >>> verdicts({25.0: Mean(1.0, 0.01), 400.0: Mean(0.5, 0.02)})
    'lower at 400 (0.500 ± 0.020); not shown to differ at 25 (1.000 ± 0.010)'
    """
    parts: list[str] = []
    for word, said in (("lower", "lower at"), ("higher", "higher at"), ("same", "not shown to differ at")):
        own = [(density, one) for density, one in sorted(ratios.items()) if verdict(one) == word]
        if own:
            each = (f"{density_said(density)} ({one.said('.3f')})" for density, one in own)
            parts.append(f"{said} {listed(each)}")
    return "; ".join(parts)


def headline_block(rows: Rows) -> list[str]:
    """A paragraph for each receiver that was run: filter, free sub-model, models, fewer messages."""
    lines: list[str] = []
    for receiver in RECEIVERS:
        of = _Receiver(rows, receiver)
        said = [line for line in (of.timers(), of.cut(), of.models(), *of.fewer(), *of.rivals()) if line]
        if said:
            lines += [f"- **Receiver {RECEIVERS[receiver]}.** {said[0]}", *(f"  {line}" for line in said[1:])]
    return [*_summary({name: _Receiver(rows, name) for name in RECEIVERS}), *lines] if lines else ["Not run."]


def _summary(receivers: Mapping[str, "_Receiver"]) -> list[str]:
    """Over all receivers: what is taken off p90, and where models have a part in it."""
    cuts: list[str] = []
    lower: list[str] = []
    for name, of in receivers.items():
        gains = [100.0 * (1.0 - one.value) for one in of.ratios(MODELS, "pte_p90_m", PLAIN).values()]
        if gains:
            cuts.append(f"{spans(gains, '.0f')} % ({RECEIVERS[name]})")
        against = of.ratios(MODELS, "pte_p90_m", FREE)
        at = [density_said(density) for density, one in sorted(against.items()) if verdict(one) == "lower"]
        if at:
            lower.append(f"at {listed(at)} ({RECEIVERS[name]})")
    if not cuts:
        return []
    where = listed(lower) if lower else "at no density of these runs"
    short = f"- **In short.** `{MODELS}` takes off the p90 of `{PLAIN}`: {', '.join(cuts)}."
    return [f"{short} It is below `{FREE}`, which sends no model, {where}."]


class _Receiver:
    """What is said of one receiver, on the plain highway and 802.11p."""

    def __init__(self, rows: Rows, receiver: str) -> None:
        self.rows = rows
        self.settings = rows.settings("highway", lambda radio: radio == "dsrc", (receiver,))

    def ratios(self, policy: str, figure: str, against: str) -> dict[float, Mean]:
        """A figure of a sender over that of another, by density."""
        own = [one for one in self.settings if one.policy == policy]
        found = {one.density_per_km: self.rows.ratio(one, figure, against) for one in own}
        return {density: ratio for density, ratio in found.items() if ratio is not None}

    def timers(self) -> str:
        """What filter, free sub-model and models make of p90 under the same timers."""
        parts: list[str] = []
        densities: set[float] = set()
        for policy in (FILTERED, FREE, MODELS):
            ratios = self.ratios(policy, "pte_p90_m", PLAIN)
            densities |= ratios.keys()
            if ratios:
                parts.append(f"`{policy}` {spans([one.value for one in ratios.values()])}")
        if not parts:
            return ""
        at = listed(density_said(value) for value in sorted(densities))
        own = [one for one in self.settings if one.policy == PLAIN and one.density_per_km in densities]
        counts = [len(self.rows.by[one]) for one in own]
        of = f"p90 over that of `{PLAIN}` under the same timers, at {at} vehicles/km"
        return f"{of} ({spans(counts, 'd')} seeds): {listed(parts)}."

    def cut(self) -> str:
        """What is taken off p90 at each density, and whether that is much."""
        ratios = self.ratios(MODELS, "pte_p90_m", PLAIN)
        if not ratios:
            return ""
        cuts = {density: 1.0 - one.value for density, one in sorted(ratios.items())}
        each = listed(f"{100.0 * cut:.1f} % at {density_said(density)}" for density, cut in cuts.items())
        little = [density_said(density) for density, cut in cuts.items() if abs(cut) < SMALL_CUT]
        rest = ""
        if little:
            where = "at all of these" if len(little) == len(cuts) else f"at {listed(little)}"
            rest = f" Less than {100.0 * SMALL_CUT:.0f} % remains of it {where}."
        return f"`{MODELS}` takes off p90: {each}.{rest}"

    def models(self) -> str:
        """What models add to the free sub-model under the same timers."""
        ratios = self.ratios(MODELS, "pte_p90_m", FREE)
        if not ratios:
            return ""
        own = [one for one in self.settings if one.policy == MODELS]
        shares = [100.0 * mean_of(self.rows.values(one, "model_ratio")).value for one in own]
        return (
            f"Its p90 over that of `{FREE}`, which sends no model, is {verdicts(ratios)}. Of its messages "
            f"{spans(shares, '.1f')} % carry a model."
        )

    def fewer(self) -> list[str]:
        """Messages and p90 of those that send less."""
        lines: list[str] = []
        for policy in (RELAXED, ERROR_DRIVEN):
            messages = self.ratios(policy, "message_rate_hz", PLAIN)
            p90 = self.ratios(policy, "pte_p90_m", PLAIN)
            each = [
                f"{messages[at].value:.2f} of the messages and {one.value:.2f} of p90 at {density_said(at)}"
                for at, one in sorted(p90.items())
            ]
            if each:
                lines.append(f"`{policy}` over `{PLAIN}`: {listed(each)}.")
        return lines

    def rivals(self) -> list[str]:
        """What models add to the free sub-model where errors call for messages."""
        lines: list[str] = []
        for policy, rival in ((RELAXED, RELAXED_FREE), (ERROR_DRIVEN, ERROR_FREE)):
            messages = self.ratios(policy, "message_rate_hz", rival)
            p90 = self.ratios(policy, "pte_p90_m", rival)
            if messages:
                lines.append(
                    f"`{policy}` over `{rival}`, which sends no model: messages are {verdicts(messages)}; "
                    f"p90 is {verdicts(p90)}."
                )
        return lines

"""The blocks of the published network table: lines of Markdown from what its runs counted.

Everything here is arithmetic over kept runs: nothing is run, and nothing that was not run is said.
"""

from collections.abc import Iterable, Sequence
from itertools import product
from pathlib import Path

import numpy as np

from modelcast.core.version import package_version
from modelcast.station.sender.names import SENDERS
from network_table_cells import CALLS, RECEIVERS
from network_table_coverage import Coverage, coverage, expected_ratio
from network_table_rows import Found, Rows, Setting, density_said, listed, mean_of, spans
from network_table_sentences import headline_block

__all__ = ["PAGE", "blocks"]

PAGE = Path(__file__).parents[1] / "docs" / "network-table.md"
MACHINE = "2-core virtual machine, shared with other work, 2026-11-29"
PLAIN, RELAXED = "j2945", "j2945-mbc-relaxed"
AIM_BUSY_RATIO = 0.7
COVERED = {"messages": "message_rate_hz", "PTE p90": "pte_p90_m", "PTE p99": "pte_p99_m"}


def _table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    lines = [f"| {' | '.join(row)} |" for row in rows]
    return [f"| {' | '.join(heads)} |", "|" + "---|" * len(heads), *lines] if lines else ["Not run."]


RATIOS = (
    ("messages", "message_rate_hz"),
    ("bytes", "bytes_per_s"),
    ("CBR", "busy_ratio"),
    ("PTE p50", "pte_p50_m"),
    ("PTE p90", "pte_p90_m"),
    ("PTE p99", "pte_p99_m"),
)

ABSOLUTES = (
    ("messages/s", "message_rate_hz", ".2f", 1.0),
    ("bytes/s", "bytes_per_s", ".0f", 1.0),
    ("with model, %", "model_ratio", ".0f", 100.0),
    ("CBR, %", "busy_ratio", ".1f", 100.0),
    ("power, dBm", "power_dbm", ".1f", 1.0),
    ("collided, %", "collision_ratio", ".1f", 100.0),
    ("tracked, %", "held_ratio", ".1f", 100.0),
    ("PTE p50, cm", "pte_p50_m", ".2f", 100.0),
    ("PTE p90, cm", "pte_p90_m", ".2f", 100.0),
    ("PTE p99, cm", "pte_p99_m", ".1f", 100.0),
)


def _head(one: Setting) -> list[str]:
    return [density_said(one.density_per_km), f"`{one.radio}`", RECEIVERS[one.receiver], f"`{one.policy}`"]


HEADS = ("vehicles/km", "radio", "receiver", "sender", "seeds")


def ratio_table(rows: Rows, settings: Iterable[Setting]) -> list[str]:
    """Every sender over J2945/1's plain one, seed by seed."""
    lines: list[Sequence[str]] = []
    for one in settings:
        cells = [rows.ratio(one, figure, PLAIN) for _, figure in RATIOS]
        if one.policy != PLAIN and all(cell is not None for cell in cells):
            shared = len(rows.by[one].keys() & rows.by[one._replace(policy=PLAIN)].keys())
            said = [cell.said(".2f") for cell in cells if cell is not None]
            lines.append([*_head(one), str(shared), *said])
    return _table((*HEADS, *(name for name, _ in RATIOS)), lines)


def absolute_table(rows: Rows, settings: Iterable[Setting]) -> list[str]:
    """Every sender by itself."""
    heads = (*HEADS, *(name for name, *_ in ABSOLUTES))
    return _table(
        heads,
        (
            [
                *_head(one),
                str(len(rows.by[one])),
                *(
                    mean_of(rows.values(one, figure)).said(form, scale)
                    for _, figure, form, scale in ABSOLUTES
                ),
            ]
            for one in settings
        ),
    )


def run_block(found: Found, rows: Rows) -> list[str]:
    """What was run, with how many seeds."""
    lines: list[Sequence[str]] = []
    for kind in dict.fromkeys(call.kind for call in CALLS):
        asked = {cell._replace(seed=0) for call in CALLS if call.kind == kind for cell in call.cells()}
        own = [one for one in rows.by if one.cell(0) in asked]
        for radio in dict.fromkeys(one.radio for one in own):
            held = [one for one in own if one.radio == radio]
            lines.append([kind, f"`{radio}`", *_run_cells(rows, held)])
    minutes = sum(done.processor_s for done in found.values()) / 60.0
    states = len({done.sources for done in found.values()})
    of = "one state of the sources" if states == 1 else f"{states} states of the sources"
    note = (
        f"{len(found):,} runs, {minutes:,.0f} minutes of processor time, modelcast {package_version()}, {of}."
        f" {MACHINE}. A run that two calls ask for was made once, and counts in both lines."
    )
    heads = ("call", "radio", "senders", "receivers", "seeds at vehicles/km", "runs")
    return [*_table(heads, lines), "", note]


def _run_cells(rows: Rows, held: Sequence[Setting]) -> list[str]:
    """Senders, receivers, seeds by density (the fewest and most of any sender), and runs of some settings."""
    policies = (f"`{name}`" for name in SENDERS if any(one.policy == name for one in held))
    receivers = (said for name, said in RECEIVERS.items() if any(one.receiver == name for one in held))
    seeds: dict[str, list[str]] = {}
    for density in sorted({one.density_per_km for one in held}):
        counts = [len(rows.by[one]) for one in held if one.density_per_km == density]
        seeds.setdefault(spans(counts, "d"), []).append(density_said(density))
    said = "; ".join(f"{count} at {listed(at)}" for count, at in seeds.items())
    return [", ".join(policies), ", ".join(receivers), said, str(sum(len(rows.by[one]) for one in held))]


def radios_block(rows: Rows, settings: Sequence[Setting]) -> list[str]:
    """Every radio but 802.11p: what collides of even and of uneven messages, and the ratios."""
    lines: list[str] = []
    for radio in dict.fromkeys(one.radio for one in settings):
        said: list[str] = []
        for policy in (PLAIN, RELAXED):
            own = [one for one in settings if one.radio == radio and one.policy == policy]
            shares = {one: 100.0 * mean_of(rows.values(one, "collision_ratio")).value for one in own}
            each = [f"{share:.1f} % at {density_said(one.density_per_km)}" for one, share in shares.items()]
            said += [f"of `{policy}` {listed(each)}"] if each else []
        if said:
            lines.append(f"- `{radio}`, frames that collide: {'; '.join(said)}.")
    return [*lines, "", *ratio_table(rows, settings)] if lines else ["Not run."]


def loaded_block(rows: Rows) -> list[str]:
    """How busy the channel gets, and where power is lowered."""
    settings = rows.settings("loaded", lambda _: True, tuple(RECEIVERS))
    lines: list[str] = []
    for radio in dict.fromkeys(one.radio for one in settings):
        busy = {one: mean_of(rows.values(one, "busy_ratio")) for one in settings if one.radio == radio}
        best = max(busy, key=lambda one: busy[one].value)
        reached = "is reached" if busy[best].value >= AIM_BUSY_RATIO else "is not reached"
        lines.append(
            f"- `{radio}`: the greatest busy ratio is {busy[best].said('.2f')}, of `{best.policy}` at "
            f"{density_said(best.density_per_km)} vehicles/km; {AIM_BUSY_RATIO:g} {reached}."
        )
        each = [
            f"{busy[one].value:.2f} and {mean_of(rows.values(one, 'power_dbm')).value:.1f} dBm at "
            f"{density_said(one.density_per_km)}"
            for one in busy
            if one.policy == PLAIN
        ]
        if each:
            lines.append(f"  `{PLAIN}` holds itself to a busy ratio and a power of {listed(each)}.")
    if not lines:
        return ["Not run."]
    return [*lines, "", *absolute_table(rows, settings), "", *ratio_table(rows, settings)]


def coverage_block(rows: Rows) -> list[str]:
    """What intervals over few seeds hold."""
    lines: list[Sequence[str]] = []
    gathered: dict[int, list[Coverage]] = {}
    for one in rows.settings("highway", lambda radio: radio == "dsrc", ("default",)):
        figures = {name: rows.values(one, figure) for name, figure in COVERED.items()}
        if one.policy != PLAIN:
            figures["PTE p90, ratio"] = rows.ratios(one, "pte_p90_m", PLAIN)
        for (name, values), seeds in product(figures.items(), (3, 10)):
            if values.size < 4 * seeds or float(np.ptp(values)) == 0.0:
                continue
            got = coverage(values, seeds)
            gathered.setdefault(seeds, []).append(got)
            others, fresh = (expected_ratio(seeds, count) for count in (values.size - seeds, seeds))
            head = [density_said(one.density_per_km), f"`{one.policy}`", name, str(values.size), str(seeds)]
            cells = (f"{100 * got.others_ratio:.0f} ({100 * others:.0f})", f"{100 * got.fresh_ratio:.0f}")
            lines.append([*head, cells[0], f"{cells[1]} ({100 * fresh:.0f})", f"{got.narrowest_ratio:.2f}"])
    if not lines:
        return ["Not run."]
    heads = ("vehicles/km", "sender", "figure", "runs", "seeds", "hold the mean of the other runs, %")
    said = [_coverage_said(seeds, held) for seeds, held in sorted(gathered.items())]
    return [*said, "", *_table((*heads, "hold that of as many fresh seeds, %", "narrow"), lines)]


def _coverage_said(seeds: int, held: Sequence[Coverage]) -> str:
    """What intervals over so many seeds hold, over all figures."""
    others, fresh = ([one[column] for one in held] for column in (0, 1))
    narrow = [one.narrowest_ratio for one in held]
    return (
        f"- Intervals over {seeds} seeds held the mean of the other runs in {100 * np.mean(others):.0f} % of "
        f"draws on average ({spans([100 * one for one in others], '.0f')} % by figure), and that of {seeds} "
        f"fresh seeds in {100 * np.mean(fresh):.0f} % ({spans([100 * one for one in fresh], '.0f')} %). Of "
        f"normal runs it is 95 %, {100 * expected_ratio(seeds, seeds):.0f} % for {seeds} fresh seeds and "
        f"{100 * expected_ratio(seeds, 1):.0f} % for one. One in twenty is narrower than "
        f"{np.mean(narrow):.2f} of the mean width."
    )


def blocks(found: Found) -> dict[str, list[str]]:
    """Lines of Markdown by block of the page."""
    rows = Rows(found)
    plain = rows.settings("highway", lambda radio: radio == "dsrc", ("default",))
    others = rows.settings("highway", lambda radio: radio == "dsrc", list(RECEIVERS)[1:])
    radios = rows.settings("highway", lambda radio: radio != "dsrc", tuple(RECEIVERS))
    return {
        "network-table-runs": run_block(found, rows),
        "network-table-headline": headline_block(rows),
        "network-table-against": ratio_table(rows, plain),
        "network-table-receivers": ratio_table(rows, others),
        "network-table-radios": radios_block(rows, radios),
        "network-table-loaded": loaded_block(rows),
        "network-table-coverage": coverage_block(rows),
        "network-table-all": absolute_table(rows, [*plain, *others, *radios]),
    }

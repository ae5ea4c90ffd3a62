"""Claims about tables and figures of a network evaluation: how several banks are told apart."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
import pytest
from matplotlib import rcParams
from matplotlib.axes import Axes
from matplotlib.markers import MarkerStyle
from rich.console import Console

from made_rows import filled
from modelcast.report.figures.files import drawn
from modelcast.report.figures.network import NETWORK_FIGURES, plot_load
from modelcast.report.figures.senders import Curve, sender_curves, sender_look
from modelcast.report.network import network_console, network_markdown
from modelcast.report.network_findings import network_findings
from modelcast.report.style import style
from modelcast.station.sender.names import SENDERS as SENDER_NAMES
from modelcast.study.network.pool import gather
from modelcast.study.network.rows import (
    DISTANCES,
    POOLED,
    RUNS,
    SECONDS,
    SENDERS,
    CaseResult,
    NetworkCase,
    NetworkResult,
)
from modelcast.study.table import Row, TableSchema

POLICIES = ("j2945", "mbc", "j2945-mbc")


def row(kind: TableSchema, case: NetworkCase, **own: float) -> Row:
    """A row of a run with every number the same, and different from that of every other sender."""
    value = 0.01 * (1 + len(case.policy) + 2 * len(case.bank) + 0.1 * case.run)
    return filled(kind, value, **case.values(), **own)


def result(*banks: str, policies: Sequence[str] = POLICIES, **own: float) -> NetworkResult:
    """Two radios, two densities, two seeds; mbc and j2945-mbc with each bank."""
    found: list[CaseResult] = []
    for density, radio, policy, run in product((25.0, 100.0), ("dsrc", "sidelink"), policies, (0, 1)):
        for bank in banks if "mbc" in policy else ("none",):
            case = NetworkCase(density, radio, policy, bank, run)
            found.append(
                CaseResult(
                    row(RUNS, case, identification_rate_hz=0.25 if bank == "paper" else 0.0, **own),
                    [row(DISTANCES, case, low_m=low_m, high_m=low_m + 25.0, **own) for low_m in (0.0, 25.0)],
                    outcomes=[],
                    seconds=[row(SECONDS, case, t_s=t_s, **own) for t_s in (1.0, 2.0)],
                )
            )
    senders = [
        SENDERS.row(policy="mbc", bank=bank, sub_models="cv", start="order", identify="never")
        for bank in banks
    ]
    return gather(found, senders)


def heads(result: NetworkResult) -> list[str]:
    line = next(line for line in network_markdown(result).splitlines() if line.startswith("| density"))
    return [cell.strip() for cell in line.strip("|").split("|")]


def shown(result: NetworkResult, width: int = 80) -> str:
    console = Console(width=width, record=True, markup=False, emoji=False)
    with console.capture() as captured:
        console.print(network_console(result))
    return captured.get()


def test_banks_are_a_column_only_where_there_are_several() -> None:
    assert heads(result("default"))[:4] == ["density", "radio", "policy", "seeds"]
    assert heads(result("default", "paper"))[:5] == ["density", "radio", "policy", "bank", "seeds"]
    assert "default" not in shown(result("default"))
    text = shown(result("default", "paper"))
    for name in ("mbc, default", "mbc, paper", "j2945-mbc, paper", "sidelink, 100/km"):
        assert name in text
    assert "none" not in text.partition("Vehicles a kilometre at")[0]


def test_identifications_stand_beside_updates() -> None:
    found = result("default", "paper")
    names = heads(found)
    place = names.index("updates [1/s]")
    assert names[place + 1] == "identifications [1/s]"
    rows = [line.split("|")[1:-1] for line in network_markdown(found).splitlines() if "| mbc |" in line]
    cells = {cells[3].strip(): cells[place + 1].strip() for cells in rows if len(cells) == len(names)}
    assert cells["paper"].startswith("0.250 ±")
    assert cells["default"].startswith("0 ±")
    assert "identif." in shown(found)


def with_values(found: NetworkResult, **by_policy: tuple[float, float]) -> NetworkResult:
    """The same with messages a second and errors by policy, of intervals of a tenth."""
    places = {"message_rate_hz": 0, "pte_p90_m": 1}

    def made(row: Row) -> Row:
        if row.figure not in places:
            return row
        value = by_policy[row.policy.replace("-", "_")][places[row.figure]]
        return row.replaced(value=value, low=value - 0.05, high=value + 0.05)

    return replace(found, pooled=POOLED.table(made(row) for row in found.pooled))


def free_result() -> NetworkResult:
    """Four senders with made-up figures: models send fewer than the baseline, and more than the free one."""
    names = {"mbc": (1.1, 0.52), "free": (1.0, 0.5), "baseline": (2.0, 1.0), "j2945_mbc": (5.0, 0.2)}
    found = result("default", policies=[name.replace("_", "-") for name in names])
    return with_values(found, **names)


def test_models_are_first_held_against_what_differs_in_the_model_alone() -> None:
    found, missed, data = (
        text for _, text in network_findings(free_result(), {"scenario": "highway", "duration_s": 60.0})
    )
    assert "mbc sent more messages than free (1.10 times as many)" in found
    assert "with an error larger than its (1.04 times as large)" in found
    assert "mbc sent fewer messages than baseline (0.55 times as many)" in found
    assert "the error of mbc was larger than free's in all 4" in missed
    assert "and intervals over the seeds overlap in all 4" in missed
    assert "j2945-mbc was not held against a free receiver by the same rules" in missed
    assert data == "traffic highway, generated by a program, not recorded; 2 seeds, 60 s each."


@pytest.mark.parametrize(
    ("policies", "said", "unsaid"),
    [
        (("j2945", "j2945-mbc"), "messages as unfiltered j2945 (", "free"),
        (("j2945", "j2945-filtered", "j2945-mbc"), "messages as j2945-filtered (", "unfiltered"),
        (("j3161:grant=any", "j3161-mbc:grant=any"), "messages as unfiltered j3161:grant=any (", "free"),
        (("j2945", "j2945-free-relaxed", "j2945-mbc-relaxed"), "messages as j2945-free-relaxed (", "j2945 ("),
        (("j2945", "j2945-mbc-relaxed-5"), "no rival was run", "messages"),
        (("baseline", "mbc"), "messages as baseline (", "unfiltered"),
    ],
    ids=str,
)
def test_a_plain_rival_has_the_sender_s_timers_and_what_it_does_not_share_is_told(
    policies: Sequence[str], said: str, unsaid: str
) -> None:
    made = result("default", policies=policies)
    alike = POOLED.table(
        row.replaced(value=1.0) if row.figure == "message_rate_hz" else row for row in made.pooled
    )
    found = network_findings(replace(made, pooled=alike))[0][1]
    assert said in found
    assert unsaid not in found


def without_errors(found: NetworkResult, policy: str, *, at: float | None = None) -> NetworkResult:
    """The same without this policy's errors at one density, or at all."""

    def made(row: Row) -> Row:
        gone = row.policy == policy and row.figure == "pte_p90_m" and at in {None, row.density_per_km}
        return row.replaced(value=np.nan, low=None, high=None) if gone else row

    return replace(found, pooled=POOLED.table(made(row) for row in found.pooled))


def test_errors_that_were_not_measured_hide_no_messages_and_are_not_counted() -> None:
    found, missed = (text for _, text in network_findings(without_errors(free_result(), "mbc")))
    assert "mbc sent more messages than free (1.10 times as many); mbc sent fewer messages" in found
    assert "percentile" not in found
    assert "no error of mbc was measured beside free's" in missed
    assert "all 0" not in missed
    assert "One seed" not in missed
    found, missed = (text for _, text in network_findings(without_errors(free_result(), "free", at=25.0)))
    assert "mbc sent more messages than free (1.10 times as many) with an error larger than its" in found
    assert "larger than free's in all 2, and intervals over the seeds overlap in all 2" in missed
    silent = with_values(
        without_errors(free_result(), "mbc"),
        mbc=(1.0, np.nan),
        free=(0.0, 0.5),
        baseline=(0.0, 1.0),
        j2945_mbc=(5.0, 0.2),
    )
    assert network_findings(silent)[0][1] == "j2945-mbc, mbc: nothing was measured beside a rival."
    alone = result("default", policies=["mbc"])
    assert network_findings(alone)[0][1] == "mbc: no rival was run beside them."


def test_cases_count_thresholds_where_there_are_several() -> None:
    found: list[CaseResult] = []
    for policy, threshold_m, run in product(("free", "mbc"), (0.2, 0.5), (0, 1)):
        case = NetworkCase(25.0, "dsrc", policy, "none", run, threshold_m=threshold_m)
        found.append(CaseResult(row(RUNS, case), [], outcomes=[], seconds=[]))
    said, missed = (text for _, text in network_findings(gather(found)))
    assert said.startswith("Over all densities, radios and thresholds, by the 90th percentile: ")
    assert missed.startswith("Of the cases (densities, radios and thresholds), ")
    assert "free's in none of 2" in missed
    assert "densities and radios" in network_findings(free_result())[0][1]


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"scenarios": ["Replay", "Replay", "Highway"]}, "traffic Replay, Highway; 2 seeds, 30 s each."),
        (
            {"scenario": "platoon", "trips": ["a.csv"]},
            "traffic platoon, recorded trips (a.csv); 2 seeds, at most 30 s each.",
        ),
        (
            {"scenario": "fcd.xml"},
            "traffic fcd.xml, simulated or read from a file, not generated here; 2 seeds, at most 30 s each.",
        ),
        (
            {"scenario": "trips", "trips": ["a.csv"]},
            "traffic trips, recorded trips (a.csv); 2 seeds, 30 s each.",
        ),
    ],
    ids=str,
)
def test_traffic_is_told_by_what_is_known_of_it(options: dict[str, Any], said: str) -> None:
    assert network_findings(free_result(), {**options, "duration_s": 30.0})[-1] == ("Data", said)


def test_what_was_found_stands_before_the_table_and_nothing_is_said_without_models() -> None:
    text = network_markdown(free_result(), options={"scenario": "trips", "trips": ["a.csv"]})
    assert text.index("**Found.**") < text.index("**Not found.**") < text.index("| density")
    assert "recorded trips (a.csv)" in text
    assert shown(free_result()).startswith("Found: ")
    assert network_findings(result("default", policies=["j2945", "cam"])) == []


def test_a_terminal_of_80_columns_cuts_no_name_and_no_number() -> None:
    """Nothing is shortened, and names stand in one piece."""
    text = shown(result("default", "paper"))
    assert "…" not in text
    assert max(map(len, text.splitlines())) <= 80


def test_a_bank_s_name_is_no_markup() -> None:
    text = network_markdown(result("default", "a|b<c>.json"))
    assert "a\\|b&lt;c>.json" in text
    assert "a|b" not in text


def looks(axes: Axes) -> dict[str, tuple[Any, ...]]:
    """Colour and line of every curve by its label."""
    curves = [line for line in axes.get_lines() if not str(line.get_label()).startswith("_")]
    return {str(line.get_label()): (line.get_color(), line.get_linestyle()) for line in curves}


@pytest.mark.parametrize("name", NETWORK_FIGURES)
def test_every_sender_has_a_curve_of_its_own_in_every_panel(name: str) -> None:
    with style():
        figure = NETWORK_FIGURES[name][1](result("default", "paper"))
    wanted = {"j2945", "mbc, default", "mbc, paper", "j2945-mbc, default", "j2945-mbc, paper"}
    assert [text.get_text() for text in figure.legends[0].get_texts()] == list(looks(figure.axes[0]))
    for axes in figure.axes:
        found = looks(axes)
        assert set(found) == wanted
        assert len(set(found.values())) == len(wanted)


@pytest.mark.parametrize("name", NETWORK_FIGURES)
def test_with_one_bank_curves_bear_the_policy_alone(name: str) -> None:
    with style():
        figure = NETWORK_FIGURES[name][1](result("default"))
    assert set(looks(figure.axes[0])) == set(POLICIES)


@pytest.mark.slow
@pytest.mark.parametrize("name", NETWORK_FIGURES)
def test_figures_are_drawn_where_nothing_was_tracked(name: str) -> None:
    with style():
        drawing = drawn(name, NETWORK_FIGURES[name][1](result("paper", pte_p90_m=np.nan)))
    assert drawing.name == name


def test_a_figure_of_the_interface_is_in_modelcast_s_style_whatever_matplotlib_s_is() -> None:
    figure = plot_load(result("default"))
    assert {axes.yaxis.label.get_fontsize() for axes in figure.axes} == {7.5}
    assert rcParams["axes.labelsize"] != 7.5


def test_a_log_axis_ends_near_its_values_however_wide_an_interval_is() -> None:
    with style():
        figure = NETWORK_FIGURES["tracking_density"][1](result("default", "paper"))
    curves = [np.asarray(line.get_ydata(), dtype=np.float64) for line in figure.axes[0].get_lines()]
    least = min(float(curve.min()) for curve in curves)
    assert figure.axes[0].get_ylim()[0] == pytest.approx(0.5 * least)


def test_thresholds_are_told_apart_in_words_and_curves() -> None:
    found: list[CaseResult] = []
    for policy, threshold_m, run in product(("baseline", "mbc"), (0.2, 0.3, 0.4, 0.5), (0, 1)):
        bank = "paper" if policy == "mbc" else "none"
        case = NetworkCase(25.0, "dsrc", policy, bank, run, threshold_m=threshold_m)
        found.append(CaseResult(row(RUNS, case), [], outcomes=[], seconds=[]))
    one_bank = gather(found)
    assert heads(one_bank)[:5] == ["density", "radio", "policy", "threshold", "seeds"]
    assert "mbc, 30 cm" in shown(one_bank)
    curves = sender_curves(one_bank)
    assert [curve.label for curve in curves] == [
        f"{policy}, {cm} cm" for policy in ("baseline", "mbc") for cm in (20, 30, 40, 50)
    ]
    assert [sum(map(curve.drew, one_bank.runs)) for curve in curves] == [2] * 8


def test_no_two_lines_of_a_policy_look_alike() -> None:
    looks = [Curve("mbc", "paper", 0.2, "", place).plain for place in range(12)]
    assert len({(str(look["color"]), str(look["linestyle"])) for look in looks}) == 12


UNUSUAL = (
    "another-package",
    "cam-road",
    "mbc",
    "j3161:power_control=no",
    "j3161:power_control=yes",
    "j3161",
    "third:edge=2",
    "baseline+mbc@25",
)


def unusual_result() -> NetworkResult:
    """Senders with settings, of other packages, and of a mixed fleet."""
    found = [
        CaseResult(row(RUNS, case), [row(DISTANCES, case, low_m=0.0, high_m=25.0)], outcomes=[], seconds=[])
        for density, policy in product((25.0, 100.0), UNUSUAL)
        for case in (NetworkCase(density, "dsrc", policy, "none", 0),)
    ]
    return gather(found)


def test_every_policy_of_a_result_has_a_curve_of_its_own() -> None:
    every = unusual_result()
    curves = sender_curves(every)
    assert [curve.policy for curve in curves[:3]] == ["mbc", "j3161", "cam-road"]
    assert sorted(curve.policy for curve in curves) == sorted(UNUSUAL)
    assert [sum(map(curve.drew, every.runs)) for curve in curves] == [2] * len(UNUSUAL)
    looks = [(curve.colour, str(curve.plain["linestyle"])) for curve in curves]
    assert len(set(looks)) == len(UNUSUAL)
    with style():
        figure = NETWORK_FIGURES["load"][1](every)
    assert {str(line.get_label()) for line in figure.axes[0].get_lines()} == set(UNUSUAL)


def test_all_senders_of_ours_have_a_look_of_their_own() -> None:
    looks = [sender_look(name) for name in SENDER_NAMES]
    assert len(looks) == len({colour for colour, _ in looks}) == len({marker for _, marker in looks})
    assert all(MarkerStyle(marker).is_filled() for _, marker in looks)
    assert sender_look("no-such")[0] not in {colour for colour, _ in looks}

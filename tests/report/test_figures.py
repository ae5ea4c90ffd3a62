"""The figures draw what they are given, whatever a result holds."""

from collections.abc import Callable
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from matplotlib import rcParams
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.text import Text

from modelcast.report.captions import captions
from modelcast.report.figures import (
    FIGURES,
    plot_distribution,
    plot_loss,
    plot_manoeuvre,
    plot_rates,
    plot_timeline,
    plot_trips,
    write_figures,
)
from modelcast.report.figures.coverage import plot_coverage, plot_times
from modelcast.report.figures.files import ENDINGS
from modelcast.report.figures.senders import sender_look
from modelcast.report.figures.trips import MOST_ROWS
from modelcast.report.headline import SAME_RATE, SAME_THRESHOLD
from modelcast.report.style import POLICY_COLOURS, POLICY_LINES, POLICY_MARKERS, model_colours, style
from modelcast.study.coverage import COVERAGE, FORMS, TIMES
from modelcast.study.result import RATES, REFERENCES, TRACKING, EvaluationResult
from modelcast.study.table import Table, TableSchema

Make = Callable[..., EvaluationResult]

_TOUCH_PX = 0.5
"""Texts may touch: extents are rounded outwards to whole pixels."""


def draw_all(result: EvaluationResult) -> None:
    """Draw every figure without writing it: warnings are errors here."""
    with style():
        for plot in FIGURES.values():
            plot(result).draw_without_rendering()


def test_bar_heights_are_the_pooled_rates(make_result: Make) -> None:
    result = make_result()
    axes = plot_rates(result).axes[0]
    rows = {(row.policy, row.threshold_m): row for row in result.rates if row.trip == "all"}
    updates, identifications, free, baseline = axes.containers
    for at, threshold in enumerate((0.2, 0.3, 0.4, 0.5)):
        mbc = rows["mbc", threshold]
        assert updates[at].get_height() == mbc.update_rate_hz
        assert identifications[at].get_y() == mbc.update_rate_hz
        assert identifications[at].get_height() == pytest.approx(mbc.identification_rate_hz)
        assert free[at].get_height() == rows["free", threshold].total_rate_hz
        assert baseline[at].get_height() == rows["baseline", threshold].total_rate_hz


def test_the_panel_below_shows_the_airtime_of_all(make_result: Make) -> None:
    result = make_result()
    rows = {(row.policy, row.threshold_m): row for row in result.rates if row.trip == "all"}
    bars = plot_rates(result).axes[1].containers
    for own, policy in zip(bars, ("mbc", "free", "baseline"), strict=True):
        for at, threshold in enumerate((0.2, 0.3, 0.4, 0.5)):
            assert own[at].get_height() == 1000 * rows[policy, threshold].airtime_per_s


def with_references(result: EvaluationResult, cam_hz: float) -> EvaluationResult:
    references = [
        REFERENCES.row(
            trip=trip,
            reference=name,
            threshold_m=threshold_m,
            messages=60,
            least_messages=60,
            duration_s=600.0,
            rate_hz=rate_hz * (1.0 if trip == "all" else 9.0),
            undecided=0,
        )
        for trip in ("all", "kerbside/1")
        for name, threshold_m, rate_hz in (
            *(("clairvoyant-2", th, 0.5 - th / 2) for th in (0.2, 0.3, 0.4, 0.5)),
            ("cam", None, cam_hz),
        )
    ]
    return replace(result, references=REFERENCES.table(references))


def test_reference_lines_lie_at_the_pooled_rates_and_are_named(make_result: Make) -> None:
    figure = plot_rates(with_references(make_result(), 1.8))
    axes = figure.axes[0]
    drawn = axes.collections[-1].get_segments()
    assert [line[0][1] for line in drawn] == pytest.approx([0.4, 0.35, 0.3, 0.25])
    assert axes.get_lines()[-1].get_ydata() == pytest.approx([1.8, 1.8])
    names = [text.get_text() for text in figure.legends[0].get_texts()]
    assert names[-2:] == ["ETSI CAM rules", "Known future, degree 2"]


def test_a_reference_off_the_scale_is_told_and_no_legend_names_it(make_result: Make) -> None:
    figure = plot_rates(with_references(make_result(), 9.0))
    assert figure.axes[0].get_title(loc="right") == "ETSI CAM rules: 9.00/s, off the scale"
    names = [text.get_text() for text in figure.legends[0].get_texts()]
    assert "ETSI CAM rules" not in names
    assert figure.axes[0].get_ylim()[1] < 9.0


def test_distribution_curves_are_the_ecdfs_at_the_nearest_ratio(make_result: Make) -> None:
    result = make_result(ratios=(0.0, 0.3, 0.6))
    panels = plot_distribution(result).axes
    assert [axes.get_title() for axes in panels[:2]] == ["Same threshold, 20 cm", "Same rate, 20 cm"]
    curve = next(
        item
        for item in result.ecdfs
        if (item.policy, item.rate_basis, item.threshold_m, item.packet_error_ratio)
        == ("baseline-matched", "total", 0.3, 0.3)
    )
    line = next(item for item in panels[3].get_lines() if item.get_color() == POLICY_COLOURS[curve.policy])
    np.testing.assert_array_equal(line.get_xdata(), curve.tracking_error_m)
    np.testing.assert_array_equal(line.get_ydata(), curve.probability)


def test_loss_curves_are_the_pooled_rows_in_percent(make_result: Make) -> None:
    result = make_result()
    panels = plot_loss(result).axes
    assert {axes.get_yscale() for axes in panels} == {"log"}
    axes = panels[7]
    rows = [
        row
        for row in result.tracking
        if (row.trip, row.policy, row.rate_basis, row.threshold_m)
        == ("all", "baseline-periodic", "total", 0.5)
    ]
    line = next(x for x in axes.get_lines() if x.get_color() == POLICY_COLOURS["baseline-periodic"])
    np.testing.assert_allclose(line.get_xdata(), [0, 20, 40, 60])
    np.testing.assert_array_equal(line.get_ydata(), [row.pte_p90_m for row in rows])
    assert len(axes.collections) == 4, "the bars of one policy each"
    assert "MBC 1.40, free 1.40, baseline 1.40" in panels[6].get_title(), "what that reading costs"


def test_both_readings_stand_side_by_side_with_the_free_receiver_in_each(make_result: Make) -> None:
    result = make_result()
    for plot in (plot_loss, plot_distribution):
        panels = plot(result).axes
        for axes, roles in ((panels[0], SAME_THRESHOLD), (panels[1], SAME_RATE)):
            drawn = {line.get_color() for line in axes.get_lines()}
            assert drawn >= {POLICY_COLOURS[role] for role in roles}


def test_limits_over_seeds_are_taken_on_the_logarithm(make_result: Make) -> None:
    """Limits of -1 m to 5 m are exp(3 m / 2 m) about 2 m: none reaches zero, where a logarithm ends."""
    result = make_result(thresholds=(0.2,))
    rows = [row.replaced(pte_p90_low_m=-1.0, pte_p90_high_m=5.0) for row in result.tracking]
    figure = plot_loss(replace(result, tracking=TRACKING.table(rows)))
    bars = figure.axes[0].collections[0].get_paths()
    for bar in bars:
        np.testing.assert_allclose(bar.vertices[:, 1], [2.0 / np.exp(1.5), 2.0 * np.exp(1.5)])


def test_one_seed_has_no_bars(make_result: Make) -> None:
    assert not plot_loss(make_result(seeds=1)).axes[0].collections


def test_timeline_shows_every_error_and_every_message(make_result: Make) -> None:
    result = make_result()
    timeline = result.timeline
    assert timeline is not None
    errors, strips = plot_timeline(result).axes
    for at in range(2):
        np.testing.assert_array_equal(errors.get_lines()[at].get_ydata(), timeline.tracking_error_m[:, at])
    updates, identifications = strips.collections[-2:]
    assert len(updates.get_segments()) == timeline.update_s.size
    assert len(identifications.get_segments()) == timeline.identification_s.size


def test_strips_cover_the_time_under_the_threshold(make_result: Make) -> None:
    result = make_result()
    timeline = result.timeline
    assert timeline is not None
    first = plot_timeline(result).axes[1].collections[0]
    shown_s = sum(np.ptp(path.vertices[:, 0]) for path in first.get_paths())
    holds = timeline.tracking_error_m[:, 0] < timeline.threshold_m
    assert shown_s == pytest.approx(0.1 * holds.sum())


def test_long_timelines_keep_their_largest_errors(make_result: Make) -> None:
    result = make_result(steps=9000)
    assert result.timeline is not None
    line = plot_timeline(result).axes[0].get_lines()[0]
    assert len(line.get_ydata()) == 1000
    assert np.nanmax(line.get_ydata()) == np.nanmax(result.timeline.tracking_error_m[:, 0])


def test_map_is_in_metres_from_the_start_with_equal_axes(make_result: Make) -> None:
    result = make_result()
    manoeuvre = result.manoeuvre
    assert manoeuvre is not None
    axes = plot_manoeuvre(result).axes[0]
    assert axes.get_aspect() == 1.0
    truth = np.stack(axes.get_lines()[0].get_data(), axis=1)
    np.testing.assert_allclose(truth, manoeuvre.truth_m - manoeuvre.history_m[-1])


def test_the_map_is_cut_to_the_path_that_was_driven(make_result: Make) -> None:
    """A prediction that runs away 100 times as far makes the map no wider."""
    result = make_result()
    found = result.manoeuvre
    assert found is not None
    away = replace(found, predicted_m={name: 100.0 * path for name, path in found.predicted_m.items()})
    limits = [
        (axes.get_xlim(), axes.get_ylim())
        for axes in (plot_manoeuvre(replace(result, manoeuvre=one)).axes[0] for one in (found, away))
    ]
    assert limits[0] == limits[1]
    driven_m = np.concatenate([found.history_m, found.truth_m]) - found.history_m[-1]
    for axis, (low, high) in enumerate(limits[0]):
        assert low < driven_m[:, axis].min()
        assert high > driven_m[:, axis].max()


def test_a_timeline_without_identifications_has_no_row_for_them(make_result: Make) -> None:
    result = make_result()
    assert result.timeline is not None
    bare = replace(result.timeline, identification_s=np.array([]))
    rows = [
        [label.get_text() for label in plot_timeline(replace(result, timeline=one)).axes[1].get_yticklabels()]
        for one in (result.timeline, bare)
    ]
    assert rows[0] == [*rows[1], "Identifications"]
    assert rows[1][-1] == "Updates"


def test_the_free_sub_model_has_the_colour_of_the_free_receiver() -> None:
    colours = model_colours(["free-predictive", "free", "ctra", "cv"])
    assert colours["free"] == POLICY_COLOURS["free"]
    assert len(set(colours.values())) == 4


@pytest.mark.slow
def test_trips_are_one_row_each_until_they_are_too_many(make_result: Make) -> None:
    few = plot_trips(make_result(trips=[f"t/{k}" for k in range(MOST_ROWS)], ratios=(0.4,)))
    assert len(few.axes[0].get_yticks()) == MOST_ROWS
    many = plot_trips(make_result(trips=[f"t/{k}" for k in range(MOST_ROWS + 1)], ratios=(0.4,)))
    assert many.axes[0].get_ylabel() == f"Share of {MOST_ROWS + 1} trips"


@pytest.mark.parametrize(
    "options",
    [
        pytest.param({"thresholds": (0.5,)}, marks=pytest.mark.slow),
        pytest.param({"ratios": (0.0,)}, marks=pytest.mark.slow),
        pytest.param({"trips": ("only/1",)}, marks=pytest.mark.slow),
        pytest.param({"seeds": 1}, marks=pytest.mark.slow),
        {"timeline": False, "manoeuvre": False},
        {"thresholds": (0.5,), "ratios": (0.4,), "trips": ("only/1",), "seeds": 1, "timeline": False},
        pytest.param({"thresholds": tuple(k / 20 for k in range(1, 13))}, marks=pytest.mark.slow),
        pytest.param({"thresholds": (0.1, 0.2, 0.3, 0.4, 0.5)}, marks=pytest.mark.slow),
        pytest.param({"steps": 1}, marks=pytest.mark.slow),
        {"trips": ("路/$1$", "a" * 200, "__{}\\frac")},
    ],
    ids=str,
)
def test_every_figure_draws_for(make_result: Make, options: dict[str, object]) -> None:
    draw_all(make_result(**options))


def test_every_figure_draws_for_a_result_without_rows(make_result: Make) -> None:
    empty = replace(
        make_result(timeline=False, manoeuvre=False),
        trips=(),
        rates=RATES.table(),
        tracking=TRACKING.table(),
        ecdfs=(),
    )
    draw_all(empty)


def crossing(figure: Figure) -> list[tuple[str, str]]:
    """Pairs of texts of a figure, laid out and drawn, that lie upon each other."""
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    hidden = {
        label
        for axes in figure.axes
        for axis in (axes.xaxis, axes.yaxis)
        for tick in (*axis.get_major_ticks(), *axis.get_minor_ticks())
        for label in (tick.label1, tick.label2)
        # Marks beyond the limits of their axis are kept and not drawn.
        if not min(axis.get_view_interval()) <= tick.get_loc() <= max(axis.get_view_interval())
    }
    boxes = [
        (text.get_text(), text.get_window_extent(canvas.get_renderer()).padded(-_TOUCH_PX))
        for text in figure.findobj(Text)
        if isinstance(text, Text) and text.get_visible() and text.get_text().strip() and text not in hidden
    ]
    return [(one, other) for (one, box), (other, at) in combinations(boxes, 2) if box.overlaps(at)]


@pytest.mark.parametrize(
    "options",
    [
        pytest.param({}, id="four thresholds"),
        pytest.param({"thresholds": (0.5,)}, id="one", marks=pytest.mark.slow),
        pytest.param({"thresholds": tuple(k / 10 for k in range(1, 8))}, id="seven", marks=pytest.mark.slow),
        pytest.param({"trips": ("only/1",)}, id="one trip"),
    ],
)
def test_no_two_texts_of_a_figure_cross(make_result: Make, options: dict[str, object]) -> None:
    result = with_references(make_result(**options), 9.0)
    with style():
        for name, plot in FIGURES.items():
            assert not crossing(plot(result)), name


def test_crossing_texts_are_found(make_result: Make) -> None:
    with style():
        figure = plot_rates(make_result())
        figure.axes[0].text(0.5, 0.5, "one", transform=figure.axes[0].transAxes)
        figure.axes[0].text(0.5, 0.5, "other", transform=figure.axes[0].transAxes)
        assert ("one", "other") in crossing(figure)


def test_a_trip_alone_has_its_whole_name_and_trips_of_one_file_the_rest(make_result: Make) -> None:
    for trips, shown in ((("drive/0",), ["drive/0"]), (("drive/0", "drive/1"), ["0", "1"])):
        axes = plot_trips(make_result(trips=trips)).axes[0]
        assert sorted(label.get_text() for label in axes.get_yticklabels()) == shown


def test_all_details_are_shown_at_one_threshold(make_result: Make) -> None:
    """The one asked for, else the first."""
    plain = make_result()
    asked = replace(plain, settings={**plain.settings, "detail_threshold_m": 0.4})
    for result, shown in ((plain, "20 cm"), (asked, "40 cm")):
        assert f"Threshold {shown}" in plot_trips(result).axes[0].get_title()
        assert sum(shown in text for text in captions(result).values()) == 3


def test_a_caption_says_where_thresholds_are_left_out(make_result: Make) -> None:
    many = captions(make_result(thresholds=tuple(k / 10 for k in range(1, 8))))["tracking_loss"]
    assert "Of 7 thresholds 4 are drawn" in many
    assert "are drawn" not in captions(make_result())["tracking_loss"]


def test_undefined_values_leave_holes_not_errors(make_result: Make) -> None:
    result = make_result()
    nan = float("nan")
    rows = tuple(
        row.replaced(pte_p90_m=nan, pte_p90_low_m=None, pte_p90_high_m=None) for row in result.tracking
    )
    curves = tuple(replace(curve, tracking_error_m=curve.tracking_error_m * nan) for curve in result.ecdfs)
    draw_all(replace(result, tracking=TRACKING.table(rows), ecdfs=curves))


def test_one_trip_without_pooled_rows_stands_for_all(make_result: Make) -> None:
    result = make_result(trips=("only/1",))
    alone = replace(result, rates=RATES.table(row for row in result.rates if row.trip != "all"))
    assert plot_rates(alone).axes[0].containers


@pytest.mark.slow
def test_files_are_the_same_twice_and_name_no_date(make_result: Make, tmp_path: Path) -> None:
    first = write_figures(make_result(), tmp_path / "a")
    second = write_figures(make_result(), tmp_path / "b")
    assert len(first) == len(ENDINGS) * len(FIGURES)
    for one, other in zip(first, second, strict=True):
        assert one.read_bytes() == other.read_bytes()
    svg = next(path for path in first if path.suffix == ".svg").read_text(encoding="utf-8")
    assert "<dc:date>" not in svg
    assert "Matplotlib" not in svg
    pdf = next(path for path in first if path.suffix == ".pdf").read_bytes()
    assert pdf.startswith(b"%PDF")
    for told in (b"CreationDate", b"Matplotlib", b"/Type3"):
        assert told not in pdf


def test_the_users_own_parameters_are_neither_used_nor_changed(
    make_result: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(rcParams, "axes.facecolor", "black")
    assert plot_rates(make_result()).axes[0].get_facecolor() == (1.0, 1.0, 1.0, 1.0)
    assert rcParams["axes.facecolor"] == "black"


@pytest.mark.parametrize("count", [0, 1, 2, 4, 5])
def test_coverage_draws_a_panel_for_every_sub_model(count: int) -> None:
    rows = [
        COVERAGE.row(
            sub_model=f"model-{m}",
            form=form,
            horizon_s=horizon_s,
            level=level,
            covered_ratio=0.9 * level,
            errors=9,
        )
        for m in range(count)
        for form in FORMS
        for horizon_s in (0.5, 2.0)
        for level in (0.5, 0.9, 0.95)
    ]
    figure = plot_coverage(rows)
    with style():
        figure.draw_without_rendering()
    shown = [axes for axes in figure.axes if axes.axison]
    assert [axes.get_title() for axes in shown] == [f"model-{m}" for m in range(count)]
    for axes in shown:
        drawn = [line for line in axes.lines if len(line.get_xdata()) == 2 and line.get_marker() != "None"]
        assert [line.get_ydata()[0] for line in drawn] == pytest.approx([45.0] * 3 + [81.0] * 3 + [85.5] * 3)


@pytest.mark.parametrize("count", [0, 1, 3])
def test_times_draw_what_was_observed_and_what_every_ellipse_expects(count: int) -> None:
    rows = [
        TIMES.row(
            sub_model=f"model-{m}",
            form=form,
            threshold_m=threshold_m,
            expected_s=1.0 + at,
            observed_s=2.0 + m,
            rank_correlation=0.1,
            instants=9,
        )
        for m in range(count)
        for at, form in enumerate(FORMS)
        for threshold_m in (0.2, 0.5)
    ]
    figure = plot_times(rows)
    with style():
        figure.draw_without_rendering()
    if not count:
        return
    assert [axes.get_title() for axes in figure.axes] == ["until 20 cm", "until 50 cm"]
    for axes in figure.axes:
        widths = [bar.get_width() for bar in axes.patches if isinstance(bar, Rectangle)]
        assert widths == [2.0 + m for m in range(count)]
        assert [list(line.get_xdata()) for line in axes.lines] == [[1.0 + at] * count for at in range(3)]


def test_legends_name_the_policy_that_decides(make_result: Make) -> None:
    """The same curves and bars as ever, under its name."""
    plain = make_result()

    def called(rows: Table, schema: TableSchema) -> Table:
        return schema.table(
            row.replaced(policy=row.policy.replace("mbc", "soon:ahead_s=$1$")) for row in rows
        )

    foreign = replace(
        plain,
        settings={**plain.settings, "decided_by": "soon:ahead_s=$1$"},
        rates=called(plain.rates, RATES),
        tracking=called(plain.tracking, TRACKING),
        ecdfs=tuple(
            replace(one, policy=one.policy.replace("mbc", "soon:ahead_s=$1$")) for one in plain.ecdfs
        ),
    )
    for plot in (plot_rates, plot_distribution, plot_loss, plot_trips):
        ours, theirs = plot(plain), plot(foreign)
        names, other = (
            [text.get_text() for legend in figure.legends for text in legend.get_texts()]
            for figure in (ours, theirs)
        )
        assert any("MBC" in name for name in names)
        assert other == [name.replace("MBC", "soon:ahead_s=$1$") for name in names]
        assert [len(axes.lines) for axes in theirs.axes] == [len(axes.lines) for axes in ours.axes]
        assert [len(axes.patches) for axes in theirs.axes] == [len(axes.patches) for axes in ours.axes]


def test_the_free_receiver_has_one_colour_in_both_readings_and_in_fleets(make_result: Make) -> None:
    """So trips are named by who they are of: a colour alone would name one of the two."""
    assert POLICY_COLOURS["free"] == POLICY_COLOURS["free-matched"] == sender_look("free")[0]
    assert POLICY_LINES["free"] != POLICY_LINES["free-matched"]
    assert POLICY_MARKERS["free"] != POLICY_MARKERS["free-matched"]
    figure = plot_trips(make_result(trips=("a/1", "b/1"), ratios=(0.4,)))
    names = [text.get_text() for text in figure.legends[0].get_texts()]
    assert names.count("Free receiver, same threshold") == 1
    assert names.count("Free receiver, at MBC's total rate") == 1


def test_captions_say_what_the_sub_models_shown_are(make_result: Make) -> None:
    told = captions(make_result())
    assert told["sub_models"].endswith("Sub-models: cv: constant velocity.")
    assert "Sub-models: " not in captions(replace(make_result(), timeline=None))["sub_models"]
    assert "Sub-models: " not in told["tracking_loss"]

"""Claims about the table of capacities: what it says of seeds, tracks, thresholds and limits."""

from dataclasses import replace

from modelcast.report.capacity import capacity_markdown, plot_capacity
from modelcast.report.style import style
from modelcast.study.network.capacity import CapacityFound, bisected
from modelcast.study.network.capacity_limits import Limit, Probe
from modelcast.study.network.rows import NO_THRESHOLD


def found(limit: Limit, held_ratio: float = 1.0, *, threshold_m: float = NO_THRESHOLD) -> CapacityFound:
    """Holds at 100 vehicles/km and fails at 200."""

    def probe(density: float) -> Probe:
        holds = density < 150.0
        return Probe(
            density,
            0.4 if holds else 0.6,
            spread=(0.3, 0.5) if holds else (0.6, 0.6),
            held_ratio=1.0 if holds else held_ratio,
            busy_ratio=0.2 if holds else 0.4,
            seeds_held=(1, 2) if holds else (0, 2),
            holds=holds,
            warnings=70 if limit.quantity == "missed" else 0,
        )

    capacity = bisected(probe, (100.0, 400.0), ratio=2.0)
    return CapacityFound("dsrc", "mbc", threshold_m=threshold_m, limit=limit, capacity=capacity)


def test_radios_that_differ_in_one_setting_have_other_titles() -> None:
    words = [f"dsrc:path_loss=two-ray,antenna_m={height_m},shadowing=log-normal" for height_m in (1.5, 2.5)]
    with style():
        figure = plot_capacity([replace(found(Limit("absolute", 0.5)), radio=word) for word in words])
    assert [axes.get_title() for axes in figure.axes] == words


def rows(*every: CapacityFound) -> list[list[str]]:
    lines = [line for line in capacity_markdown(every).splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


def test_a_row_says_density_seeds_values_and_load_at_both_ends() -> None:
    heads, _, cells = rows(found(Limit("relative", 0.5)))
    assert dict(zip(heads, cells, strict=True)) == {
        "limit": "relative p99 < 0.5 m",
        "radio": "dsrc",
        "policy": "mbc",
        "vehicles/km": "100 to 200",
        "seeds that held": "1/2, 0/2",
        "at the last": "0.40 m (0.30-0.50)",
        "at the first": "0.60 m",
        "channel busy": "20 %, 40 %",
    }


def test_too_few_tracks_are_said_where_they_are_too_few() -> None:
    heads, _, cells = rows(found(Limit("absolute", 0.5), held_ratio=0.94))
    said = dict(zip(heads, cells, strict=True))
    assert said["at the first"] == "0.60 m, 94 % tracked"
    assert "tracked" not in said["at the last"]


def test_misses_come_with_their_warnings_and_rows_are_in_order_of_limits() -> None:
    near, far = found(Limit("absolute", 0.5), threshold_m=0.2), found(Limit("missed", 0.5))
    heads, _, *cells = rows(near, far, found(Limit("absolute", 0.5)))
    said = [dict(zip(heads, row, strict=True)) for row in cells]
    assert [one["limit"] for one in said] == ["p99 < 0.5 m", "p99 < 0.5 m", "missed < 50 %"]
    assert [one["threshold"] for one in said] == ["20 cm", "-", "-"]
    assert [one["warnings"] for one in said] == ["-", "-", "70, 70"]
    assert said[2]["at the last"] == "40.00 % (30.00-50.00)"

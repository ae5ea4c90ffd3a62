"""Claims about table and figures of the hybrid against the baseline in traffic."""

from itertools import product
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from modelcast.core.exceptions import DataFormatError
from modelcast.io.traffic import read_traffic, write_traffic
from modelcast.report.figures.traffic import TRAFFIC_FIGURES, one_density
from modelcast.report.style import style
from modelcast.report.traffic import traffic_markdown, write_traffic_report
from modelcast.study.network.pairs import FIGURES, PAIRED, verdict_of
from modelcast.study.table import Row

RANGES = ("delivery_ratio", "collision_ratio", "gap_p90_s", "pte_p90_m", "pte_p99_m")


def row(
    density: float,
    radio: str,
    threshold_m: float,
    figure: str,
    low_m: float | None = None,
    *,
    seeds: int = 10,
    bank: str = "paper",
) -> Row:
    """The hybrid has half of what the baseline has, which grows with the density."""
    baseline = 1e-4 * density * threshold_m
    spread = None if seeds == 1 else 0.1 * baseline
    difference = -0.5 * baseline
    bounds = (None, None) if spread is None else (difference - spread, difference + spread)
    return PAIRED.row(
        density_per_km=density,
        radio=radio,
        bank=bank,
        threshold_m=threshold_m,
        figure=figure,
        low_m=50.0 if low_m is None else low_m,
        high_m=150.0 if low_m is None else low_m + 25.0,
        by_range=low_m is not None,
        seeds=seeds,
        hybrid=0.5 * baseline,
        hybrid_low=None if spread is None else 0.5 * baseline - spread,
        hybrid_high=None if spread is None else 0.5 * baseline + spread,
        baseline=baseline,
        baseline_low=None if spread is None else baseline - spread,
        baseline_high=None if spread is None else baseline + spread,
        difference=difference,
        difference_low=bounds[0],
        difference_high=bounds[1],
        verdict=verdict_of(*bounds),
    )


def rows(seeds: int = 10, thresholds: tuple[float, ...] = (0.2, 0.3, 0.5)) -> list[Row]:
    each = list(product((25.0, 400.0, 1200.0), ("dsrc", "sidelink"), thresholds))
    found = [row(*key, figure, seeds=seeds) for key in each for figure in FIGURES]
    return found + [
        row(*key, figure, low_m, seeds=seeds) for key in each for figure in RANGES for low_m in (0.0, 25.0)
    ]


def test_the_table_says_both_the_difference_and_the_verdict() -> None:
    text = traffic_markdown(rows())
    lines = [line for line in text.splitlines() if line.startswith("| 400 | dsrc | paper | 50 cm |")]
    (line,) = lines
    assert "1.00 / 2.00 (-1.0 ± 0.20)" in line
    assert line.endswith("| fewer | fewer | fewer |")
    assert "- dsrc, collisions by share: fewer 9" in text


def test_one_seed_has_no_interval_and_no_verdict() -> None:
    text = traffic_markdown(rows(seeds=1))
    assert "±" not in text
    assert "one seed 9" in text


@pytest.mark.parametrize("name", TRAFFIC_FIGURES)
def test_figures_show_both_policies_and_the_thresholds_there_is_room_for(name: str) -> None:
    with style():
        figure = TRAFFIC_FIGURES[name][1](rows())
    wanted = (
        ("20 cm", "30 cm", "50 cm") if name in {"traffic_load", "traffic_density"} else ("20 cm", "50 cm")
    )
    labels = {f"{policy}, {threshold}" for policy in ("baseline", "mbc") for threshold in wanted}
    assert {text.get_text() for text in figure.legends[0].get_texts()} == labels
    for axes in figure.axes:
        found = {str(line.get_label()) for line in axes.get_lines()}
        named = {label for label in found if not label.startswith("_")}
        assert named == labels or named == {label for label in labels if label.startswith("mbc")}


def test_the_difference_is_drawn_as_it_is() -> None:
    with style():
        figure = TRAFFIC_FIGURES["traffic_load"][1](rows(thresholds=(0.5,)))
    (curve,) = [line for line in figure.axes[2].get_lines() if line.get_label() == "mbc, 50 cm"]
    np.testing.assert_allclose(np.asarray(curve.get_ydata()), [-0.0625, -1.0, -3.0])


def test_one_density_is_the_one_nearest_to_400() -> None:
    assert one_density(rows()) == 400.0


def test_traffic_of_its_own_density_is_drawn_by_range_alone(tmp_path: Path) -> None:
    own = [one.replaced(density_per_km=np.nan) for one in rows() if one.density_per_km == 400.0]
    assert "| - | dsrc | paper | 50 cm |" in traffic_markdown(own)
    assert len(write_traffic_report(own, tmp_path)) == 2 + 3 * len(TRAFFIC_FIGURES)
    with style():
        by_range, by_density = (TRAFFIC_FIGURES[f"traffic_{name}"][1](own) for name in ("range", "density"))
    assert by_range.axes[0].get_title(loc="left") == "dsrc, own density"
    assert len(by_range.axes[0].get_lines()) == 4
    assert not by_density.axes


@pytest.mark.slow
@pytest.mark.parametrize("seeds", [1, 10])
def test_all_is_written_and_repeats_to_the_byte(seeds: int, tmp_path: Path) -> None:
    folders = (tmp_path / "one", tmp_path / "other")
    for folder in folders:
        folder.mkdir()
        paths = [*write_traffic_report(rows(seeds), folder), write_traffic(rows(seeds), folder)]
        assert len(paths) == 2 + 3 * len(TRAFFIC_FIGURES) + 1
    for path in sorted(folders[0].iterdir()):
        assert path.read_bytes() == (folders[1] / path.name).read_bytes()
    table = pq.read_table(folders[0] / "traffic.parquet").to_pylist()
    assert len(table) == len(rows(seeds))
    assert table[0]["difference"] == rows(seeds)[0].difference
    assert table[0]["difference_low"] == rows(seeds)[0].difference_low


@pytest.mark.parametrize("seeds", [1, 3])
def test_rows_are_read_as_they_were_written(seeds: int, tmp_path: Path) -> None:
    assert list(read_traffic(write_traffic(rows(seeds), tmp_path))) == list(rows(seeds))


def test_another_file_is_refused_by_name(tmp_path: Path) -> None:
    path = tmp_path / "other.parquet"
    path.write_bytes(b"no table")
    with pytest.raises(DataFormatError, match=r"other\.parquet"):
        read_traffic(path)

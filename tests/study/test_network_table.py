"""Claims about the published network table: its runs, what its intervals hold, what its sentences say."""

from collections.abc import Generator
from importlib import import_module
from itertools import product
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.study.metrics import confidence_limits

VALIDATION = Path(__file__).parents[2] / "validation"
MODULES = ("cells", "coverage", "rows", "sentences", "page")
DRAWN_RATIO = 0.02
"""Three standard deviations of a share near 0.9 over 2,000 draws."""


@pytest.fixture(scope="module")
def table() -> Generator[dict[str, ModuleType]]:
    """The modules of the script in ``validation``, by the last word of their names."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(VALIDATION))
        yield {name: import_module(f"network_table_{name}") for name in MODULES}


def found(table: dict[str, ModuleType], p90_cm: dict[str, float], seeds: int = 10, receiver: str = "default"):
    """Runs of senders at 100 vehicles/km with this p90, which wanders by 1 % from seed to seed."""
    cells, held = table["cells"], {}
    for (policy, value), seed in product(p90_cm.items(), range(seeds)):
        cell = cells.Cell("highway", 100.0, "dsrc", policy, receiver, seed)
        figures = dict.fromkeys(cells.FIGURES, 1.0)
        figures["pte_p90_m"] = 0.01 * value * (1.0 + 0.01 * np.sin(1.0 + 7.0 * seed + len(policy)))
        held[cell] = cells.Kept(figures, 1.0, "v", "s")
    return held


def test_no_two_runs_have_one_file_and_each_is_run_once(table) -> None:
    cells = table["cells"].cells_of(table["cells"].CALLS, ())
    assert len({cell.stem for cell in cells}) == len(cells) == len(set(cells))
    assert all("/" not in cell.stem and ":" not in cell.stem for cell in cells)


def test_headline_rows_have_ten_seeds_and_the_thin_ones_come_first(table) -> None:
    headline = table["cells"].cells_of(table["cells"].CALLS, ["headline"])
    assert {cell.density_per_km for cell in headline[:150]} == {25.0, 100.0, 200.0}
    rows = {cell._replace(seed=0) for cell in headline}
    assert set(headline) == {row._replace(seed=seed) for row in rows for seed in range(10)}


def test_quick_runs_few_and_most_seeds_bound_each_call(table) -> None:
    cells_of, calls = table["cells"].cells_of, table["cells"].CALLS
    assert max(cell.density_per_km for cell in cells_of(calls, (), quick=True)) <= 400.0
    assert {cell.seed for cell in cells_of(calls, (), most_seeds=2)} == {0, 1}


def test_what_is_kept_comes_back_and_a_file_of_another_run_is_refused(table, tmp_path: Path) -> None:
    cells = table["cells"]
    one = cells.Cell("loaded", 700.0, "dsrc:path_loss=dual-slope", "mbc", "gnss", 3)
    other = one._replace(seed=4)
    done = cells.Kept(dict.fromkeys(cells.FIGURES, 0.5), 1.5, cells.package_version(), "abc")
    assert cells.kept(tmp_path, one) is None
    cells.keep(tmp_path, one, done)
    assert cells.kept(tmp_path, one) == done
    (tmp_path / f"{one.stem}.json").rename(tmp_path / f"{other.stem}.json")
    with pytest.raises(SystemExit, match="is of another run or version"):
        cells.kept(tmp_path, other)
    cells.keep(tmp_path, one, done._replace(version="0"))
    with pytest.raises(SystemExit, match="is of another run or version"):
        cells.kept(tmp_path, one)


@pytest.mark.parametrize("seeds", [3, 10])
def test_normal_runs_are_held_as_often_as_the_closed_form_says(table, seeds: int) -> None:
    """Against fresh draws of the distribution itself, without the script's own drawing."""
    rng, draws = np.random.default_rng(1), 2000
    held = 0
    for _ in range(draws):
        low, high = confidence_limits(rng.normal(size=seeds))
        assert low is not None
        assert high is not None
        held += low <= rng.normal(size=seeds).mean() <= high
    assert held / draws == pytest.approx(table["coverage"].expected_ratio(seeds, seeds), abs=DRAWN_RATIO)


def test_against_endless_fresh_seeds_it_is_the_interval_s_own_95_percent(table) -> None:
    expected = table["coverage"].expected_ratio
    assert expected(10, 10**9) == pytest.approx(0.95)
    assert expected(10, 1) < expected(10, 10) < expected(10, 100) < 0.95


def test_coverage_of_many_normal_runs_is_near_the_closed_form(table) -> None:
    values = np.random.default_rng(2).normal(size=4000)
    got = table["coverage"].coverage(values, 3, draws=2000)
    expected = table["coverage"].expected_ratio
    assert got.others_ratio == pytest.approx(expected(3, 3997), abs=DRAWN_RATIO)
    assert got.fresh_ratio == pytest.approx(expected(3, 3), abs=DRAWN_RATIO)
    assert 0.0 < got.narrowest_ratio < 0.5


def test_coverage_needs_fresh_runs(table) -> None:
    with pytest.raises(ValueError, match="need at least 20 runs, got 19"):
        table["coverage"].coverage(np.arange(19.0), 10)


@given(value=st.floats(0.1, 2.0), half=st.floats(0.0, 1.0))
def test_a_verdict_is_never_given_where_the_interval_holds_one(table, value: float, half: float) -> None:
    rows = table["rows"]
    word = rows.verdict(rows.Mean(value, half))
    if value - half <= 1.0 <= value + half:
        assert word == "same"
    elif abs(value - 1.0) > 0.005:
        assert word == ("lower" if value < 1.0 else "higher")


def test_ratios_are_of_shared_seeds_alone(table) -> None:
    held = found(table, {"j2945": 4.0, "mbc": 2.0})
    held = {cell: one for cell, one in held.items() if not (cell.policy == "mbc" and cell.seed < 8)}
    rows = table["rows"].Rows(held)
    setting = table["rows"].Setting("highway", "dsrc", 100.0, "default", "mbc")
    assert rows.ratios(setting, "pte_p90_m", "j2945") == pytest.approx([0.5, 0.5], rel=0.02)
    assert rows.ratio(setting, "pte_p90_m", "cam") is None


def test_sides_without_any_are_equal_and_one_without_is_no_number(table) -> None:
    ratios = table["rows"].compared(np.array([0.0, 1.0, 3.0]), np.array([0.0, 0.0, 2.0]))
    assert ratios.tolist() == pytest.approx([1.0, np.nan, 1.5], nan_ok=True)


def test_sentences_say_where_models_add_to_the_free_sender_and_where_not(table) -> None:
    block = table["sentences"].headline_block
    same = block(table["rows"].Rows(found(table, {"j2945": 4.0, "j2945-free": 2.0, "j2945-mbc": 2.0})))
    assert same[0].endswith("which sends no model, at no density of these runs.")
    assert "at 100 vehicles/km (10 seeds): `j2945-free` 0.50 and `j2945-mbc` 0.50" in same[1]
    assert "takes off p90: 50." in same[2] or "takes off p90: 49." in same[2]
    assert "is not shown to differ at 100" in same[3]
    less = block(table["rows"].Rows(found(table, {"j2945": 4.0, "j2945-free": 3.0, "j2945-mbc": 2.0})))
    assert "is lower at 100 (0.66" in less[3] or "is lower at 100 (0.67" in less[3]
    assert less[0].endswith("which sends no model, at 100 (1 cm).")


def test_a_small_gain_is_called_small_and_its_receiver_named(table) -> None:
    lines = table["sentences"].headline_block(
        table["rows"].Rows(found(table, {"j2945": 4.0, "j2945-mbc": 3.92}, receiver="gnss"))
    )
    assert "takes off the p90 of `j2945`: 2 % (`gnss`)." in lines[0]
    assert lines[1].startswith("- **Receiver `gnss`.**")
    assert "Less than 5 % remains of it at all of these." in lines[2]


def test_other_radios_tell_what_collides_of_even_and_uneven_messages(table) -> None:
    held = found(table, {"j2945": 4.0, "j2945-mbc-relaxed": 4.0}, seeds=2)
    for cell, one in held.items():
        one.figures["collision_ratio"] = 0.012 if cell.policy == "j2945" else 0.08
    moved = {cell._replace(radio="sidelink"): one for cell, one in held.items()}
    lines = table["page"].blocks(moved)["network-table-radios"]
    assert lines[0] == (
        "- `sidelink`, frames that collide: of `j2945` 1.2 % at 100; of `j2945-mbc-relaxed` 8.0 % at 100."
    )
    assert sum("`j2945-mbc-relaxed` | 2 |" in line for line in lines) == 1


def test_loaded_runs_tell_the_greatest_busy_ratio_and_who_lowers_power(table) -> None:
    held = found(table, {"j2945": 4.0, "bsm-10hz": 4.0}, seeds=3)
    for cell, one in held.items():
        one.figures["busy_ratio"] = 0.55 if cell.policy == "j2945" else 0.72
        one.figures["power_dbm"] = 17.6 if cell.policy == "j2945" else 20.0
    moved = {cell._replace(scenario="loaded"): one for cell, one in held.items()}
    lines = table["page"].blocks(moved)["network-table-loaded"]
    assert "is 0.72 ± 0.00, of `bsm-10hz` at 100 vehicles/km; 0.7 is reached." in lines[0]
    assert "`j2945` holds itself to a busy ratio and a power of 0.55 and 17.6 dBm at 100." in lines[1]


def test_nothing_that_was_not_run_is_said(table) -> None:
    made = table["page"].blocks({})
    assert {name: lines for name, lines in made.items() if lines != ["Not run."]}.keys() == {
        "network-table-runs"
    }


def test_the_page_has_a_place_for_every_block(table) -> None:
    page = table["page"].PAGE.read_text(encoding="utf-8")
    for name in table["page"].blocks({}):
        assert page.count(f"<!-- begin {name} -->") == page.count(f"<!-- end {name} -->") == 1

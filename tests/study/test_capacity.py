"""The density at which a limit fails, found by doubling and halving: brackets and what is said of them."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from made_rows import filled
from modelcast.study.network.capacity import Capacity, bisected
from modelcast.study.network.capacity_limits import Limit, Probe, probe_of
from modelcast.study.network.rows import CASE_KEYS, RUNS, CaseResult, NetworkCase
from modelcast.study.network.warning_rows import WARNINGS

LIMIT = Limit("absolute", 0.5)


def ran(run: int = 0, *, density: float = 100.0, **figures: float) -> CaseResult:
    """A run of which only some figures matter."""
    key = NetworkCase(density, "dsrc", "mbc", "default", run).values()
    return CaseResult(filled(RUNS, 0.5, **{**key, "held_ratio": 1.0, **figures}), [], outcomes=[], seconds=[])


def warned(run: int, positives: int, missed: int, application: str = "fcw") -> CaseResult:
    """A run in which hosts missed so many instants."""
    row: dict[str, Any] = {
        "application": application,
        "sender": "mbc",
        "reading": "model",
        "events": 3,
        "positives": positives,
        "missed": missed,
    }
    one = ran(run)
    keys = one.run.picked(CASE_KEYS)
    return CaseResult(one.run, [], outcomes=[], seconds=[], warnings=[filled(WARNINGS, 0, **keys, **row)])


def at(density: float, p99_m: float, held: float = 1.0) -> Probe:
    """A probe with one seed."""
    return probe_of([ran(density=density, pte_p99_m=p99_m, held_ratio=held)], LIMIT)


@given(st.floats(30.0, 3000.0), st.floats(1.02, 2.0))
def test_the_bracket_holds_the_limit_and_is_as_narrow_as_asked(limit_per_km: float, ratio: float) -> None:
    asked: list[float] = []

    def probe(density: float) -> Probe:
        asked.append(density)
        return at(density, 0.4 if density < limit_per_km else 0.6)

    found = bisected(probe, (25.0, 3200.0), ratio=ratio)
    assert found.holds_per_km is not None
    assert found.fails_per_km is not None
    assert found.holds_per_km < limit_per_km <= found.fails_per_km <= ratio * found.holds_per_km
    assert len(asked) == len(set(asked))
    assert max(asked) < 2.0 * limit_per_km or max(asked) == 25.0
    assert found.is_monotone


def test_ends_that_never_cross_are_said_as_such() -> None:
    holds = bisected(lambda density: at(density, 0.1), (25.0, 700.0))
    fails = bisected(lambda density: at(density, 2.0), (25.0, 700.0))
    assert (holds.holds_per_km, holds.fails_per_km, holds.text) == (700.0, None, "holds at 700")
    assert (fails.holds_per_km, fails.fails_per_km, fails.text) == (None, 25.0, "fails at 25")
    assert [one.density_per_km for one in fails.probes] == [25.0]
    assert (holds.ends[1], fails.ends[0]) == (None, None)


def test_who_loses_tracks_fails_however_good_the_others_are() -> None:
    found = bisected(lambda density: at(density, 0.1, 0.94 if density > 100.0 else 1.0), (25.0, 800.0))
    assert found.holds_per_km is not None
    assert found.holds_per_km <= 100.0


def test_what_is_out_of_order_is_said() -> None:
    def probe(density: float) -> Probe:
        return at(density, 0.9 if 90.0 < density < 300.0 or density > 700.0 else 0.1)

    found = bisected(probe, (25.0, 800.0), known=(100.0, 400.0))
    assert found.fails_per_km is not None
    assert found.fails_per_km <= 100.0
    assert not found.is_monotone
    assert found.text.endswith("?")


def test_densities_known_before_narrow_the_bracket() -> None:
    asked: list[float] = []

    def probe(density: float) -> Probe:
        asked.append(density)
        return at(density, 0.4 if density < 200.0 else 0.6)

    cold: Capacity = bisected(probe, (25.0, 3200.0))
    many = len(asked)
    asked.clear()
    warm = bisected(probe, (25.0, 3200.0), known=(190.0, 205.0))
    assert warm.holds_per_km == 190.0
    assert warm.fails_per_km == 205.0
    assert len(asked) == 3 < many
    assert [probe and probe.density_per_km for probe in warm.ends] == [190.0, 205.0]
    assert cold.fails_per_km is not None


@pytest.mark.parametrize(("bounds", "ratio"), [((0.0, 10.0), 1.1), ((10.0, 10.0), 1.1), ((1.0, 10.0), 1.0)])
def test_bounds_and_ratio_are_checked(bounds: tuple[float, float], ratio: float) -> None:
    with pytest.raises(ValueError, match="must"):
        bisected(lambda density: at(density, 0.1), bounds, ratio=ratio)


def test_a_probe_keeps_the_spread_of_its_seeds_and_how_many_held() -> None:
    """The mean decides, tracked pairs among it: 0.45 m holds though one seed has 0.6 m."""
    runs = [
        ran(0, pte_p99_m=0.35, relative_p99_m=0.7, busy_ratio=0.2),
        ran(1, pte_p99_m=0.60, relative_p99_m=0.8, busy_ratio=0.4),
        ran(2, pte_p99_m=0.40, relative_p99_m=0.3, held_ratio=0.94),
    ]
    absolute, relative = (probe_of(runs, Limit(name, 0.5)) for name in ("absolute", "relative"))
    assert absolute.value == pytest.approx(0.45)
    assert (absolute.spread, absolute.seeds_held, absolute.holds) == ((0.35, 0.60), (1, 3), True)
    assert relative.value == pytest.approx(0.6)
    assert (relative.spread, relative.seeds_held, relative.holds) == ((0.3, 0.8), (0, 3), False)
    assert absolute.held_ratio == pytest.approx(0.98)


def test_what_equals_its_limit_fails() -> None:
    assert not at(100.0, 0.5).holds
    assert not probe_of([warned(0, 100, 1)], Limit("missed", 0.01)).holds
    assert probe_of([warned(0, 101, 1)], Limit("missed", 0.01)).holds


def test_missed_warnings_are_shares_of_all_instants_and_of_each_seeds() -> None:
    """Seeds with more instants weigh more; one with none has nothing to say, nor has another application."""
    runs = [warned(0, 900, 9), warned(1, 100, 9), warned(2, 0, 0), warned(3, 50, 50, "eebl")]
    found = probe_of(runs, Limit("missed", 0.05))
    assert found.value == pytest.approx(18 / 1000)
    assert (found.spread, found.seeds_held, found.holds) == ((0.01, 0.09), (1, 2), True)
    assert found.warnings == 9


def test_nothing_to_miss_is_no_capacity() -> None:
    with pytest.raises(ValueError, match="no true warning of fcw at 100 vehicles/km"):
        probe_of([warned(0, 0, 0), ran(1)], Limit("missed", 0.01))


@pytest.mark.parametrize(("quantity", "value"), [("absolute", 0.0), ("relative", -1.0), ("missed", 1.0)])
def test_limits_are_checked(quantity: Any, value: float) -> None:
    with pytest.raises(ValueError, match=f"a limit of {quantity} must be"):
        Limit(quantity, value)

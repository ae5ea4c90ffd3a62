"""The density at which tracking fails, found by halving: brackets and what is said of them."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.study.network.capacity import Capacity, Probe, bisected


def at(density: float, p99_m: float, held: float = 1.0) -> Probe:
    """A probe with one seed."""
    return Probe(density, p99_m, held, 0.3, (1, 1))


@given(st.floats(30.0, 3000.0), st.floats(1.02, 2.0))
def test_the_bracket_holds_the_limit_and_is_as_narrow_as_asked(limit_per_km: float, ratio: float) -> None:
    asked: list[float] = []

    def probe(density: float) -> Probe:
        asked.append(density)
        return at(density, 0.4 if density < limit_per_km else 0.6)

    found = bisected(probe, (25.0, 3200.0), 0.5, ratio=ratio)
    assert found.holds_per_km is not None
    assert found.fails_per_km is not None
    assert found.holds_per_km < limit_per_km <= found.fails_per_km <= ratio * found.holds_per_km
    assert len(asked) == len(set(asked))
    assert found.is_monotone


def test_ends_that_never_cross_are_said_as_such() -> None:
    holds = bisected(lambda density: at(density, 0.1), (25.0, 800.0), 0.5)
    fails = bisected(lambda density: at(density, 2.0), (25.0, 800.0), 0.5)
    assert (holds.holds_per_km, holds.fails_per_km, holds.text) == (800.0, None, "holds at 800")
    assert (fails.holds_per_km, fails.fails_per_km, fails.text) == (None, 25.0, "fails at 25")


def test_who_loses_tracks_fails_however_good_the_others_are() -> None:
    found = bisected(lambda density: at(density, 0.1, 0.94 if density > 100.0 else 1.0), (25.0, 800.0), 0.5)
    assert found.holds_per_km is not None
    assert found.holds_per_km <= 100.0


def test_what_is_out_of_order_is_said() -> None:
    def probe(density: float) -> Probe:
        return at(density, 0.9 if 90.0 < density < 300.0 or density > 700.0 else 0.1)

    found = bisected(probe, (25.0, 800.0), 0.5, known=(100.0, 400.0))
    assert found.fails_per_km is not None
    assert found.fails_per_km <= 100.0
    assert not found.is_monotone
    assert found.text.endswith("?")


def test_densities_known_before_narrow_the_bracket() -> None:
    asked: list[float] = []

    def probe(density: float) -> Probe:
        asked.append(density)
        return at(density, 0.4 if density < 200.0 else 0.6)

    cold: Capacity = bisected(probe, (25.0, 3200.0), 0.5)
    many = len(asked)
    asked.clear()
    warm = bisected(probe, (25.0, 3200.0), 0.5, known=(190.0, 205.0))
    assert warm.holds_per_km == 190.0
    assert warm.fails_per_km == 205.0
    assert len(asked) == 4 < many
    assert cold.fails_per_km is not None


@pytest.mark.parametrize(("bounds", "ratio"), [((0.0, 10.0), 1.1), ((10.0, 10.0), 1.1), ((1.0, 10.0), 1.0)])
def test_bounds_and_ratio_are_checked(bounds: tuple[float, float], ratio: float) -> None:
    with pytest.raises(ValueError, match="must"):
        bisected(lambda density: at(density, 0.1), bounds, 0.5, ratio=ratio)

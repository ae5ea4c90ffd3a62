"""Claims about the threshold at which a sender spends as much as another."""

from collections.abc import Callable

import pytest

from modelcast.study.matching import matched_threshold


def counted(load: Callable[[float], float]) -> tuple[Callable[[float], float], list[float]]:
    """The same load, and the thresholds that it was asked at."""
    asked: list[float] = []

    def told(threshold_m: float) -> float:
        asked.append(threshold_m)
        return load(threshold_m)

    return told, asked


@pytest.mark.parametrize("start_m", [None, 0.02, 0.4, 20.0])
def test_smooth_loads_are_met_from_anywhere(start_m: float | None) -> None:
    load, asked = counted(lambda threshold_m: 30.0 * threshold_m**-0.6)
    found_m = matched_threshold(load, 60.0, start_m=start_m)
    assert load(found_m) == pytest.approx(60.0, rel=0.005)
    assert len(asked) - 1 <= (24 if start_m is None else 7)


def test_the_nearest_of_those_tried_is_taken_where_counts_jump() -> None:
    load, asked = counted(lambda threshold_m: float(round(3.0 / threshold_m)) * 10.0)
    found_m = matched_threshold(load, 83.0, start_m=0.1)
    assert abs(load(found_m) - 83.0) == min(abs(load(one) - 83.0) for one in asked[:7])
    assert load(found_m) == 80.0


def test_steps_stay_between_the_thresholds_that_are_left() -> None:
    load, asked = counted(lambda threshold_m: 100.0 if threshold_m < 0.3 else 10.0)
    matched_threshold(load, 50.0, start_m=0.29)
    for place, tried_m in enumerate(asked[1:], start=1):
        below = [one for one in asked[:place] if one < 0.3]
        above = [one for one in asked[:place] if one >= 0.3]
        assert tried_m > max(below, default=0.0)
        assert tried_m < min(above, default=65.0)


@pytest.mark.parametrize("start_m", [None, 0.4])
def test_a_load_of_nothing_is_no_obstacle(start_m: float | None) -> None:
    load, _ = counted(lambda threshold_m: 10.0 if threshold_m < 0.2 else 0.0)
    assert matched_threshold(load, 10.0, start_m=start_m) < 0.2
    assert matched_threshold(lambda _: 5.0, 0.0, start_m=start_m) > 0.0

"""Which source stands still while another says that the vehicle moves.

Values that stay the same to the bit prove nothing: a car on cruise control has one speed, one that stands
has one place. A source is frozen where its values stayed the same for a stated time and number, and another
source says that they should not have:

==============  =========================================  =============================================
Frozen          Same for                                   While
==============  =========================================  =============================================
place           5 fixes, 0.4 s                             more than 2 m were driven, by the bus, or by the
                                                           speed that the same fixes state
speed           2 s, 5 values                              fixes state speeds, for the last 1 s, that differ
                                                           by over 1.5 m/s and 10 %; their places move
yaw rate        2 s, 5 values                              the course turned 10° otherwise in the last 4 s,
                                                           above 3 m/s
acceleration    2 s, 5 values                              the speed of fixes changed 3 m/s otherwise in
                                                           the last 4 s
==============  =========================================  =============================================

A speed is looked at first, since it judges places; fixes whose own speed leaps as no vehicle's does (20
m/s²) judge none. What was given out before is not taken back: for as long as a freeze takes to show, the
vehicle is elsewhere.
"""

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise

from modelcast.node.inputs.samples import PLAUSIBLE, GnssFix
from modelcast.node.inputs.series import Series
from modelcast.station.sensing.rates import NO_RATES_BELOW_MPS

__all__ = ["frozen_quantities", "same_place_since"]

_FIXES = 5
_PLACE_S = 0.4
_PLACE_M = 2.0
_VALUES = 5
_VALUE_S = 2.0
_CHANGE_S = 4.0
"""Turns and changes of speed are looked at for so long, so that small errors do not add up."""
_SPEED_S = 1.0
_SPEED_MPS = 1.5
_SPEED_RATIO = 0.1
_TURN_RAD = math.radians(10.0)
_TURNS_ABOVE_MPS = 3.0
_SPEED_CHANGE_MPS = 3.0


def same_place_since(fixes: Sequence[GnssFix], speed: Series | None) -> int | None:
    """The fix since which the place is frozen, None where it is not.

    Parameters
    ----------
    fixes
        In order of time.
    speed
        The bus's, None where it has none to trust.
    """
    first = _run_of_same_place(fixes)
    count = len(fixes) - first
    if count < _FIXES or fixes[-1].measured_s - fixes[first].measured_s < _PLACE_S:
        return None
    run = fixes[first:]
    stated_m = _driven_m([fix.measured_s for fix in run], [abs(fix.speed_mps) for fix in run])
    by_bus_m = 0.0
    if speed is not None:
        begin_s, end_s = run[0].measured_s, run[-1].measured_s
        times_s = [begin_s, *speed.knots(begin_s, end_s), end_s]
        by_bus_m = _driven_m(times_s, [abs(speed.at(at_s)) for at_s in times_s])
    return first if max(stated_m, by_bus_m) > _PLACE_M else None


def frozen_quantities(fixes: Sequence[GnssFix], bus: Mapping[str, Series]) -> frozenset[str]:
    """Quantities of the bus that are frozen.

    Parameters
    ----------
    fixes
        In order of time.
    bus
        Its values by quantity.
    """
    found: set[str] = set()
    for quantity, differs, lasts_s in (
        ("speed_mps", _speed_differs, math.inf),
        ("yaw_rate_radps", _turn_differs, _CHANGE_S),
        ("acceleration_mps2", _speed_change_differs, _CHANGE_S),
    ):
        series = bus.get(quantity)
        if series is None or not len(series):
            continue
        since_s, count = series.same_since()
        lasted_s = series.newest_s - since_s
        if count < _VALUES or lasted_s < _VALUE_S:
            continue
        begin_s = max(since_s, series.newest_s - lasts_s)
        during = [fix for fix in fixes if begin_s <= fix.measured_s <= series.newest_s]
        if (
            len(during) > 1
            and during[-1].measured_s - during[0].measured_s >= _VALUE_S / 2.0
            and differs(series.at(series.newest_s), during)
        ):
            found.add(quantity)
    return frozenset(found)


def _speed_differs(speed_mps: float, fixes: Sequence[GnssFix]) -> bool:
    """Whether fixes whose places can be trusted state other speeds than a constant one."""
    if same_place_since(fixes, None) is not None or any(map(_leaps, fixes, fixes[1:])):
        return False
    latest = [fix for fix in fixes if fix.measured_s >= fixes[-1].measured_s - _SPEED_S]
    return all(
        abs(fix.speed_mps - abs(speed_mps)) > max(_SPEED_MPS, _SPEED_RATIO * fix.speed_mps) for fix in latest
    )


def _leaps(sooner: GnssFix, later: GnssFix) -> bool:
    """Whether a stated speed changed as no vehicle's does, as where a receiver hangs."""
    most_mps2 = PLAUSIBLE["acceleration_mps2"][1]
    step_s = later.measured_s - sooner.measured_s
    return abs(later.speed_mps - sooner.speed_mps) > most_mps2 * step_s + _SPEED_MPS


def _turn_differs(yaw_rate_radps: float, fixes: Sequence[GnssFix]) -> bool:
    """Whether the course of fixes turned otherwise than by a constant rate."""
    moving = [fix for fix in fixes if fix.speed_mps > _TURNS_ABOVE_MPS and math.isfinite(fix.heading_rad)]
    if len(moving) < 2 or len(moving) < len(fixes):
        return False
    turned_rad = sum(
        math.remainder(later.heading_rad - sooner.heading_rad, math.tau) for sooner, later in pairwise(moving)
    )
    return abs(turned_rad - yaw_rate_radps * (moving[-1].measured_s - moving[0].measured_s)) > _TURN_RAD


def _speed_change_differs(acceleration_mps2: float, fixes: Sequence[GnssFix]) -> bool:
    """Whether the speed of fixes changed otherwise than by a constant acceleration."""
    changed_mps = fixes[-1].speed_mps - fixes[0].speed_mps
    lasted_s = fixes[-1].measured_s - fixes[0].measured_s
    return abs(changed_mps - acceleration_mps2 * lasted_s) > _SPEED_CHANGE_MPS


def _run_of_same_place(fixes: Sequence[GnssFix]) -> int:
    """Index of the first of the newest fixes that have one place."""
    first = len(fixes) - 1
    while first > 0 and _place(fixes[first - 1]) == _place(fixes[-1]):
        first -= 1
    return max(first, 0)


def _place(fix: GnssFix) -> tuple[float, float]:
    return fix.latitude_deg, fix.longitude_deg


def _driven_m(times_s: Sequence[float], speeds_mps: Sequence[float]) -> float:
    """Way at speeds that are not those of a car that stands [m]."""
    rows = list(zip(times_s, speeds_mps, strict=True))
    return sum(
        (later_s - sooner_s) * (speed_mps if speed_mps >= NO_RATES_BELOW_MPS else 0.0)
        for (sooner_s, speed_mps), (later_s, _) in pairwise(rows)
    )

"""Fixes and bus values aligned onto a station's tick, and what is left when a part of them fails.

At a tick the newest fix that has arrived is carried on to the tick by speed and yaw rate (`reckoning`): of
the bus where it gives them, else as the last fixes show. Nothing that was measured or arrives later than
the tick enters, and between two bus values only those that are both in the past are joined by a line. A
motion is a function of the samples that arrived and of the ticks asked for, not of the order of arrival.

========  ============================================================================================
Mode      When
========  ============================================================================================
gnss+can  a fix younger than three of its periods (0.3 s at 10 Hz, at most `stale_s`), and speed and yaw
          rate of the bus, as fresh by the same rule
gnss      such a fix; the bus is lost, frozen, or was never there: speed and heading are the fix's,
          acceleration and yaw rate slopes through those of the last 1.9 s
          (`modelcast.station.sensing.rates`)
can       no such fix, but both of the bus: dead reckoning from the last fix, up to `dead_reckoning_s`
silent    else: `at` gives None
========  ============================================================================================
"""

import bisect
import math
from collections import Counter, deque
from collections.abc import Iterable

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.core.geodesy import Origin, geodetic_to_local, local_to_geodetic
from modelcast.node.inputs.fix_motion import course_of, end_slope_of, motion_of, origin_of
from modelcast.node.inputs.judging import State, judged
from modelcast.node.inputs.motion import Change, Health, Mode, Motion
from modelcast.node.inputs.outage import LEARNT_S, BusErrors, bus_errors
from modelcast.node.inputs.reckoning import DEFAULT_AXIS_M, Growth, Way, ellipse_covariance_m2, way
from modelcast.node.inputs.samples import PLAUSIBLE, SAME_S, GnssFix, Sample
from modelcast.node.inputs.series import Series
from modelcast.station.sensing.rates import RATES_FROM_VELOCITY

__all__ = ["MotionSource"]

_STOOD_S = 30.0
"""So long a car may stand, and what was learnt of its bus while it drove is still known."""
_JUMP_M = 1.0
"""Where the place is farther from where the last motion led, at a change of mode, a new part begins."""
_MOST_VALUES = 16_384
_MOST_FIXES = 1024
_MOST_WAITING = 65_536
_MOST_EVENTS = 256


class MotionSource:
    """Aligns samples onto ticks.

    Parameters
    ----------
    origin
        Of the node's plane; the first fix used where None.
    stale_s
        Longest age of a fix or bus value that is used as fresh [s]; what is older on arrival is left out,
        "late".
    dead_reckoning_s
        How long a place may be reckoned without fixes [s].
    growth
        How its error grows.

    Raises
    ------
    ValueError
        Where a time is negative or not finite.

    Examples
    --------
    >>> from modelcast.node.inputs.replay import TripReplay
    >>> from modelcast.world.drive import generate_drive
    >>> replay = TripReplay(generate_drive(1, 90.0).truth)
    >>> source = MotionSource(replay.origin)
    >>> source.feed(replay.take(10.0))
    >>> source.at(10.0).mode, [change.after for change in source.events()]
    ('gnss+can', ['gnss+can'])
    >>> source.at(12.0) is None, source.health.why  # neither fix nor bus for two seconds
    (True, 'no fix for 2.0 s and bus lost')
    """

    def __init__(
        self,
        origin: Origin | None = None,
        *,
        stale_s: float = 1.0,
        dead_reckoning_s: float = 5.0,
        growth: Growth | None = None,
    ) -> None:
        if not (0.0 < stale_s < math.inf and 0.0 <= dead_reckoning_s < math.inf):
            raise ValueError(
                f"stale_s must be positive, dead_reckoning_s not negative, got {stale_s}, {dead_reckoning_s}"
            )
        self.origin = origin
        self._knows_plane = origin is not None
        self._stale_s = stale_s
        self._dead_reckoning_s = dead_reckoning_s
        self._growth = growth or Growth()
        self._keep_s = LEARNT_S + _STOOD_S + dead_reckoning_s + stale_s
        self._waiting: list[Sample] = []
        self._fixes: list[GnssFix] = []
        self._bus: dict[str, Series] = {name: Series(_MOST_VALUES) for name in PLAUSIBLE}
        self._events: deque[Change] = deque(maxlen=_MOST_EVENTS)
        self._counts: Counter[str] = Counter()
        self._last_s = -math.inf
        self._last: Motion | None = None
        self._heading_rad = math.nan
        self._state = State("silent", "no fix yet", (), frozenset(), frozenset(), stale_s)
        self._learnt: tuple[tuple[float, ...], BusErrors] | None = None

    def feed(self, samples: Iterable[Sample]) -> None:
        """Take in samples, in any order.

        Parameters
        ----------
        samples
            Fixes and bus values; each counts from when it was received.
        """
        for sample in samples:
            self._counts["samples"] += 1
            if sample.received_s - sample.measured_s > self._stale_s:
                self._counts["late"] += 1
            elif len(self._waiting) >= _MOST_WAITING:
                self._counts["overrun"] += 1
            else:
                self._waiting.append(sample)

    def at(self, now_s: float) -> Motion | None:
        """The motion at a tick, None where it is not known well enough to tell anybody.

        Parameters
        ----------
        now_s
            Now, not before the last call; where it is, all is forgotten and begins anew [s].

        Raises
        ------
        ValueError
            Where it is not finite.
        """
        if not math.isfinite(now_s):
            raise ValueError(f"now_s must be finite, got {now_s}")
        if now_s < self._last_s:
            self._forget()
        self._last_s = now_s
        self._admit(now_s)
        state = judged(now_s, self._fixes, self._bus, stale_s=self._stale_s, reckon_s=self._dead_reckoning_s)
        motion = None if state.mode == "silent" else self._motion(now_s, state)
        if motion is None and state.mode != "silent":
            state = State("silent", "no heading yet", state.fixes, state.fresh, state.frozen, state.stale_s)
        self._tell(now_s, state)
        self._state, self._last = state, motion
        if motion is not None:
            self._heading_rad = motion.heading_rad
        return motion

    def events(self) -> list[Change]:
        """What changed since the last call, oldest first; at most the newest 256."""
        changes = list(self._events)
        self._events.clear()
        return changes

    @property
    def health(self) -> Health:
        """How the inputs were at the last tick."""
        state = self._state
        newest_s = self._fixes[-1].measured_s if self._fixes else -math.inf
        return Health(
            mode=state.mode,
            why=state.why,
            fix_age_s=self._last_s - newest_s if self._fixes else math.inf,
            fix_stale_s=state.stale_s,
            bus_ages_s={name: self._last_s - one.newest_s for name, one in self._bus.items() if len(one)},
            frozen=state.frozen,
            counts=dict(self._counts),
        )

    def _forget(self) -> None:
        """Begin anew, since time went back; samples dated after that will arrive again in their time."""
        self._counts["clock went back"] += 1
        self._waiting.clear()
        self._fixes.clear()
        for series in self._bus.values():
            series.clear()
        self._last = None

    def _admit(self, now_s: float) -> None:
        """Sort in what has arrived, and drop what is too old for anything."""
        later: list[Sample] = []
        for sample in self._waiting:
            if sample.received_s > now_s + SAME_S:
                later.append(sample)
            elif isinstance(sample, GnssFix):
                bisect.insort(self._fixes, sample, key=lambda fix: (fix.measured_s, fix.received_s))
            else:
                self._bus[sample.quantity].add(sample.measured_s, sample.received_s, sample.value)
        self._waiting = later
        oldest_s = now_s - self._keep_s
        first = bisect.bisect_left(self._fixes, oldest_s, key=lambda fix: fix.measured_s)
        del self._fixes[: max(first, len(self._fixes) - _MOST_FIXES)]
        for series in self._bus.values():
            series.forget_before(oldest_s)

    def _motion(self, now_s: float, state: State) -> Motion | None:
        """The motion at a tick, None where no heading is known."""
        fix = state.fixes[-1]
        age_s = now_s - fix.measured_s
        own = motion_of(state.fixes)
        errors = self._errors(state) if state.mode == "can" else BusErrors()
        heading_rad = (
            errors.heading_rad
            if math.isfinite(errors.heading_rad)
            else course_of(state.fixes, within_s=self._stale_s, otherwise_rad=self._heading_rad)
        )
        if not math.isfinite(heading_rad):
            return None
        by_bus = {name: self._bus[name] for name in state.fresh}

        def speed_at(t_s: float) -> float:
            if "speed_mps" in by_bus:
                return errors.speed_scale * by_bus["speed_mps"].at(t_s)
            return max(own.speed_mps + own.acceleration_mps2 * (t_s - fix.measured_s), 0.0)

        def yaw_rate_at(t_s: float) -> float:
            if "yaw_rate_radps" in by_bus:
                return by_bus["yaw_rate_radps"].at(t_s) - errors.yaw_rate_radps
            return own.yaw_rate_radps

        driven = Way(0.0, 0.0, heading_rad, 0.0)
        if age_s > SAME_S:
            series = [by_bus[name] for name in ("speed_mps", "yaw_rate_radps") if name in by_bus]
            knots_s = [knot for one in series for knot in one.knots(fix.measured_s, now_s)]
            driven = way(
                speed_at, yaw_rate_at, knots_s, from_s=fix.measured_s, to_s=now_s, heading_rad=heading_rad
            )
        place_deg, position_m = self._place(fix, driven)
        measured = {name: one.at(now_s) for name, one in by_bus.items()}
        estimated = {
            "speed_mps": speed_at(now_s),
            "acceleration_mps2": own.acceleration_mps2,
            "yaw_rate_radps": own.yaw_rate_radps,
        }
        if "speed_mps" in by_bus and "acceleration_mps2" not in by_bus:
            estimated["acceleration_mps2"] = end_slope_of(
                *by_bus["speed_mps"].since(now_s - RATES_FROM_VELOCITY.span_s)
            )
        derived = {name for name in estimated if name not in by_bus}
        if math.isfinite(own.stated_mps) and state.mode == "gnss" and age_s <= SAME_S:
            derived.discard("speed_mps")
        if not (math.isfinite(fix.heading_rad) and age_s <= SAME_S):
            derived.add("heading_rad")
        moved = estimated | {name: value for name, value in measured.items() if name in estimated}
        wrapped_rad = heading_rad if age_s <= SAME_S else driven.heading_rad % math.tau
        return Motion(
            t_s=now_s,
            mode=state.mode,
            place_deg=place_deg,
            position_m=position_m,
            heading_rad=wrapped_rad,
            derived=frozenset(derived),
            covariance_m2=_covariance_m2(fix) + errors.widened(self._growth).covariance_m2(age_s, driven),
            ellipse_known=fix.has_ellipse,
            age_s=age_s,
            begins=self._begins(now_s, state.mode, position_m),
            altitude_m=fix.altitude_m,
            steering_rad=measured.get("steering_rad", math.nan),
            brake=measured["brake"] >= 1.0 if "brake" in measured else None,
            **moved,
        )

    def _errors(self, state: State) -> BusErrors:
        """What the bus was off by before the fixes were lost, found once for what is known of that time."""
        speed, yaw_rate = self._bus["speed_mps"], self._bus["yaw_rate_radps"]
        last_s = state.fixes[-1].measured_s
        both = (speed, yaw_rate)
        counts = [one.count(state.fixes[0].measured_s, last_s) for one in both]
        nexts = [next(one.knots(last_s, math.inf), -math.inf) for one in both]
        key = (last_s, len(state.fixes), *counts, *nexts)
        if self._learnt is None or self._learnt[0] != key:
            self._learnt = (key, bus_errors(state.fixes, speed, yaw_rate))
        return self._learnt[1]

    def _place(self, fix: GnssFix, driven: Way) -> tuple[tuple[float, float], tuple[float, float]]:
        """Latitude and longitude [deg], and east and north [m], at the end of a way from a fix."""
        if self.origin is None:
            self.origin = origin_of(fix)
        stays = driven.driven_m == 0.0
        place_deg = np.array([[fix.latitude_deg, fix.longitude_deg]])
        if not stays:
            place_deg = local_to_geodetic(np.array([[driven.east_m, driven.north_m]]), origin_of(fix))
        latitude_deg, longitude_deg = place_deg[0].tolist()
        if stays and fix.position_m is not None and self._knows_plane:
            return (latitude_deg, longitude_deg), fix.position_m
        east_m, north_m = geodetic_to_local(place_deg, self.origin)[0].tolist()
        return (latitude_deg, longitude_deg), (east_m, north_m)

    def _begins(self, now_s: float, mode: Mode, position_m: tuple[float, float]) -> bool:
        """Whether a place does not connect with the last motion."""
        last = self._last
        if last is None:
            return True
        if mode == last.mode:
            return False
        since_s = now_s - last.t_s
        east_m = last.position_m[0] + last.speed_mps * since_s * math.sin(last.heading_rad)
        north_m = last.position_m[1] + last.speed_mps * since_s * math.cos(last.heading_rad)
        return math.hypot(position_m[0] - east_m, position_m[1] - north_m) > _JUMP_M

    def _tell(self, now_s: float, state: State) -> None:
        """Note what changed."""
        before = self._state
        if state.mode != before.mode:
            self._events.append(Change(now_s, "mode", before.mode, state.mode, state.why))
        if state.frozen != before.frozen:
            names = [", ".join(sorted(one)) or "nothing" for one in (before.frozen, state.frozen)]
            self._events.append(Change(now_s, "frozen", names[0], names[1], state.why))


def _covariance_m2(fix: GnssFix) -> FloatArray:
    """Of a fix, the default where it states no error."""
    if not fix.has_ellipse:
        return DEFAULT_AXIS_M**2 * np.eye(2)
    return ellipse_covariance_m2(fix.semi_major_m, fix.semi_minor_m, fix.ellipse_orientation_rad)

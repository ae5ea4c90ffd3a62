"""How many changes of name a simple tracker joins again.

All vehicles change their names at once and are silent for a while. The tracker heard every message before
and hears every one after; it matches each new name to the one that ended whose predicted place is nearest,
one to one, by the least sum of distances.

The first table is of vehicles that send true places ten times a second; a place is predicted by the last
place and velocity, and with a profile's name in messages only equal profiles are matched. The second is of
stations as they are: measured places, each policy's own messages, and a tracker that believes what they say
for as long as it needs to, by the model where they carry one. ``linkage.py`` prints the tables; ``--write``
puts them into ``docs/security.md``, ``--check`` tells by its exit code whether that page has them.
"""

import argparse
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from scipy import optimize, stats

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.station.fleet import Fleet
from modelcast.station.receiver.ears import Ears
from modelcast.station.sender.sender import named_sender
from modelcast.station.sensing.sensing import NOWHERE
from modelcast.world.scenario.base import NOBODY, STEP_S, FleetFrame, run_scenario
from modelcast.world.scenario.highway import Highway
from modelcast.world.scenario.sensed import FleetSensor
from modelcast.world.sensors import SensorModel
from page_blocks import put

PAGE = Path(__file__).parents[1] / "docs" / "security.md"
SEEDS = 10
LENGTH_M, WARM_UP_S = 2000.0, 10.0
DENSITIES_PER_KM = (50.0, 200.0)
SILENCES_S = (0.1, 1.0, 5.0, 10.0)
PROFILES = 4
"""Kinds of profile in the fleet, evenly drawn: a profile is shared by a quarter of the stations."""

POLICIES = ("bsm-10hz", "baseline", "mbc")
HEARD_S = 10.0
"""So long everybody is heard before the change."""

LATE_S = 0.001
"""From a message's time to its arrival."""

_RENAMED = 1_000_000
_FAR_M = 1e6


def _velocity(frame: FleetFrame) -> FloatArray:
    course = np.column_stack((np.sin(frame.heading_rad), np.cos(frame.heading_rad)))
    return frame.speed_mps[:, None] * course


def rejoined(before: FleetFrame, after: FleetFrame, silence_s: float, profiles: IntArray | None) -> float:
    """Share of the vehicles heard before and after whose new name is joined to its old one."""
    ids = np.intersect1d(before.vehicle_id, after.vehicle_id)
    ids = ids[ids != NOBODY]
    old = np.array([np.flatnonzero(before.vehicle_id == one)[0] for one in ids.tolist()])
    new = np.array([np.flatnonzero(after.vehicle_id == one)[0] for one in ids.tolist()])
    predicted = (before.position_m + silence_s * _velocity(before))[old]
    cost = np.linalg.norm(predicted[:, None, :] - after.position_m[new][None, :, :], axis=2)
    if profiles is not None:
        cost[profiles[old][:, None] != profiles[old][None, :]] = _FAR_M
    rows, columns = optimize.linear_sum_assignment(cost)
    return float((rows == columns).mean())


def heard_again(
    sender: str, frames: Sequence[FleetFrame], silence_s: float, seed: int
) -> tuple[float, float]:
    """Share of the new names joined to the right old one, and messages a vehicle and second before.

    Raises
    ------
    ValueError
        Where most are not heard both before and after.
    """
    told = named_sender(sender)
    slots = max(frame.vehicle_id.size for frame in frames)
    fleet = Fleet(told, slots=slots, dt_s=STEP_S, seed=seed, spread_s=1.0)
    ears = Ears((told.bank,), expiry_s=np.inf, plausibility=None, capacity=2 * slots, dt_s=STEP_S)
    held, first = ears.init(), ears.init()
    sensor = FleetSensor(SensorModel())
    state = sensor.init(slots, np.random.default_rng(seed))
    ends = len(frames) - 1 - round(silence_s / STEP_S)
    sent = 0
    for step, frame in enumerate(frames):
        seen, state = sensor.sense(state, frame)
        here = seen.active & (seen.vehicle_id != NOBODY)
        last = step == len(frames) - 1
        leaving = fleet.sense(
            step * STEP_S,
            seen.vehicle_id[here] + (_RENAMED if last else 0),
            seen.position_m[here],
            speed_mps=seen.speed_mps[here],
            heading_rad=seen.heading_rad[here],
            acceleration_mps2=seen.acceleration_mps2[here],
            yaw_rate_radps=seen.yaw_rate_radps[here],
        )
        if step == len(frames) - 2:  # those that are silent until then need tell nobody
            for name in seen.vehicle_id[here].tolist():
                fleet.rename(name, name + _RENAMED)
        if step <= ends or last:
            octets, at_s = [one.octets for one in leaving], np.full(len(leaving), step * STEP_S + LATE_S)
            if last:
                _, first = ears.hear(first, octets, at_s, origin=NOWHERE)
            else:
                _, held = ears.hear(held, octets, at_s, origin=NOWHERE)
                sent += len(leaving)
    now_s = (len(frames) - 1) * STEP_S + LATE_S
    old, new = ears.map.believe(held, now_s), ears.map.believe(first, now_s)
    ids = np.intersect1d(old.vehicle, new.vehicle - _RENAMED)
    if 2 * ids.size < new.vehicle.size:
        raise ValueError(f"only {ids.size} of {new.vehicle.size} are heard both before and after the change")
    predicted = old.position_m[[np.flatnonzero(old.vehicle == one)[0] for one in ids.tolist()]]
    stated = new.position_m[[np.flatnonzero(new.vehicle == one + _RENAMED)[0] for one in ids.tolist()]]
    rows, columns = optimize.linear_sum_assignment(
        np.linalg.norm(predicted[:, None, :] - stated[None, :, :], axis=2)
    )
    return float((rows == columns).mean()), sent / (ends + 1) / STEP_S / int(here.sum())


def _share(density: float, silence_s: float, *, named: bool) -> str:
    found: list[float] = []
    for seed in range(SEEDS):
        rng = np.random.default_rng(seed)
        frames = list(
            run_scenario(Highway(LENGTH_M, density, warm_up_s=WARM_UP_S), rng, duration_s=silence_s + STEP_S)
        )
        profiles = rng.integers(PROFILES, size=frames[0].vehicle_id.size) if named else None
        found.append(rejoined(frames[0], frames[round(silence_s / STEP_S)], silence_s, profiles))
    return _interval(found)


def _interval(found: Sequence[float]) -> str:
    half = stats.t.ppf(0.975, SEEDS - 1) * np.std(found, ddof=1) / np.sqrt(SEEDS)
    return f"{100 * np.mean(found):.1f} ± {100 * half:.1f} %"


def stations_table() -> Iterator[str]:
    """Lines of the table of stations as they are."""
    yield f"| vehicles/km | silence at the change, s | {' | '.join(POLICIES)} |"
    yield f"|---|---|{'---|' * len(POLICIES)}"
    rates: dict[str, list[float]] = {name: [] for name in POLICIES}
    for density in DENSITIES_PER_KM:
        for silence_s in SILENCES_S:
            found: dict[str, list[float]] = {name: [] for name in POLICIES}
            for seed in range(SEEDS):
                traffic = Highway(LENGTH_M, density, warm_up_s=WARM_UP_S)
                duration_s = HEARD_S + silence_s + STEP_S
                frames = list(run_scenario(traffic, np.random.default_rng(seed), duration_s=duration_s))
                for name in POLICIES:
                    share, rate_hz = heard_again(name, frames, silence_s, seed)
                    found[name].append(share)
                    rates[name].append(rate_hz)
            yield f"| {density:g} | {silence_s:g} | {' | '.join(_interval(found[one]) for one in POLICIES)} |"
    yield f"| messages/s of a vehicle | | {' | '.join(f'{np.mean(rates[one]):.2f}' for one in POLICIES)} |"


def table() -> Iterator[str]:
    """Lines of the table."""
    yield "| vehicles/km | silence at the change, s | joined again | with profiles that a quarter shares |"
    yield "|---|---|---|---|"
    for density in DENSITIES_PER_KM:
        for silence_s in SILENCES_S:
            shares = (_share(density, silence_s, named=named) for named in (False, True))
            yield f"| {density:g} | {silence_s:g} | {' | '.join(shares)} |"


def main() -> int:
    """Print or put into the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--check", action="store_true")
    asked = parser.parse_args()
    blocks = {"linkage": list(table()), "linkage of stations": list(stations_table())}
    if asked.write or asked.check:
        return put({PAGE: blocks}, check=asked.check)
    for lines in blocks.values():
        sys.stdout.write("\n".join(lines) + "\n\n")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())

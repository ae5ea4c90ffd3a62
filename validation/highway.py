"""Traffic of the reference runs: vehicles at constant speed on a straight road, messages at a fixed rate.

Scripts of this folder share it. Vehicles leave at one end and return at the other; distances do not wrap.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from modelcast.channel.radio import AbstractRadio, Receptions, Transmissions

__all__ = ["Road", "count_outcomes", "messages"]


@dataclass(frozen=True, slots=True)
class Road:
    """One road and its senders.

    Messages come at ``rate_hz``; where ``mean_extra_s`` is above 0 each gap is longer by an exponentially
    distributed time of that mean.
    """

    length_m: float
    vehicles: int
    lanes_each_way: int
    lane_m: float
    speed_mps: float
    rate_hz: float
    size_bytes: int
    power_dbm: float
    mean_extra_s: float = 0.0


def messages(
    road: Road, duration_s: float, seed: int, step_s: float = 0.1
) -> Iterator[tuple[Transmissions, np.ndarray, float]]:
    """Yield transmissions, positions (V, 2) and end of every interval."""
    rng = np.random.default_rng(seed)
    vehicles = road.vehicles
    east = rng.uniform(0.0, road.length_m, vehicles)
    lane = rng.integers(0, 2 * road.lanes_each_way, vehicles)
    speed = np.where(lane < road.lanes_each_way, road.speed_mps, -road.speed_mps)
    period_s = 1.0 / road.rate_hz
    phase_s = rng.uniform(0.0, period_s, vehicles)
    sent, extra_s = np.zeros(vehicles, dtype=np.int64), np.zeros(vehicles)
    for k in range(round(duration_s / step_s)):
        until_s = (k + 1) * step_s
        due_s = phase_s + sent * period_s + extra_s
        senders, times = [], []
        while (due := due_s < until_s).any():
            who = np.flatnonzero(due)
            senders.append(who)
            times.append(due_s[who])
            sent[who] += 1
            if road.mean_extra_s > 0.0:
                extra_s[who] += rng.exponential(road.mean_extra_s, who.size)
            due_s = phase_s + sent * period_s + extra_s
        sender = np.concatenate(senders) if senders else np.empty(0, dtype=np.int64)
        ready_s = np.concatenate(times) if times else np.empty(0)
        order = np.argsort(ready_s, kind="stable")
        sender, ready_s = sender[order], np.maximum(ready_s[order], k * step_s)
        batch = Transmissions(
            sender,
            ready_s,
            size_bytes=np.full(sender.size, road.size_bytes, dtype=np.int64),
            power_dbm=np.full(sender.size, road.power_dbm),
            message_id=np.arange(sender.size, dtype=np.int64) + k * 10 * vehicles,
        )
        yield batch, np.stack([east, road.lane_m * lane], axis=1), until_s
        east = (east + speed * step_s) % road.length_m


def count_outcomes(
    radio: AbstractRadio[Any], road: Road, duration_s: float, seed: int, warm_up_s: float = 0.0
) -> tuple[np.ndarray, float]:
    """Outcomes by distance bin (bins, 5) and the median channel busy ratio of all vehicles and windows."""
    state = radio.init(road.vehicles, np.random.default_rng([seed, 1]))
    outcomes: Any = 0
    ratios = []
    heard: Receptions
    for batch, position_m, until_s in messages(road, duration_s, seed):
        heard, state = radio.step(state, batch, position_m, until_s)
        if until_s > warm_up_s + 1e-9:
            outcomes = outcomes + heard.outcomes
            ratios.append(radio.channel_busy_ratio(state))
    return np.asarray(outcomes), float(np.median(np.concatenate(ratios)))

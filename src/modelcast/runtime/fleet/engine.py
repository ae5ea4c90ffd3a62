"""A run of the closed loop: frames in, counts out."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import KW_ONLY, dataclass
from itertools import chain
from typing import Any

import numpy as np

from modelcast.channel.radio import AbstractRadio
from modelcast.core.arrays import FloatArray, IntArray
from modelcast.runtime.fleet.arrays import Tally
from modelcast.runtime.fleet.coming import with_next
from modelcast.runtime.fleet.loop import FleetLoop
from modelcast.runtime.fleet.mix import Mix
from modelcast.runtime.fleet.mixed import GroupRun, MixedTally
from modelcast.runtime.fleet.observer import AbstractObserver
from modelcast.runtime.fleet.people import People, PeopleRun
from modelcast.runtime.fleet.roadside import Roadside, RoadsideRun
from modelcast.runtime.fleet.settings import NetworkSettings
from modelcast.station.sender.message_arrays import SentTally
from modelcast.station.sender.sender import Sender
from modelcast.world.scenario.base import FleetFrame
from modelcast.world.scenario.sensed import FleetSensor

__all__ = ["NetworkRun", "run_network"]


@dataclass(frozen=True, slots=True)
class NetworkRun:
    """What one run counted, the warm-up left out but in the series.

    Parameters
    ----------
    sent, tally
        Counts of senders, and of hosts.
    outcomes
        Pairs of frame and vehicle in reach by the radio's bins of distance and cause, (bins, causes).
    expired
        Messages that were never sent.
    vehicle_s
        Time observed, over all vehicles [s].
    busy_ratio
        Mean channel busy ratio over vehicles and time.
    series
        (steps, len(SERIES)), a row a step.
    recent
        Tracking errors at the headline distances, (seconds, BINS), a row a second.
    sender_bytes
        Payload bytes by sub-model, (M,), those of several senders one after another.
    mixed
        Counts by sender and reading; no rows where all speak alike and read models.
    groups
        What the vehicles of each sender did.
    roadside
        What roadside units counted; None where there are none. Frames that they sent, and those in reach of
        them, are among the ``outcomes``.
    people
        What the devices of people did; None where they did as vehicles. What they sent is among ``sent``, and
        what they hold among the ``tally``.
    """

    sent: SentTally
    tally: Tally
    _: KW_ONLY
    outcomes: IntArray
    expired: int
    vehicle_s: float
    busy_ratio: float
    series: FloatArray
    recent: IntArray
    sender_bytes: IntArray
    mixed: MixedTally
    groups: tuple[GroupRun, ...]
    roadside: RoadsideRun | None = None
    people: PeopleRun | None = None


def run_network(
    frames: Iterable[FleetFrame],
    sender: Sender | Mix,
    radio: AbstractRadio[Any],
    settings: NetworkSettings | None = None,
    *,
    seed: int,
    sensor: FleetSensor | None = None,
    threads: int = 1,
    progress: Callable[[int], None] | None = None,
    observer: AbstractObserver | None = None,
    roadside: Roadside | None = None,
    people: People | None = None,
) -> NetworkRun:
    """Run a fleet on the air and return what was counted.

    Parameters
    ----------
    frames
        Frames of one run, `NetworkSettings.dt_s` apart. Several threads take one ahead of its step, unless
        somebody looks on.
    sender
        What every vehicle sends, and when; or who sends and reads how.
    radio
        The channel they share.
    settings
        What is tracked and counted; None for the defaults.
    seed
        Of senders, radio and sensors; frames bring their own chance. Same seed, same counts.
    sensor
        What the vehicles see of themselves; None for the truth.
    threads
        How many work on the fleet; the result is the same whatever their number.
    progress
        Called after every step with the number of steps done.
    observer
        Looks on; None for nobody.
    roadside
        Units beside the vehicles; None for none.
    people
        What the devices of people do; None for what vehicles do.

    Raises
    ------
    ValueError
        Where there is no frame, frames are not a step apart, the run ends within the warm-up, or the bank has
        a sub-model whose receivers keep what they held (`PointFunctions.absorb`): hosts of a fleet share what
        each message says.

    Examples
    --------
    >>> from modelcast.channel.dsrc import Dsrc
    >>> from modelcast.station.sender.sender import named_sender
    >>> from modelcast.world.scenario.base import run_scenario
    >>> from modelcast.world.scenario.highway import Highway
    >>> road = Highway(500.0, 20.0, warm_up_s=0.0)
    >>> frames = run_scenario(road, np.random.default_rng(1), duration_s=2.0)
    >>> run = run_network(frames, named_sender("bsm-10hz"), Dsrc(), NetworkSettings(warm_up_s=1.0), seed=1)
    >>> round(run.vehicle_s, 6), int(run.sent.causes.sum())
    (10.0, 100)
    """
    mix = sender if isinstance(sender, Mix) else Mix((sender,))
    senders = mix.senders if people is None else (*mix.senders, people.sender)
    members = [member for one in senders for member in one.bank.members]
    kept = [member.name for member in members if member.held_parameters]
    if kept:
        raise ValueError(f"hosts of a fleet cannot keep what {', '.join(kept)} needs from earlier messages")
    chosen = NetworkSettings() if settings is None else settings
    pending: Iterator[FleetFrame] = iter(frames)
    first = next(pending, None)
    if first is None:
        raise ValueError("frames must hold at least one frame")
    loop = FleetLoop(
        first, mix, radio, chosen, seed=seed, sensor=sensor, threads=threads, roadside=roadside, people=people
    )
    warm_up = round(chosen.warm_up_s / chosen.dt_s)
    a_second = max(1, round(1.0 / chosen.dt_s))
    outcomes: IntArray | None = None
    expired, series, recent = 0, list[FloatArray](), list[IntArray]()
    # Who looks on sees a fleet that knows nothing of the next frame.
    every = with_next(chain([first], pending), are_told=observer is None and loop.senses_ahead)
    for number, (frame, coming) in enumerate(every):
        if number == warm_up:
            loop.forget_counts()
            outcomes, expired = None, 0
        if observer is not None and number:
            observer.before(loop, frame)
        received, row = loop.step(frame, coming)
        if observer is not None:
            observer.after(loop, frame)
        outcomes = received.outcomes.copy() if outcomes is None else outcomes + received.outcomes
        expired += received.expired.size
        series.append(row)
        if (number + 1) % a_second == 0:
            recent.append(loop.take_recent())
        if progress is not None:
            progress(number + 1)
    if len(series) <= warm_up or outcomes is None:
        raise ValueError(f"the run must outlast the warm-up of {chosen.warm_up_s} s, got {len(series)} steps")
    rows = np.array(series)
    counted = rows[warm_up:]
    return NetworkRun(
        loop.sent,
        loop.tally,
        outcomes=outcomes,
        expired=expired,
        vehicle_s=float(counted[:, 0].sum() * chosen.dt_s),
        busy_ratio=float(np.nansum(counted[:, 3] * counted[:, 0]) / max(counted[:, 0].sum(), 1.0)),
        series=rows,
        recent=np.array(recent, dtype=np.int64).reshape(len(recent), -1),
        sender_bytes=np.concatenate([one.update_bytes for one in senders]),
        mixed=loop.mixed,
        groups=tuple(
            GroupRun(one.sender.name, one.sent, one.vehicle_steps * chosen.dt_s) for one in loop.speakers
        ),
        roadside=None if loop.units is None else loop.units.run(),
        people=loop.people_run(),
    )

"""Epochs of one NMEA receiver: its GGA and RMC of one instant together, with their times.

An epoch has at most one sentence of each kind. A second GGA of the same instant begins a second epoch of that
time, which is skipped as a duplicate later and never mixed with the first: loggers that stamp whole seconds
write ten.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import UTC, date, datetime

from modelcast.core.exceptions import DataFormatError
from modelcast.io.nmea_receivers import Heard, apart_m

__all__ = ["Epoch", "epochs_of", "midnights", "refuse_second_receiver", "timed"]

_DAY_S = 86400.0
_ONE_EPOCH_M = 11.0
"""Sentences of one epoch are not further apart; at 100 m/s that is a tenth of a second."""
_NEXT_TO_EACH_OTHER_M = 50.0
"""The same where one follows the other directly: one of the two may have been rounded badly."""
_WAITING = 50
"""Epochs that an RMC may come after its GGA, and the other way round."""
_LOOKED_THROUGH = 1000
"""Instants among which those that wait no more are looked for."""
_BOTH = "GGA+RMC"


@dataclass(frozen=True, slots=True)
class Epoch:
    """All that a receiver says about one instant; `heard.fix` holds both sentences joined."""

    heard: Heard
    t_s: float = 0.0


def midnights(before_s: float, after_s: float) -> int:
    """Return 1 where midnight lies between two times of day, -1 where the later one is late from before it.

    Examples
    --------
    >>> midnights(86399.9, 0.0), midnights(0.0, 86399.9), midnights(10.0, 10.1)
    (1, -1, 0)
    """
    fall_s = before_s - after_s
    return int(fall_s > _DAY_S / 2) - int(fall_s < -_DAY_S / 2)


def epochs_of(heard: Sequence[Heard]) -> list[Epoch]:
    """Return one receiver's sentences joined by instant, in order of the first sentence of each."""
    epochs: list[Heard] = []
    waiting: dict[tuple[int, float] | None, list[int]] = {}
    for one in heard:
        key = one.instant if one.fix.time_of_day_s == one.fix.time_of_day_s else None
        if len(waiting) > _LOOKED_THROUGH:
            oldest = len(epochs) - _WAITING
            waiting = {key: places for key, places in waiting.items() if places and places[-1] >= oldest}
        places = waiting.setdefault(key, [])
        places[:] = [at for at in places if at >= len(epochs) - _WAITING]
        at = next((at for at in places if _completes(epochs[at], one)), None)
        if at is None:
            places.append(len(epochs))
            epochs.append(one)
        else:
            places.remove(at)
            epochs[at] = replace(epochs[at], fix=epochs[at].fix.joined(one.fix))
    return [Epoch(one) for one in epochs]


def _completes(epoch: Heard, one: Heard) -> bool:
    """Return whether a sentence is the one that an epoch lacks."""
    if epoch.fix.kind in {one.fix.kind, _BOTH}:
        return False
    largest_m = _NEXT_TO_EACH_OTHER_M if one.order == epoch.order + 1 else _ONE_EPOCH_M
    return not (one.placed and epoch.placed) or apart_m(epoch.fix, one.fix) <= largest_m


def timed(epochs: Sequence[Epoch]) -> tuple[list[Epoch], float | None]:
    """Return the epochs with times from the first date's midnight, and that midnight in Unix time.

    Times have the date of the last RMC; between dates midnights count. Times are not Unix times yet, because
    in float64 those lose a quarter of a microsecond.
    """
    dated = [(epoch.heard.days, epoch.heard.fix.day) for epoch in epochs if epoch.heard.fix.day is not None]
    first_s = 0.0 if not dated else _unix_day_s(dated[0][1])
    # A midnight before the first date belongs to the day before it.
    days, day_s = (dated[0][0], 0.0) if dated else (0, 0.0)
    found: list[Epoch] = []
    for epoch in epochs:
        fix = epoch.heard.fix
        if fix.day is not None:
            days, day_s = epoch.heard.days, _unix_day_s(fix.day) - first_s
        since_s = day_s + _DAY_S * (epoch.heard.days - days)
        found.append(replace(epoch, t_s=since_s + fix.time_of_day_s))
    return found, first_s if dated else None


def refuse_second_receiver(path: str, epochs: Sequence[Epoch]) -> None:
    """Raise `DataFormatError` where positions of one instant jump there and back: two receivers."""
    placed = [epoch.heard for epoch in epochs if epoch.heard.placed]
    again = jumping = 0
    worst: Heard | None = None
    for first, second, third in zip(placed, placed[1:], placed[2:], strict=False):
        if first.instant == second.instant:
            again += 1
            jump_m = apart_m(first.fix, second.fix)
            if jump_m > _ONE_EPOCH_M and apart_m(first.fix, third.fix) < jump_m / 2:
                jumping += 1
                worst = worst or second
    if worst is not None and jumping > 2 and 2 * jumping > again:
        raise DataFormatError(
            path,
            "two receivers with one talker: positions of the same time jump there and back",
            row=worst.line,
            remedy="Write the sentences of each receiver into a file of their own.",
        )


def _unix_day_s(day: date | None) -> float:
    return 0.0 if day is None else datetime(day.year, day.month, day.day, tzinfo=UTC).timestamp()

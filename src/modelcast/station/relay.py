"""What a relay repeats of what it heard: each message unchanged, once, young, and not where another did so.

A relay adds nothing: what it sends has the original's temporary id, count and time, so that hosts drop what
they have and age the rest honestly. Sensor-sharing messages, by which a unit tells what it sees itself, are
another matter and not made here.
"""

from dataclasses import KW_ONLY, dataclass

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray, IntArray

__all__ = ["Overheard", "RelayRule", "RelayState", "Repeats"]

_STAGGER = 0.5 * (np.sqrt(5.0) - 1.0)
"""Golden ratio: shifts the times of units that stand in one row, so that no two send at once."""


@dataclass(frozen=True, slots=True, eq=False)
class Overheard:
    """K frames that relays heard, in order of arrival.

    Parameters
    ----------
    unit
        Which relay heard it, from 0, (K,).
    key
        Names the message: equal for the original and all copies, (K,).
    author
        Whose message it is, (K,).
    made_s
        When it was made, (K,) [s].
    heard_s
        Arrival, (K,) [s].
    distance_m
        From the relay to the place that the message is about, (K,) [m].
    is_copy
        Whether another relay sent the frame, (K,).

    Raises
    ------
    ValueError
        Where lengths differ.
    """

    unit: IntArray
    key: IntArray
    author: IntArray
    _: KW_ONLY
    made_s: FloatArray
    heard_s: FloatArray
    distance_m: FloatArray
    is_copy: BoolArray

    def __post_init__(self) -> None:
        for name in ("key", "author", "made_s", "heard_s", "distance_m", "is_copy"):
            if getattr(self, name).shape != self.unit.shape:
                raise ValueError(f"{name} must be {self.unit.shape}, got {getattr(self, name).shape}")

    @classmethod
    def nothing(cls) -> "Overheard":
        """No frames."""
        none: IntArray = np.zeros(0, dtype=np.int64)
        real: FloatArray = np.zeros(0)
        no: BoolArray = np.zeros(0, dtype=np.bool_)
        return cls(none, none, none, made_s=real, heard_s=real, distance_m=real, is_copy=no)


@dataclass(frozen=True, slots=True, eq=False)
class RelayState:
    """What relays remember: messages young enough to be repeated, whether they wait or are done with.

    Parameters
    ----------
    held
        One row a message and relay.
    done
        Which are done with: repeated, or never to be, (N,).
    credit
        Messages that each relay may send beyond its rate, below 1, (R,).
    repeated, by_another, replaced, too_old, too_far
        Messages so far that were repeated, that another relay had repeated, that a newer one of their author
        took the place of, that grew too old waiting, that were about a place too far away, (R,).
    """

    held: Overheard
    done: BoolArray
    credit: FloatArray
    _: KW_ONLY
    repeated: IntArray
    by_another: IntArray
    replaced: IntArray
    too_old: IntArray
    too_far: IntArray


@dataclass(frozen=True, slots=True, eq=False)
class Repeats:
    """What relays send in a turn, by rising time.

    Parameters
    ----------
    unit, key
        Which relay sends which message, (M,).
    send_s
        When, (M,) [s].
    """

    unit: IntArray
    key: IntArray
    send_s: FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class RelayRule:
    """When a message that was heard is repeated.

    Parameters
    ----------
    max_age_s
        Messages older than this at the beginning of a turn are not repeated in it [s].
    rate_hz
        A relay repeats at most so many a second, spread evenly; of more, those that came first [1/s].
    within_m
        It repeats only messages about places so near to it [m]; infinite for all.

    Raises
    ------
    ValueError
        Where a value is out of its range.

    Notes
    -----
    The rule knows no chance: the same frames at the same times give the same repeats. Of two messages of one
    author that wait, only the newer is repeated. A message heard from another relay first is not repeated, so
    relays make no chains; one that waits is dropped as soon as another relay's copy is heard.

    Examples
    --------
    >>> rule = RelayRule()
    >>> one = Overheard(
    ...     np.array([0]), np.array([7]), np.array([3]), made_s=np.array([0.0]), heard_s=np.array([0.01]),
    ...     distance_m=np.array([40.0]), is_copy=np.array([False]),
    ... )
    >>> repeats, state = rule.turn(rule.init(1), one, 0.1, 0.2)
    >>> repeats.key.tolist(), repeats.send_s.round(3).tolist()
    ([7], [0.1])
    >>> repeats, state = rule.turn(state, one, 0.2, 0.3)
    >>> repeats.key.size
    0
    """

    max_age_s: float = 0.3
    rate_hz: float = 200.0
    within_m: float = 200.0

    def __post_init__(self) -> None:
        for name in ("max_age_s", "rate_hz"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0.0):
                raise ValueError(f"{name} must be positive and finite, got {value}")
        if not self.within_m > 0.0:
            raise ValueError(f"within_m must be positive, got {self.within_m}")

    def init(self, units: int) -> RelayState:
        """Relays that have heard nothing.

        Parameters
        ----------
        units
            How many.
        """
        if units < 1:
            raise ValueError(f"units must be at least 1, got {units}")
        counts = [np.zeros(units, dtype=np.int64) for _ in range(5)]
        return RelayState(
            Overheard.nothing(),
            np.zeros(0, dtype=np.bool_),
            np.zeros(units),
            repeated=counts[0],
            by_another=counts[1],
            replaced=counts[2],
            too_old=counts[3],
            too_far=counts[4],
        )

    def turn(
        self, state: RelayState, heard: Overheard, now_s: float, until_s: float
    ) -> tuple[Repeats, RelayState]:
        """What relays send from now until the next turn, and what they remember then.

        Parameters
        ----------
        state
            What they remember.
        heard
            What they heard since the last turn.
        now_s, until_s
            Bounds of the turn, the end excluded [s].

        Raises
        ------
        ValueError
            Where the turn does not last, or a unit is none of theirs.
        """
        if not until_s > now_s:
            raise ValueError(f"until_s must be later than {now_s}, got {until_s}")
        units = state.credit.size
        if heard.unit.size and not (heard.unit.min() >= 0 and heard.unit.max() < units):
            raise ValueError(f"unit must lie in 0..{units - 1}, got {heard.unit.min()}..{heard.unit.max()}")
        held, done = _joined(state.held, heard), np.append(state.done, np.zeros(heard.unit.size, np.bool_))
        first, group = _first_of_each(held.unit, held.key)
        copied: BoolArray = np.zeros(first.size, dtype=np.bool_)
        copied[group[held.is_copy]] = True
        held, done = _taken(held, first), done[first]
        counts: dict[str, IntArray] = {}

        def finish(name: str, which: BoolArray) -> None:
            ended = which & ~done
            counts[name] = getattr(state, name) + np.bincount(held.unit[ended], minlength=units)
            done[ended] = True

        finish("by_another", copied)
        finish("too_far", ~(held.distance_m <= self.within_m))
        young: BoolArray = held.made_s >= now_s - self.max_age_s
        finish("too_old", ~young)
        finish("replaced", _has_newer(held, done))
        credit = state.credit + self.rate_hz * (until_s - now_s)
        chosen, place, number = _earliest(held, done, np.floor(credit + 1e-9).astype(np.int64))
        sent: BoolArray = np.zeros(done.size, dtype=np.bool_)
        sent[chosen] = True
        finish("repeated", sent)
        unit = held.unit[chosen]
        shift = (unit * _STAGGER) % 1.0 if units > 1 else np.zeros(unit.size)
        slots = np.maximum(number, np.ceil(self.rate_hz * (until_s - now_s)))
        send_s = np.minimum(now_s + (place + shift) * (until_s - now_s) / slots, np.nextafter(until_s, now_s))
        order = np.lexsort((unit, send_s))
        left = np.minimum(credit - np.bincount(unit, minlength=units), np.nextafter(1.0, 0.0))
        return Repeats(unit[order], held.key[chosen][order], send_s[order]), RelayState(
            _taken(held, np.flatnonzero(young)), done[young], np.maximum(left, 0.0), **counts
        )


_COLUMNS = ("unit", "key", "author", "made_s", "heard_s", "distance_m", "is_copy")


def _joined(one: Overheard, other: Overheard) -> Overheard:
    unit, key, author, *rest = (
        np.concatenate([getattr(one, name), getattr(other, name)]) for name in _COLUMNS
    )
    return Overheard(unit, key, author, **dict(zip(_COLUMNS[3:], rest, strict=True)))


def _taken(held: Overheard, rows: IntArray) -> Overheard:
    unit, key, author, *rest = (getattr(held, name)[rows] for name in _COLUMNS)
    return Overheard(unit, key, author, **dict(zip(_COLUMNS[3:], rest, strict=True)))


def _first_of_each(unit: IntArray, key: IntArray) -> tuple[IntArray, IntArray]:
    """First row of each message of a unit, in the order of rows, and to which of them each row belongs."""
    order = np.lexsort((key, unit))
    begins = np.ones(order.size, dtype=np.bool_)
    begins[1:] = (np.diff(unit[order]) != 0) | (np.diff(key[order]) != 0)
    first = order[begins]  # lexsort is stable: the lowest row of its kind comes first
    belongs = np.empty(order.size, dtype=np.int64)
    belongs[order] = np.cumsum(begins) - 1
    by_row = np.argsort(first, kind="stable")
    rank = np.empty(first.size, dtype=np.int64)
    rank[by_row] = np.arange(first.size)
    return first[by_row], rank[belongs]


def _has_newer(held: Overheard, done: BoolArray) -> BoolArray:
    """Which waiting messages have a newer one of their author at their relay, waiting or done with."""
    order = np.lexsort((held.made_s, held.author, held.unit))
    same = (np.diff(held.unit[order]) == 0) & (np.diff(held.author[order]) == 0)
    newer = np.zeros(order.size, dtype=np.bool_)
    newer[order[:-1]] = same & (np.diff(held.made_s[order]) > 0)
    return newer & ~done


def _earliest(held: Overheard, done: BoolArray, most: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Rows that each relay sends, first come; place of each among those of its relay, and their number."""
    waiting = np.flatnonzero(~done)
    order = waiting[np.lexsort((held.key[waiting], held.heard_s[waiting], held.unit[waiting]))]
    unit = held.unit[order]
    begins = np.searchsorted(unit, np.arange(most.size))
    place = np.arange(order.size) - begins[unit]
    taken = place < most[unit]
    number = np.bincount(unit[taken], minlength=most.size)
    return order[taken], place[taken], number[unit[taken]]

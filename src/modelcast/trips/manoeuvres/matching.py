"""How well the manoeuvres found agree with those known."""

from collections.abc import Iterable
from dataclasses import dataclass

from modelcast.trips.manoeuvres.base import FoundManoeuvre

__all__ = ["Match", "match_manoeuvres"]


@dataclass(frozen=True, slots=True)
class Match:
    """Known manoeuvres against found ones.

    Parameters
    ----------
    hits
        Pairs of a known manoeuvre and the found one that is taken for it.
    missed
        Known ones that were not found.
    spurious
        Found ones that are not known.
    """

    hits: tuple[tuple[FoundManoeuvre, FoundManoeuvre], ...]
    missed: tuple[FoundManoeuvre, ...]
    spurious: tuple[FoundManoeuvre, ...]


def match_manoeuvres(known: Iterable[FoundManoeuvre], found: Iterable[FoundManoeuvre]) -> Match:
    """Pair known and found manoeuvres of one kind and side that overlap in time, each at most once.

    Parameters
    ----------
    known, found
        Manoeuvres of one trip.

    Examples
    --------
    >>> from modelcast.trips.manoeuvres.base import ManoeuvreKind
    >>> known = FoundManoeuvre(ManoeuvreKind.TURN, 1.0, 4.0, size=1.5, side="left")
    >>> other = FoundManoeuvre(ManoeuvreKind.TURN, 2.0, 5.0, size=1.4, side="right")
    >>> match = match_manoeuvres([known], [other])
    >>> len(match.hits), len(match.missed), len(match.spurious)
    (0, 1, 1)
    """
    left = list(found)
    hits = list[tuple[FoundManoeuvre, FoundManoeuvre]]()
    missed = list[FoundManoeuvre]()
    for one in known:
        same = [other for other in left if (other.kind, other.side) == (one.kind, one.side)]
        near = [other for other in same if one.overlaps(other)]
        if near:
            left.remove(near[0])
            hits.append((one, near[0]))
        else:
            missed.append(one)
    return Match(tuple(hits), tuple(missed), tuple(left))

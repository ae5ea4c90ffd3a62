"""What a user is told where trips are judged that the profile in use was trained on."""

from collections.abc import Sequence

__all__ = ["training_note"]

_NAMED = 3


def training_note(names: Sequence[str], trips: int) -> list[str]:
    """One line that names such trips, or none where there are none.

    Parameters
    ----------
    names
        Identifiers of the trips that the profile was trained on.
    trips
        How many there are in all.

    Examples
    --------
    >>> training_note(["a/b"], 2)
    ['the profile in use was trained on 1 of these 2 trips (a/b): its figures flatter there']
    """
    if not names:
        return []
    more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
    known = f"{len(names)} of these {trips} trips ({', '.join(names[:_NAMED])}{more})"
    return [f"the profile in use was trained on {known}: its figures flatter there"]

"""Octets as hexadecimal digits in a document."""

__all__ = ["octets_of_digits", "shown"]

_LONGEST_SHOWN = 60


def shown(value: object) -> str:
    """Return a value as an error tells it, cut where it is long.

    Parameters
    ----------
    value
        What was given.
    """
    text = repr(value)
    return text if len(text) <= _LONGEST_SHOWN else f"{text[: _LONGEST_SHOWN - 3]}..."


def octets_of_digits(name: str, given: object, *, count: int | None = None) -> bytes:
    """Octets that hexadecimal digits stand for.

    Parameters
    ----------
    name
        What the caller calls them.
    given
        Text of digits, two an octet; blanks between octets are allowed.
    count
        How many octets there must be; None for any number.

    Raises
    ------
    ValueError
        Where it is anything else.

    Examples
    --------
    >>> octets_of_digits("id", "41 7a", count=2)
    b'Az'
    """
    wanted = "hexadecimal digits" if count is None else f"{2 * count} hexadecimal digits"
    try:
        octets = bytes.fromhex(given) if isinstance(given, str) else None
    except ValueError:
        octets = None
    if octets is None or (count is not None and len(octets) != count):
        raise ValueError(f"{name} must be {wanted}, got {shown(given)}")
    return octets

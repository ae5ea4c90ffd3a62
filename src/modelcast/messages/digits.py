"""Octets as hexadecimal digits in a document."""

from modelcast.core.rules import shown

__all__ = ["octets_of_digits"]


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

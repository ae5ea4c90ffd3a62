"""Amounts of memory and disk as users name them."""

import re

__all__ = ["parse_octets"]

_UNITS = {
    "": 1,
    "k": 10**3,
    "m": 10**6,
    "g": 10**9,
    "t": 10**12,
    "ki": 2**10,
    "mi": 2**20,
    "gi": 2**30,
    "ti": 2**40,
}
_FORM = re.compile(r"\s*(\d+(?:\.\d+)?)\s*([kmgt]i?)?b?\s*", re.IGNORECASE)


def parse_octets(text: str, option: str) -> int:
    """Octets of an amount as in ``2GB``, ``1.5 GiB`` or ``500000000``.

    Parameters
    ----------
    text
        A number with k, M, G or T (decimal), Ki, Mi, Gi or Ti (binary), and B, as one likes.
    option
        What errors call it.

    Raises
    ------
    ConfigError
        Where it is none, or nothing.

    Examples
    --------
    >>> parse_octets("2GB", "--memory"), parse_octets("1.5gib", "--memory")
    (2000000000, 1610612736)
    """
    from modelcast.core.exceptions import ConfigError

    found = _FORM.fullmatch(text)
    octets = 0 if found is None else int(float(found[1]) * _UNITS[(found[2] or "").lower()])
    if octets < 1:
        raise ConfigError(f"{option} {text}: name an amount, as 2GB or 500MiB")
    return octets

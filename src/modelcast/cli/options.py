"""Options that several commands share."""

from typing import Annotated

from cyclopts import Parameter

__all__ = ["Columns", "Format", "parse_columns"]

Format = Annotated[
    str | None,
    Parameter(help="Name of the files' format; found from their content where not given."),
]

Columns = Annotated[
    str | None,
    Parameter(
        help="Column names for csv and parquet, by meaning: 't=time,east=x,north=y,speed=v' or "
        "'t=time,lat=latitude,lon=longitude', optionally 'vehicle=id'."
    ),
]


def parse_columns(text: str | None) -> dict[str, str] | None:
    """A column map from ``meaning=name`` pairs.

    Parameters
    ----------
    text
        Pairs separated by commas; None for no map.

    Raises
    ------
    ConfigError
        Where a pair has no equals sign.

    Examples
    --------
    >>> parse_columns("t=time,east=x")
    {'t': 'time', 'east': 'x'}
    """
    from modelcast.core.exceptions import ConfigError

    if text is None:
        return None
    pairs: dict[str, str] = {}
    for part in text.split(","):
        meaning, equals, name = part.partition("=")
        if not (equals and meaning.strip() and name.strip()):
            raise ConfigError(f"--columns: '{part}' is not meaning=name, as in t=time,east=x,north=y")
        pairs[meaning.strip()] = name.strip()
    return pairs

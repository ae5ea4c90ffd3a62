"""XML of any size as a stream, and what no honest file holds refused: entities, endless depth and tokens."""

from collections.abc import Iterator
from typing import Any
from xml.parsers import expat

from modelcast.core.exceptions import DataFormatError
from modelcast.io.fcd_source import opened

__all__ = ["DEEPEST", "LONGEST_TOKEN", "fed", "require_shallow"]

DEEPEST = 64
"""Elements inside one another; files of trips have under ten."""

LONGEST_TOKEN = 4 * 2**20
"""Octets of one tag or comment; the longest honest ones are comments that hold a configuration."""

_CHUNK = 2**16


def fed(path: str, parser: expat.XMLParserType) -> Iterator[None]:
    """Feed a file, also a packed one, to a parser; yield after every part, and before an error.

    Parameters
    ----------
    path
        The file.
    parser
        With its handlers; a fresh one.

    Raises
    ------
    DataFormatError
        Where the file cannot be read, is no well-formed XML, declares entities, or has a tag or comment of
        over `LONGEST_TOKEN`.
    """

    def refuse_entity(name: str, *_: Any) -> None:
        raise DataFormatError(
            path,
            f"declares the entity {name[:40]!r}, which files of trips have no use for",
            row=parser.CurrentLineNumber,
            remedy="Remove the declaration (DOCTYPE).",
        )

    parser.EntityDeclHandler = refuse_entity
    done = 0
    try:
        with opened(path) as file:
            while chunk := file.read(_CHUNK):
                parser.Parse(chunk, False)
                done += len(chunk)
                if done - parser.CurrentByteIndex > LONGEST_TOKEN:
                    raise DataFormatError(
                        path,
                        f"a tag or comment of over {LONGEST_TOKEN} octets",
                        row=parser.CurrentLineNumber,
                        remedy="Check that it is what it should be.",
                    )
                yield
            parser.Parse(b"", True)
            yield
    except expat.ExpatError as error:
        yield
        raise DataFormatError(
            path,
            f"is not well-formed XML: {expat.ErrorString(error.code)}",
            row=error.lineno,
            remedy="Check that it is complete.",
        ) from error
    except (LookupError, ValueError) as error:  # of an encoding that the parser does not know
        raise DataFormatError(
            path, f"is not readable as XML: {error}", row=1, remedy="Write it in UTF-8."
        ) from error


def require_shallow(path: str, depth: int, row: int) -> None:
    """Refuse elements nested deeper than `DEEPEST`.

    Parameters
    ----------
    path, row
        Where.
    depth
        Of the element that begins there; the root has 1.

    Raises
    ------
    DataFormatError
        Where it is too deep.
    """
    if depth > DEEPEST:
        raise DataFormatError(
            path,
            f"elements are nested deeper than {DEEPEST}",
            row=row,
            remedy="Check that it is what it should be.",
        )

"""``modelcast encode``: messages as JSON to octets."""

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, cast

from cyclopts import Parameter

from modelcast.cli.options import Source

__all__ = ["encode"]


def encode(
    source: Source = "-",
    *,
    json: Annotated[bool, Parameter(negative="")] = True,
    profile: Path | None = None,
) -> int:
    """Print the octets of messages as hexadecimal digits, one message a line.

    For example: `modelcast encode message.json`

    Parameters
    ----------
    source
        A JSON file, or JSON itself, or - for the standard input: one document, a list of them, or one a line,
        as `modelcast decode --json` prints them. Fields are in SI units; those left out are unavailable.
    json
        The form of the source; there is no other.
    profile
        A profile that `modelcast train` wrote, held beside the one that ships with modelcast.
    """
    from modelcast.cli.messages import Profiles, octets_of
    from modelcast.cli.terminal import complain
    from modelcast.core.exceptions import ConfigError

    del json
    profiles = Profiles(profile)
    good = bad = 0
    for place, document in _documents(source):
        try:
            octets = octets_of(document, profiles)
        except ValueError as error:
            complain(f"{place}: {error}")
            bad += 1
            continue
        good += 1
        print(octets.hex())
    if not good + bad:
        raise ConfigError(f"'{source[:60]}' holds no message")
    return 0 if not bad else 3 if good else 2


def _documents(source: str) -> Iterator[tuple[str, object]]:
    """Yield each document and where it stands."""
    import json as json_format
    import sys

    from modelcast.core.exceptions import ConfigError

    name = "standard input" if source == "-" else source
    if not source.strip() or source.lstrip().startswith(("{", "[")):
        name, text = "argument", source
    else:
        try:
            text = (sys.stdin.buffer.read() if source == "-" else Path(source).read_bytes()).decode()
        except FileNotFoundError:
            raise ConfigError(f"there is no file {source}, and it is not JSON either") from None
        except UnicodeDecodeError:
            raise ConfigError(f"{name} is not text") from None
    try:
        whole = json_format.loads(text)
    except (ValueError, RecursionError):
        yield from _lines(name, text)
        return
    documents = cast("list[object]", whole) if isinstance(whole, list) else [whole]
    for number, document in enumerate(documents, start=1):
        yield f"{name}, message {number}", document


def _lines(name: str, text: str) -> Iterator[tuple[str, object]]:
    """Yield the document of each line."""
    import json as json_format

    from modelcast.core.exceptions import ConfigError

    for number, line in enumerate(text.splitlines(), start=1):
        if line.strip():
            try:
                document = json_format.loads(line)
            except (ValueError, RecursionError) as error:
                raise ConfigError(f"{name}, line {number}: not JSON: {error}") from error
            yield f"{name}, line {number}", document

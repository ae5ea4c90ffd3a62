"""``modelcast decode``: octets of messages as a table, or as JSON."""

from collections.abc import Iterator
from pathlib import Path

from modelcast.cli.options import Source

__all__ = ["decode"]


def decode(source: Source, *, json: bool = False, profile: Path | None = None) -> int:
    """Show the fields of encoded messages, with their units: basic safety messages, models, identifications.

    Parameters
    ----------
    source
        Hexadecimal digits of one message; or a file of hexadecimal digits, one message a line; or a file that
        is one message; or - for the standard input.
    json
        Print one JSON document a line instead of tables, in SI units; `modelcast encode` reads them back.
    profile
        A profile that `modelcast train` wrote, held beside the one that ships with modelcast.
    """
    import json as json_format
    import sys

    from rich.console import Console

    from modelcast.cli.messages import Profiles, show
    from modelcast.core.exceptions import CodecError, ConfigError

    profiles = Profiles(profile)
    console = Console()
    good = bad = 0
    for place, octets in _messages(source):
        if octets is None:
            print(f"modelcast: {place}: not an even number of hexadecimal digits", file=sys.stderr)
            bad += 1
            continue
        try:
            shown = show(octets, place, profiles)
        except CodecError as error:
            print(f"modelcast: {place}: {error}", file=sys.stderr)
            bad += 1
            continue
        good += 1
        bad += bool(shown.faults)
        for fault in shown.faults:
            print(f"modelcast: {place}: {fault}", file=sys.stderr)
        if json:
            print(json_format.dumps(shown.document))
        else:
            console.print(*shown.tables, sep="\n")
    if not good + bad:
        raise ConfigError(f"'{source[:60]}' holds no message")
    return 0 if not bad else 3 if good else 2


def _messages(source: str) -> Iterator[tuple[str, bytes | None]]:
    """Yield a message's place and octets; None where a line is not what it should be."""
    from modelcast.core.exceptions import ConfigError

    content = _content(source)
    if content is None:
        octets = _unhex(source)
        if octets is None:
            raise ConfigError(f"'{source[:60]}' is neither a file nor an even number of hexadecimal digits")
        yield "argument", octets
        return
    name = "standard input" if source == "-" else source
    if not all(octet in b"\t\n\r" or 0x20 <= octet < 0x7F for octet in content):
        yield name, content
        return
    for number, line in enumerate(content.decode("ascii").splitlines(), start=1):
        if line.strip() and not line.lstrip().startswith("#"):
            yield f"{name}, line {number}", _unhex(line)


def _content(source: str) -> bytes | None:
    """Octets of a file or of the standard input; None where there is no such file."""
    import sys
    from pathlib import Path

    if source == "-":
        return sys.stdin.buffer.read()
    if not source.strip():
        return None  # and not the folder that an empty path means
    try:
        return Path(source).read_bytes()
    except (FileNotFoundError, ValueError):
        return None
    except OSError:
        # Digits of a long message are too long a name for a file.
        if _unhex(source) is None:
            raise
        return None


def _unhex(text: str) -> bytes | None:
    """Octets of hexadecimal digits, blanks between octets allowed; None where they are none."""
    try:
        return bytes.fromhex(text.strip().removeprefix("0x")) or None
    except ValueError:
        return None

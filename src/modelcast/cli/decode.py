"""``modelcast decode``: octets of messages as tables, or as JSON."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from modelcast.cli.options import Source

if TYPE_CHECKING:
    from modelcast.io.message_text import Piece

__all__ = ["decode"]


def decode(source: Source, *, json: bool = False, profile: Path | None = None) -> int:
    """Show the fields of encoded messages with their units: vehicles, people, models, identifications.

    For example: `modelcast decode message.hex`

    Parameters
    ----------
    source
        Hexadecimal digits or Base64; or a file of them: one message a line, wrapped, dumped by xxd, hexdump
        or od, an array, or behind labels; or a binary file of messages, or a capture (pcap, pcapng); or - for
        the standard input. Messages may stand one after another, in an unsecured IEEE 1609.2 SPDU, or behind
        other octets; what is not read is told.
    json
        Print one JSON document a line instead of tables, in SI units; `modelcast encode` reads them back.
    profile
        A profile that `modelcast train` wrote, held beside the one that ships with modelcast.
    """
    import json as json_format

    from modelcast.cli.messages import Profiles
    from modelcast.cli.messages import show as read
    from modelcast.cli.terminal import complain, show
    from modelcast.core.exceptions import CodecError, ConfigError
    from modelcast.messages.sequence import parts_of

    profiles = Profiles(profile)
    good = bad = 0
    for piece in _pieces(source):
        if piece.fault:
            complain(f"{piece.place}: {piece.fault}")
            bad += 1
            continue
        parts = parts_of(piece.octets)
        for part in parts:
            place = piece.place if len(parts) == 1 or not part.start else f"{piece.place}, octet {part.start}"
            faults = [part.fault] if part.fault else []
            if not part.fault:
                try:
                    shown = read(part.octets, place, profiles)
                except CodecError as error:
                    faults = [f"{error}{_hint(piece)}"]
                else:
                    good += 1
                    faults = shown.faults
                    print(json_format.dumps(shown.document)) if json else show(*shown.tables)
            bad += bool(faults)
            for fault in faults:
                complain(f"{place}: {fault}")
    if not good + bad:
        raise ConfigError(f"'{source[:60]}' holds no message")
    return 0 if not bad else 3 if good else 2


def _hint(piece: "Piece") -> str:
    if not piece.announced:
        return ""
    return (
        f"; the beginning of a message of {piece.announced} octets, of which {len(piece.octets)} are here: "
        "cut short, or digits wrapped over several lines?"
    )


def _pieces(source: str) -> "Iterator[Piece]":
    """Yield what stands in the source, with the source in each place."""
    from dataclasses import replace

    from modelcast.core.exceptions import ConfigError
    from modelcast.io.message_file import pieces_of
    from modelcast.io.message_text import pieces_of_text

    content = _content(source)
    if content is None:
        found = list(pieces_of_text(source))
        if not any(piece.octets for piece in found):
            why = f": {found[0].fault}" if found else ""
            raise ConfigError(
                f"'{source[:60]}' is neither a file nor an even number of hexadecimal digits{why}"
            )
        name = "argument"
    else:
        found, name = pieces_of(content), "standard input" if source == "-" else source
    for piece in found:
        # The only line of an argument is the argument.
        place = "" if content is None and piece.place == "line 1" else piece.place
        yield replace(piece, place=f"{name}, {place}" if place else name)


def _content(source: str) -> bytes | None:
    """Octets of a file or of the standard input; None where there is no such file."""
    import sys

    from modelcast.io.message_file import read_octets

    if source == "-":
        return sys.stdin.buffer.read()
    if not source.strip():
        return None  # and not the folder that an empty path means
    try:
        return read_octets(source)
    except (FileNotFoundError, NotADirectoryError, ValueError):
        return None
    except OSError as error:
        import errno

        # Digits of a long message are too long a name for a file.
        if error.errno != errno.ENAMETOOLONG:
            raise
        return None

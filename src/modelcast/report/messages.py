"""What ``modelcast decode`` shows: a table a message."""

from collections.abc import Iterable, Iterator, Sequence
from typing import cast

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from modelcast.messages.bsm import BasicSafetyMessage
from modelcast.messages.bsm_fields import CORE_FIELDS, PART_II_NAMES
from modelcast.messages.contents import Content
from modelcast.messages.fields import Field
from modelcast.messages.psm import PersonalSafetyMessage
from modelcast.messages.psm_fields import PART_SHAPES, PERSON_FIELDS
from modelcast.messages.shapes import AbstractShape, Choice, Number, Record, Series, Truth, Value
from modelcast.report.literal import literal

__all__ = ["message_table", "person_table", "shown_value"]


def message_table(message: BasicSafetyMessage, title: str) -> RenderableType:
    """Fields of a message with their units, within 80 columns, and the octets of all else.

    Parameters
    ----------
    message
        Any message.
    title
        What stands above.
    """
    table = _table(CORE_FIELDS, message.core.codes)
    lines = [
        f"part II, id {number}, {PART_II_NAMES.get(number, 'unknown')}, {_shown(octets)}"
        for number, octets in message.part_ii
    ]
    lines += _opaque(message.regional, message.additions, message.frame_additions)
    return Group(literal(title), table, *map(Text, lines))


def person_table(message: PersonalSafetyMessage, title: str) -> RenderableType:
    """Fields of a personal safety message with their units, its optional parts, and the octets of all else.

    Parameters
    ----------
    message
        Any message.
    title
        What stands above.
    """
    there = [
        (field, code)
        for field, code in zip(PERSON_FIELDS, message.codes, strict=True)
        if message.has_elevation or field.name != "elevation_m"
    ]
    table = _table([field for field, _ in there], [code for _, code in there])
    for shape in PART_SHAPES:
        part = message.part(shape.name)
        if part is not None:
            for row in _rows(shape, part):
                table.add_row(*row)
    lines = _opaque(message.regional, message.additions, message.frame_additions)
    return Group(literal(title), table, *map(Text, lines))


def _table(fields: Sequence[Field], codes: Sequence[int]) -> Table:
    table = Table()
    table.add_column("field")
    table.add_column("SAE J2735", no_wrap=True)
    table.add_column("value", justify="right", min_width=16, overflow="fold")
    table.add_column("code", justify="right", no_wrap=True)
    for field, code in zip(fields, codes, strict=True):
        table.add_row(_words(field.quantity), field.standard_name, shown_value(field, code), str(code))
    return table


def _rows(shape: AbstractShape, value: Value, depth: int = 0) -> Iterator[tuple[str, str, str, str]]:
    """Yield name, the standard's name, value and code of a part, and of what it holds set in below it."""
    blanks = " " * depth
    name, standard_name = blanks + _words(shape.name), blanks + shape.standard_name
    inner: Iterable[tuple[AbstractShape, Value | None]] = ()
    match shape:
        case Number(field):
            code = cast("int", value)
            yield blanks + _words(field.quantity), standard_name, shown_value(field, code), str(code)
            return
        case Truth():
            yield name, standard_name, "yes" if value else "no", str(value)
            return
        case Record(members=members):
            inner = zip(members, cast("tuple[Value | None, ...]", value), strict=True)
        case Series(item=item):
            inner = ((item, one) for one in cast("tuple[Value, ...]", value))
        case Choice(alternatives=alternatives):
            place, one = cast("tuple[int, Value]", value)
            inner = ((alternatives[place], one),)
        case _:
            raise TypeError(f"no rows of {shape}")
    yield name, standard_name, "", ""
    for member, one in inner:
        if one is not None:
            yield from _rows(member, one, depth + 1)


def _words(name: str) -> str:
    return name.replace("_", " ")


def _opaque(
    regional: Sequence[Content],
    additions_of_message: Sequence[bytes | None],
    additions_of_frame: Sequence[bytes | None],
) -> list[str]:
    """One line for each part that every message may have as octets."""
    lines = [f"regional extension, id {number}, {_shown(octets)}" for number, octets in regional]
    for name, additions in (
        ("extension addition", additions_of_message),
        ("extension addition of the frame", additions_of_frame),
    ):
        lines += [
            f"{name}, number {number}, {_shown(octets)}"
            for number, octets in enumerate(additions)
            if octets is not None
        ]
    return lines


def shown_value(field: Field, code: int) -> str:
    """A code as people read it, in the standard's unit.

    Parameters
    ----------
    field
        The field.
    code
        Its code.

    Examples
    --------
    >>> from modelcast.messages.bsm_fields import CORE_FIELDS, CORE_INDEX
    >>> shown_value(CORE_FIELDS[CORE_INDEX["heading_rad"]], 21392)
    '267.4 deg'
    """
    if field.choices:
        return field.choices[code]
    if field.flags:
        most = len(field.flags) - 1
        names = [name for bit, name in enumerate(field.flags) if code >> (most - bit) & 1]
        return ", ".join(names) or "none"
    if code == field.unavailable:
        return "unavailable"
    if field.is_reserved(code):
        return "reserved"
    if field.name == "temporary_id":
        return f"{code:08x}"
    return f"{code * field.step[0] / field.step[1]:.10g} {field.unit}".rstrip()


def _shown(octets: bytes) -> str:
    return f"{len(octets)} bytes: {octets.hex()}"

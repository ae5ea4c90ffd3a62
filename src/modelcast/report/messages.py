"""What ``modelcast decode`` shows: a table a message."""

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from modelcast.messages.bsm import BasicSafetyMessage
from modelcast.messages.bsm_fields import CORE_FIELDS, PART_II_NAMES
from modelcast.messages.fields import Field
from modelcast.report.literal import literal

__all__ = ["message_table", "shown_value"]


def message_table(message: BasicSafetyMessage, title: str) -> RenderableType:
    """Fields of a message with their units, within 80 columns, and the octets of all else.

    Parameters
    ----------
    message
        Any message.
    title
        What stands above.
    """
    table = Table()
    table.add_column("field", no_wrap=True)
    table.add_column("SAE J2735", no_wrap=True)
    table.add_column("value", justify="right", min_width=16)
    table.add_column("code", justify="right", no_wrap=True)
    for field, code in zip(CORE_FIELDS, message.core.codes, strict=True):
        name = field.quantity.replace("_", " ")
        table.add_row(name, field.standard_name, shown_value(field, code), str(code))
    return Group(literal(title), table, *(Text(line) for line in _opaque(message)))


def _opaque(message: BasicSafetyMessage) -> list[str]:
    """One line for each part that is kept as octets."""
    lines = [
        f"part II, id {number}, {PART_II_NAMES.get(number, 'unknown')}, {_shown(octets)}"
        for number, octets in message.part_ii
    ]
    lines += [f"regional extension, id {number}, {_shown(octets)}" for number, octets in message.regional]
    for name, additions in (
        ("extension addition", message.additions),
        ("extension addition of the frame", message.frame_additions),
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

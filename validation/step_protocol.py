"""The tables of docs/serve.md, from the file that describes the step protocol.

python validation/step_protocol.py [--write | --check]
"""

import argparse
from collections.abc import Iterable, Sequence
from enum import IntEnum
from pathlib import Path

from modelcast.apps.warnings import Level
from modelcast.core.kinds import Kind
from modelcast.node.serving.schema import Field, step_protocol
from modelcast.runtime.external.exchange import FOREIGN
from modelcast.station.policy.base import MessageKind
from modelcast.station.receiver.local_dynamic_map import Receipt
from page_blocks import put

PAGE = Path(__file__).parents[1] / "docs" / "serve.md"


def main() -> int:
    """Print, write or check the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    which = parser.add_mutually_exclusive_group()
    which.add_argument("--write", action="store_true", help="put the tables into the page")
    which.add_argument("--check", action="store_true", help="exit with 1 where the page has others")
    given = parser.parse_args()
    if given.write or given.check:
        return put({PAGE: {"messages": messages(), "numbers": numbers()}}, check=given.check)
    print("\n".join([*messages(), "", *numbers()]))
    return 0


def messages() -> list[str]:
    """A heading, a sentence and a table for each message."""
    spoken = step_protocol()
    lines = [f"Version {spoken.protocol} of the protocol."]
    for message in spoken.messages.values():
        answered = f" Answered by `{message.answer}`." if message.answer else ""
        lines += ["", f"### `{message.name}`, from the {message.origin}", "", message.text + answered, ""]
        lines += table(("field", "type", "unit", "meaning"), map(row, message.fields.values()))
    return lines


def row(field: Field) -> tuple[str, str, str, str]:
    """A field as a row."""
    lacks = ""
    if field.default is not None:
        lacks = f" (default {field.default})"
    elif field.optional:
        lacks = " (optional)"
    return f"`{field.name}`", f"`{field.type}`", field.unit, f"{field.text}{lacks}"


def numbers() -> list[str]:
    """What the numbers of enumerated fields mean."""

    def told(kind: type[IntEnum]) -> str:
        return ", ".join(f"{one.value} {one.name.lower().replace('_', ' ')}" for one in kind)

    receipts = ", ".join(f"{one.value} {one.reason}" for one in Receipt)
    return table(
        ("field", "numbers"),
        (
            ("`kind` of `step` and `beliefs`", told(Kind)),
            ("`kind` of `sent`", told(MessageKind)),
            ("`receipt`", receipts),
            ("`level`", told(Level)),
            ("`message` of `step`", f"{FOREIGN} for a foreign message"),
        ),
    )


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """Lines of a table."""
    return [f"| {' | '.join(one)} |" for one in (head, ["---"] * len(head), *rows)]


if __name__ == "__main__":
    raise SystemExit(main())

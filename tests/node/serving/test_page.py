"""Claims about docs/serve.md and the file that describes the protocol."""

import subprocess
import sys
from dataclasses import MISSING, fields
from pathlib import Path
from typing import Any

import pytest

from modelcast.node.serving.schema import step_protocol
from modelcast.runtime.external.exchange import HostBeliefs, HostWarnings, Sent, SessionSettings, Step

ROOT = Path(__file__).parents[3]


def test_the_tables_of_the_page_are_what_their_script_writes() -> None:
    words = [sys.executable, str(ROOT / "validation" / "step_protocol.py"), "--check"]
    assert subprocess.run(words, check=False).returncode == 0  # noqa: S603 - our own script


@pytest.mark.parametrize(
    ("record", "message"),
    [
        (SessionSettings, "hello"), (Step, "step"), (Sent, "sent"), (HostBeliefs, "beliefs"),
        (HostWarnings, "warned"),
    ],
)  # fmt: skip
def test_messages_have_the_fields_of_their_records(record: Any, message: str) -> None:
    described = dict(step_protocol().messages[message].fields)
    described.pop("protocol", None)
    assert set(described) == {one.name for one in fields(record)}
    for one in fields(record):
        field = described[one.name]
        lacks = one.default is not MISSING or one.default_factory is not MISSING
        assert field.may_lack == lacks, one.name
        if field.default is not None:
            assert field.default == one.default

"""Real messages for the tests of messages."""

import json
from pathlib import Path
from typing import Any

import pytest


@pytest.fixture(scope="session")
def real_messages(data_folder: Path) -> list[dict[str, Any]]:
    """Sixty real messages in hexadecimal digits, with the values that another decoder printed."""
    path = data_folder.resolve().parent / "vectors" / "bsm_jpo_ode.json"
    return json.loads(path.read_text(encoding="utf-8"))["vectors"]

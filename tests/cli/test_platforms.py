"""Claims about systems that cannot run everything: what they cannot is refused."""

import asyncio
import sys

import pytest

from modelcast.cli.stopping import stopped_by_signals
from modelcast.core.exceptions import ConfigError


def test_a_node_or_server_on_windows_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    async def begin() -> None:
        monkeypatch.setattr(sys, "platform", "win32")
        with stopped_by_signals(0.0):
            pass

    with pytest.raises(ConfigError, match="run on Linux and macOS"):
        asyncio.run(begin())

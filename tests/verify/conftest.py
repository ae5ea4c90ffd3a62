"""Fixtures of what is slow."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest

from .browser import opened_browser

if TYPE_CHECKING:
    from playwright.sync_api import Browser


@pytest.fixture(scope="module")
def browser() -> Iterator["Browser"]:
    """A headless Chromium, or a skip."""
    with opened_browser() as opened:
        yield opened

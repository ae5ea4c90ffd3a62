"""Fixtures that several test modules share."""

import os
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def data_folder() -> Path:
    """Folder of the real trips, from MODELCAST_DATA; MODELCAST_REQUIRE_DATA=1 makes its absence a failure."""
    folder = os.environ.get("MODELCAST_DATA", "")
    if not folder:
        reason = "MODELCAST_DATA is not set: tests on real trips need the folder it names"
        if os.environ.get("MODELCAST_REQUIRE_DATA") == "1":
            pytest.fail(reason)
        pytest.skip(reason)
    return Path(folder)

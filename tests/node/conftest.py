"""Recordings of made drives."""

from pathlib import Path

import pytest

from modelcast.node.config import NodeConfig, Pseudonyms, Sending

from .three_cars import drive


@pytest.fixture(scope="session")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Eight seconds of one car, whole."""
    (path,) = drive(tmp_path_factory.mktemp("recording"))
    return path


@pytest.fixture(scope="session")
def two(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """The same of two cars that hear each other, which keep their names."""
    config = NodeConfig(pseudonyms=Pseudonyms(least_s=0.0, most_s=0.0), sending=Sending(policy="mbc"))
    return drive(tmp_path_factory.mktemp("two"), recorded=2, config=config)

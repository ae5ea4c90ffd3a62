"""Claims about readers of other packages that fail: it costs the file alone."""

from collections.abc import Callable
from pathlib import Path

import pytest

from modelcast.cli.reading import PARTLY_FAILED, TripSource

MODULE = """
from modelcast.io.base import AbstractTripReader

class Leaving(AbstractTripReader):
    def matches(self, path, head):
        if path.name == "matched.bye":
            raise SystemExit(3)
        return path.suffix == ".bye"

    def read(self, path, on_skipped=None):
        raise SystemExit(3)
        yield
"""


@pytest.mark.parametrize("name", ["read.bye", "matched.bye"])
def test_a_reader_that_ends_the_process_costs_its_file_alone(
    name: str, other_package: Callable[..., Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other_package(
        "strange", {"modelcast.readers": {"bye": "leaving_reader:Leaving"}}, {"leaving_reader": MODULE}
    )
    file, other = tmp_path / name, tmp_path / "other.bye"
    for one in (file, other):
        one.write_text("any")
    source = TripSource([file, other])
    assert not list(source)
    assert set(source.failures) == {name, "other.bye"}
    assert "its reader failed with SystemExit: 3" in source.failures[name]
    assert source.exit_code == PARTLY_FAILED
    assert f"{file}: its reader failed with SystemExit: 3" in capsys.readouterr().err

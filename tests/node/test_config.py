"""Claims about a node's configuration file."""

from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.core.exceptions import DataFormatError
from modelcast.node.config import NodeConfig, read_config
from modelcast.node.toml_file import tables_of

WHOLE = """
[vehicle]
length_m = 12
name = "bus"

[gnss]
source = "trip:drive.csv"  # a comment
speed = 2.5

[applications]
names = ["fcw"]
"""


def test_what_is_left_out_has_its_default(tmp_path: Path) -> None:
    path = tmp_path / "node.toml"
    path.write_text(WHOLE, encoding="utf-8")
    found = read_config(path)
    assert (found.vehicle.length_m, found.vehicle.width_m, found.vehicle.name) == (12, 1.8, "bus")
    assert (found.gnss.source, found.gnss.speed) == ("trip:drive.csv", 2.5)
    assert found.applications.names == ("fcw",)
    assert found.air == NodeConfig().air


def test_whatever_listens_stays_on_this_machine_unless_told_otherwise() -> None:
    own = NodeConfig()
    assert {own.air.interface, own.page.host, own.metrics.host} == {"127.0.0.1"}
    assert (own.page.on, own.metrics.port, own.subscribe.path) == (False, 0, "")


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("[air]\n\nport = 99999\n", r"row 3: \[air\] port must be a whole number from 1 to 65535, got 99999"),
        ("[air]\n'port' = true\n", r"row 2: \[air\] port must be a whole number"),
        ("[air]\nprot = 3\n", r"row 2: \[air\] has no prot\. It has transport, group, port"),
        ("\n[sky]\n", r"row 2: \[sky\] is not known\. There are \[station\], \[vehicle\], \[sending\]"),
        ("air = 3\n", r"row 1: air must be a table, got 3\. Write \[air\]"),
        ("[air\n", r"row 1: is no TOML"),
        ("[vehicle]\n[vehicle]\n", r"row 2: is no TOML"),
        ('[sending]\npolicy = "cow"\n', r"row 2: \[sending\] policy must be one of 'bsm-10hz'"),
        (
            '[applications]\nnames = ["fcw", "cow"]\n',
            r"row 2: \[applications\] names\[1\] must be one of 'fcw'",
        ),
        ("[pseudonyms]\nleast_s = 9.0\nmost_s = 1.0\n", r"row 1: \[pseudonyms\]: least_s must not be above"),
        ("[vehicle]\nlength_m = nan\n", r"row 2: \[vehicle\] length_m must be a number"),
        ('[vehicle]\nname = "a\\u001b[2J"\n', r"row 2: \[vehicle\] name must be a text without control"),
    ],
)
def test_a_mistake_is_told_with_its_line_and_what_would_be_right(text: str, told: str) -> None:
    with pytest.raises(DataFormatError, match=told):
        tables_of(text, NodeConfig, "node.toml")


@given(st.text(max_size=200))
def test_whatever_is_written_is_taken_or_told(text: str) -> None:
    with suppress(DataFormatError):
        assert isinstance(tables_of(text, NodeConfig), NodeConfig)


def test_a_file_that_is_none_is_told(tmp_path: Path) -> None:
    with pytest.raises(DataFormatError, match="Check the path"):
        read_config(tmp_path / "none.toml")
    (tmp_path / "bytes.toml").write_bytes(b"\xff\xfe")
    with pytest.raises(DataFormatError, match="not UTF-8"):
        read_config(tmp_path / "bytes.toml")
    (tmp_path / "large.toml").write_bytes(b"#" * (2**20 + 1))
    with pytest.raises(DataFormatError, match="larger than"):
        read_config(tmp_path / "large.toml")

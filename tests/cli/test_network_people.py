"""Claims about people in ``modelcast network``: their devices, SUMO's persons, and the film of a meeting."""

import json
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from modelcast.cli.app import USAGE, run
from modelcast.cli.people_plan import PeoplePlan
from modelcast.core.exceptions import ConfigError
from modelcast.station.policy.j2945 import J2945
from modelcast.station.sender.sender import named_sender

CROSSING = ["network", "--scenario", "crossing", "--blocks", "2", "--density", "25", "--pedestrians", "6",
            "--cyclists", "6", "--duration", "3", "--warm-up", "1", "--seeds", "1", "--jobs", "1",
            "--quiet"]  # fmt: skip


def asked(**changed: object) -> PeoplePlan:
    plan = PeoplePlan(**changed).checked(there_are=True)  # type: ignore[arg-type]
    assert plan is not None
    return plan


@pytest.mark.slow
def test_people_send_by_a_policy_of_their_own_and_it_is_told(tmp_path: Path) -> None:
    """A row a run in the summary and in a file; what is received is unread, too far, or read."""
    out = tmp_path / "out"
    assert run([*CROSSING, "--policy", "bsm-10hz", "--people-policy", "mbc", "--out", str(out)]) == 0
    summary = json.loads((out / "summary.json").read_text())
    (row,) = summary["people"]
    assert (row["policy"], row["people_policy"], row["people"]) == ("bsm-10hz", "mbc", pytest.approx(12.0))
    assert 0.9 < row["message_rate_hz"] < 3.0
    parts = row["unread_rate_hz"] + row["far_rate_hz"] + row["read_rate_hz"]
    assert parts == pytest.approx(row["received_rate_hz"])
    assert summary["options"]["people"]["policy"] == "mbc"
    assert pq.read_table(out / "people.parquet").num_rows == 1
    assert "A device of people:" in (out / "table.md").read_text()
    assert "Devices of people" in (out / "report.html").read_text()


@pytest.mark.slow
def test_people_send_personal_messages_by_the_profile_of_people(tmp_path: Path) -> None:
    """Frames of 29 octets by constant velocity, of 35 by the stop-and-go switch: six more on the air."""
    frame_bytes = dict[str, float]()
    for bank in ("people", "cv"):
        out = tmp_path / bank
        line = [*CROSSING, "--policy", "mbc", "--certificates", "unsigned", "--out", str(out)]
        assert run(line if bank == "people" else [*line, "--people-bank", bank]) == 0
        (row,) = json.loads((out / "summary.json").read_text())["people"]
        frame_bytes[bank] = row["frame_bytes"]
    assert frame_bytes["people"] == pytest.approx(frame_bytes["cv"] + 6.0)
    assert asked().bank == "people"


def test_a_bank_of_people_that_is_none_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    line = [*CROSSING, "--policy", "mbc", "--people-bank", "walkers", "--out", str(tmp_path / "out")]
    assert run(line) == USAGE
    assert "walkers" in capsys.readouterr().err


def test_sumo_persons_are_on_the_air(tmp_path: Path) -> None:
    """As SUMO documents its XML: persons are elements beside vehicles in each timestep."""
    lines = ['<?xml version="1.0" encoding="UTF-8"?>', "<fcd-export>"]
    for number in range(40):
        t_s = 0.1 * number
        lines += [
            f'  <timestep time="{t_s:.2f}">',
            (
                f'    <vehicle id="car" x="{8.0 * t_s:.2f}" y="0.00" angle="90.00" type="DEFAULT_VEHTYPE" '
                f'speed="8.00" pos="{8.0 * t_s:.2f}" lane="e_0" slope="0.00"/>'
            ),
            (
                f'    <person id="ped0" x="30.00" y="{-8.0 + 1.3 * t_s:.2f}" angle="0.00" '
                f'type="DEFAULT_PEDTYPE" speed="1.30" pos="{1.3 * t_s:.2f}" edge="w" slope="0.00"/>'
            ),
            "  </timestep>",
        ]
    path, out = tmp_path / "town.xml", tmp_path / "out"
    path.write_text("\n".join([*lines, "</fcd-export>"]) + "\n", encoding="utf-8")
    line = f"network --scenario {path} --policy bsm-10hz --duration 4 --warm-up 1 --seeds 1 --jobs 1 --quiet"
    assert run([*line.split(), "--persons", "--out", str(out)]) == 0
    (row,) = json.loads((out / "summary.json").read_text())["people"]
    assert row["people"] == pytest.approx(1.0)
    assert row["message_rate_hz"] == pytest.approx(10.0)
    assert 8.0 < row["read_rate_hz"] <= 10.0


@pytest.mark.slow
def test_a_meeting_is_filmed_without_units_and_with_them(tmp_path: Path) -> None:
    out = tmp_path / "out"
    line = (
        "network --scenario crossing --blocks 3 --density 25 --pedestrians 10 --cyclists 40 --duration 25 "
        "--warm-up 1 --seeds 1 --jobs 1 --policy baseline --roadside crossings --relay --film --quiet"
    )
    assert run([*line.split(), "--out", str(out)]) == 0
    table = pq.read_table(out / "film.parquet").to_pydict()
    assert set(table["run"]) == {"no unit", "units relay"}
    assert False in table["in_sight"][:30]
    assert (out / "film.png").stat().st_size > 10_000
    assert (out / "film.svg").is_file()


@pytest.mark.parametrize(
    ("more", "told"),
    [
        (["--film"], "--film needs people and buildings"),
        (["--people-power", "10"], "need people"),
        (["--scenario", "crossing", "--people-reach", "50"], "need people"),
    ],
)
def test_what_needs_people_is_refused_without(
    more: list[str], told: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    line = ["network", "--duration", "2", "--warm-up", "1", "--out", str(tmp_path / "out"), "--quiet", *more]
    assert run(line) == USAGE
    assert told in " ".join(capsys.readouterr().err.split())


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"height_m": 1.0}, "--people-height must be above 1 m"),
        ({"height_m": 3.0}, "must together not be above 0 dB"),
        ({"antenna_db": 7.5}, "must together not be above 0 dB"),
        ({"power_dbm": 30.0}, "--people-power must be at most 23 dBm"),
        ({"reach_m": 0.0}, "--people-reach must be positive"),
        ({"keep_alive_s": 0.0}, "--people-keep-alive must be positive"),
        ({"policy": "shout"}, "--people-policy: Unknown policy 'shout'"),
    ],
)
def test_a_device_that_cannot_be_is_refused(changed: dict[str, object], told: str) -> None:
    with pytest.raises(ConfigError, match=told):
        asked(**changed)


def test_height_and_gain_add_up() -> None:
    """17.3 dB a tenfold effective height, which is what is above 1 m."""
    assert asked(height_m=1.5, antenna_db=-3.0).gain_db == pytest.approx(-3.0)
    assert asked(height_m=1.05, antenna_db=0.0).gain_db == pytest.approx(-17.3)


@pytest.mark.parametrize("name", ["bsm-10hz", "j2945", "cam"])
def test_power_is_a_most(name: str) -> None:
    sender = named_sender(name)
    assert sender.at_power(23.0) == sender
    weaker = sender.at_power(8.0)
    assert weaker.power_dbm == 8.0
    if isinstance(weaker.policy, J2945):
        given = weaker.policy.parameters
        assert given.min_power_dbm == given.max_power_dbm == given.start_power_dbm == 8.0

"""Claims about the C++ header: it compiles without a warning, and what it drives is what Python drives."""

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from modelcast.core.geodesy import Origin
from modelcast.station.station import Station

from ..convoy import Convoy  # noqa: TID252 - tests are no package
from .cpp_build import CPP, TRIED, built, needs_compiler, output, ran

pytestmark = needs_compiler


@pytest.fixture(name="socket")
def _socket(tmp_path: Path) -> Iterator[Path]:
    """Where `modelcast serve` listens, a process of its own."""
    pytest.importorskip("msgpack", reason="the extra `node` brings MessagePack")
    path = tmp_path / "s"
    words = [sys.executable, "-m", "modelcast", "serve", "--socket", str(path)]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as server:  # noqa: S603 - our own interpreter
        assert server.stdout is not None
        assert server.stderr is not None
        assert server.stdout.readline() == f"listening at {path}\n"
        yield path
        server.terminate()
        assert server.wait(30.0) == 0
        assert server.stderr.read() == ""
    assert not path.exists()


@pytest.mark.parametrize("sender", ["mbc", "j2945-mbc"])
def test_its_vehicle_sends_the_octets_of_a_station(sender: str, socket: Path, tmp_path: Path) -> None:
    convoy = Convoy(1)
    station = Station(sender, temporary_id=3, seed=5, origin=Origin(48.0, 11.5))
    lines, octets = list[str](), list[bytes]()
    for number in range(150):
        step = convoy.step(number)
        columns = {
            name: float(getattr(step, name)[0])
            for name in ("speed_mps", "heading_rad", "acceleration_mps2", "yaw_rate_radps")
        }
        place = tuple(step.position_m[0].tolist())
        lines.append(" ".join(repr(one) for one in (step.t_s, *place, *columns.values())))
        octets += [one.octets for one in station.sense(step.t_s, place, **columns)]
    program = built(tmp_path / "octets", TRIED / "octets.cpp")
    told = output(program, socket, sender, 5, given="\n".join(lines)).splitlines()
    assert told == [*(one.hex() for one in octets), "t_s 0"]
    assert len(octets) > 10


def test_the_loop_prints_what_each_heard_and_a_map_that_holds(socket: Path, tmp_path: Path) -> None:
    program = built(tmp_path / "loop", CPP / "loop.cpp")
    lines = output(program, socket, 4, 10).splitlines()
    heard = [line for line in lines if "heard" in line]
    assert len(heard) == 4
    assert all(int(line.split()[-1]) > 20 for line in heard)
    # 60 m apart and 150 m of reach: the ends hear two others, those between them all three.
    rows = [line.split() for line in lines if "believes" in line]
    assert [(row[1], row[3]) for row in rows] == [
        ("1", "2"), ("1", "3"), ("2", "1"), ("2", "3"), ("2", "4"), ("3", "1"), ("3", "2"), ("3", "4"),
        ("4", "2"), ("4", "3"),
    ]  # fmt: skip
    assert all(abs(float(row[8])) < 0.3 for row in rows)


def test_the_loop_says_what_is_wrong(tmp_path: Path) -> None:
    program = built(tmp_path / "loop", CPP / "loop.cpp")
    done = ran(program, tmp_path / "none", 4, 1)
    assert (done.returncode, done.stderr) == (
        1, f"cannot reach the server at {tmp_path / 'none'}: No such file or directory\n",
    )  # fmt: skip


def test_vehicles_of_veins_are_stations(socket: Path, tmp_path: Path) -> None:
    veins = CPP / "veins"
    program = built(
        tmp_path / "veins",
        veins / "ModelcastApp.cc",
        TRIED / "veins_run.cpp",
        include=(CPP, veins, TRIED / "stub"),
    )
    rows = [line.split() for line in output(program, socket, 12).splitlines()]
    assert [row[0] for row in rows] == ["11", "12", "13", "14"]
    sent, heard = [int(row[1]) for row in rows], [int(row[2]) for row in rows]
    assert heard == [sum(sent) - own for own in sent]
    assert min(sent) > 10
    assert [row[3] for row in rows] == ["3"] * 4
    assert max(float(row[4]) for row in rows) < 0.3
    assert {row[5] for row in rows} == {"100.0"}

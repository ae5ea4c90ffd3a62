"""ns-3 as the radio: what goes over the pipes, and, where ns-3 is installed, what it does with it."""

import gc
import os
import struct
import subprocess
import sys
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from modelcast.channel.dsrc_parameters import DsrcParameters
from modelcast.channel.radio import Receptions, Transmissions
from modelcast.core.exceptions import ModelcastError

STAND_IN = """
import struct, sys
stations, log = int(sys.argv[1]), open(sys.argv[2], "wb")
def take(size):
    octets = sys.stdin.buffer.read(size)
    log.write(octets); log.flush()
    return octets
while len(head := take(16)) == 16:
    until_s, count = struct.unpack("<dq", head)
    take(16 * stations)
    sent = [struct.unpack("<ddqii", take(32)) for _ in range(count)]
    pairs = [(one[2], one[0] + 0.001, -60.5, k, 0 if k else 3)
             for one in sent for k in range(stations) if k != one[3]]
    out = struct.pack("<qqq", len(pairs), count, 0)
    out += b"".join(struct.pack("<qddii", *one) for one in pairs)
    out += b"".join(struct.pack("<q", one[2]) for one in sent)
    sys.stdout.buffer.write(out + struct.pack(f"<{stations}d", *[0.25] * stations))
    sys.stdout.flush()
"""
"""Speaks as the program in C++ does: all hear all after 1 ms, but station 0 loses to a hidden sender."""

PLACES_M = np.array([[0.0, 1.5], [np.nan, np.nan], [40.0, 0.0]])


@pytest.fixture
def ns3_radio(installed: Callable[..., Path], monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """The example package."""
    monkeypatch.syspath_prepend(str(installed("ns3_radio")))
    import ns3_radio  # noqa: PLC0415 - installed for the test

    return ns3_radio


def batch(sender: list[int], ready_s: list[float], *, size: int = 300, power_dbm: float = 20.0) -> Any:
    number = len(sender)
    return Transmissions(
        np.array(sender, dtype=np.int64),
        np.array(ready_s, dtype=np.float64),
        size_bytes=np.full(number, size, dtype=np.int64),
        power_dbm=np.full(number, power_dbm),
        message_id=100 + np.arange(number, dtype=np.int64),
    )


def stand_in(ns3_radio: ModuleType, log: Path) -> Any:
    """The radio over a stand-in of the program."""

    class StandIn(ns3_radio.Ns3Radio):  # type: ignore[name-defined,misc]
        def start(self, stations: int, seed: int) -> Any:
            """Start the stand-in."""
            del seed
            command = [sys.executable, "-c", STAND_IN, str(stations), str(log)]
            return ns3_radio.radio.Ns3Simulator(command, Path(), stations)

    return StandIn()


def test_radios_of_other_packages_are_found_by_name(python_with: Callable[..., Any]) -> None:
    text = (
        "from importlib.metadata import entry_points as e; print(e(group='modelcast.radios')['ns3'].load())"
    )
    assert "ns3_radio.radio.Ns3Radio" in python_with(("ns3_radio",), "-c", text).stdout


def test_a_step_is_these_octets(ns3_radio: ModuleType, tmp_path: Path) -> None:
    radio = stand_in(ns3_radio, tmp_path / "log")
    state = radio.init(3, np.random.default_rng(0))
    heard, state = radio.step(state, batch([2, 0], [0.01, 0.02]), PLACES_M, 0.1)
    radio.step(state, batch([], []), PLACES_M, 0.2)
    expected = struct.pack("<dq", 0.1, 2) + PLACES_M.tobytes()
    expected += struct.pack("<ddqii", 0.01, 20.0, 100, 2, 300) + struct.pack(
        "<ddqii", 0.02, 20.0, 101, 0, 300
    )
    expected += struct.pack("<dq", 0.2, 0) + PLACES_M.tobytes()
    assert (tmp_path / "log").read_bytes() == expected
    assert heard.message_id.tolist() == [100, 101, 101]
    assert heard.sender.tolist() == [2, 0, 0]
    assert heard.receiver.tolist() == [1, 1, 2]
    assert heard.t_s.tolist() == [0.011, 0.021, 0.021]
    assert heard.rssi_dbm.tolist() == [-60.5] * 3
    assert heard.outcomes[0].tolist() == [1, 0, 0, 1, 0]
    assert radio.channel_busy_ratio(state).tolist() == [0.25] * 3


def test_a_run_that_is_over_leaves_no_process(ns3_radio: ModuleType, tmp_path: Path) -> None:
    radio = stand_in(ns3_radio, tmp_path / "log")
    state = radio.init(3, np.random.default_rng(0))
    process = state.course.simulator._process
    assert process.poll() is None
    del state
    gc.collect()
    assert process.poll() is not None


def test_a_process_that_ends_by_itself_is_told_with_its_words(ns3_radio: ModuleType) -> None:
    command = [sys.executable, "-c", "import sys; sys.stdin.buffer.read(16); sys.exit('no such channel')"]
    simulator = ns3_radio.radio.Ns3Simulator(command, Path(), 3)
    with pytest.raises(ModelcastError, match="ns-3 ended with 1: no such channel"):
        simulator.carry(batch([0], [0.01]), PLACES_M, 0.1)


def test_a_frame_smaller_than_its_headers_is_refused(ns3_radio: ModuleType, tmp_path: Path) -> None:
    radio = stand_in(ns3_radio, tmp_path / "log")
    state = radio.init(3, np.random.default_rng(0))
    with pytest.raises(ValueError, match="at least 36"):
        radio.step(state, batch([0], [0.01], size=35), PLACES_M, 0.1)


def test_an_error_model_that_ns3_has_not_is_refused(ns3_radio: ModuleType) -> None:
    with pytest.raises(ValueError, match="error_model must be one of nist, table, got 'yans'"):
        ns3_radio.Ns3Radio(error_model="yans").init(3, np.random.default_rng(0))


def test_a_folder_without_ns3_is_refused(ns3_radio: ModuleType, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"is not the folder of pip's ns3"):
        ns3_radio.Ns3Radio(folder=str(tmp_path)).init(2, np.random.default_rng(0))


def test_where_ns3_is_missing_it_says_so(ns3_radio: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("NS3_FOLDER", raising=False)
    if any((Path(path) / "ns3" / "lib64").is_dir() for path in sys.path):
        pytest.skip("ns3 is installed beside modelcast")
    with pytest.raises(ValueError, match="ns-3 is not installed: pip install ns3"):
        ns3_radio.Ns3Radio().init(2, np.random.default_rng(0))


@pytest.fixture
def over_ns3(ns3_radio: ModuleType) -> Callable[..., Any]:
    """Make the radio, over the ns-3 of the interpreter that MODELCAST_NS3_PYTHON names."""
    python = os.environ.get("MODELCAST_NS3_PYTHON")
    if not python:
        pytest.skip("MODELCAST_NS3_PYTHON names no interpreter with ns3 3.44")
    query = [python, "-c", "import sysconfig; print(sysconfig.get_paths()['purelib'])"]
    site = subprocess.run(query, capture_output=True, text=True, check=True).stdout.strip()  # noqa: S603
    return lambda **settings: ns3_radio.Ns3Radio(folder=str(Path(site) / "ns3"), **settings)


def line(*east_m: float) -> np.ndarray:
    return np.column_stack([np.array(east_m), np.zeros(len(east_m))])


def test_ns3_sends_a_lone_frame_after_aifs_for_as_long_as_it_lasts(over_ns3: Callable[..., Any]) -> None:
    """ns-3 3.44 waits for AIFS on an idle channel too; its frames are 4 us shorter than the standard's."""
    radio = over_ns3()
    state = radio.init(3, np.random.default_rng(1))
    heard, state = radio.step(state, batch([0], [0.01]), line(0.0, 20.0, np.nan), 0.1)
    assert heard.receiver.tolist() == [1]
    airtime_s = float(DsrcParameters().airtime_s(np.array([300]))[0]) - 4e-6
    assert heard.t_s[0] - 0.01 == pytest.approx(58e-6 + airtime_s, abs=2e-7)
    loss_db = 47.86 + 24.0 * np.log10(20.0)
    assert heard.rssi_dbm[0] == pytest.approx(20.0 - loss_db, abs=12.0)  # Nakagami, m = 3
    assert heard.outcomes.sum() == 1
    assert radio.channel_busy_ratio(state)[:2] == pytest.approx(airtime_s / 0.1, rel=1e-3)


def test_in_ns3_a_newer_message_takes_the_place_of_one_that_waits(over_ns3: Callable[..., Any]) -> None:
    radio = over_ns3()
    state = radio.init(2, np.random.default_rng(0))
    heard, _ = radio.step(state, batch([0, 1, 1], [0.01, 0.01005, 0.0101]), line(0.0, 30.0), 0.1)
    assert heard.expired.tolist() == [101]
    assert sorted(heard.message_id.tolist()) == [100, 102]


def test_in_ns3_who_is_absent_neither_sends_nor_hears(over_ns3: Callable[..., Any]) -> None:
    radio = over_ns3()
    state = radio.init(3, np.random.default_rng(0))
    heard, _ = radio.step(state, batch([0, 1], [0.01, 0.02]), line(0.0, np.nan, 20.0), 0.1)
    assert heard.receiver.tolist() == [2]
    assert heard.expired.tolist() == [101]


def crowd(radio: Any, pieces: int) -> list[Receptions]:
    """What 30 stations hear of 200 messages in 0.3 s, told in so many pieces."""
    rng = np.random.default_rng(8)
    ready_s, sender = np.sort(rng.uniform(0.0, 0.2, 200)), rng.integers(0, 30, 200)
    place_m = np.column_stack([rng.uniform(0.0, 400.0, 30), np.zeros(30)])
    state, found = radio.init(30, np.random.default_rng(2)), list[Receptions]()
    for k in range(pieces):
        low_s, high_s = 0.3 * k / pieces, 0.3 * (k + 1) / pieces
        inside = (ready_s >= low_s) & (ready_s < high_s)
        traffic = batch(sender[inside].tolist(), ready_s[inside].tolist())
        object.__setattr__(traffic, "message_id", np.flatnonzero(inside))
        heard, state = radio.step(state, traffic, place_m, high_s)
        found.append(heard)
    return found


def test_ns3_in_pieces_is_ns3_in_one(over_ns3: Callable[..., Any]) -> None:
    """Frames on the air at the end of an interval go on; one seed gives one result."""
    radio = over_ns3()
    (whole,), cut = crowd(radio, 1), crowd(radio, 60)
    assert whole.size > 2000
    for name in (one.name for one in fields(Receptions)):
        pieces = [getattr(one, name) for one in cut]
        together = np.sum(pieces, axis=0) if name == "outcomes" else np.concatenate(pieces)
        assert np.array_equal(getattr(whole, name), together), name

"""Claims about the C++ header before a server that lies: each answer ends in its error, never in a crash."""

import contextlib
import random
import socket
import threading
from collections.abc import Generator, Sequence
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest

pytest.importorskip("msgpack", reason="the extra `node` brings MessagePack")

import msgpack

from modelcast.node.serving.framing import framed
from modelcast.node.serving.schema import step_protocol

from .cpp_build import CPP, TRIED, built, needs_compiler, needs_sanitizers, output, ran

__all__ = ["needs_sanitizers"]

pytestmark = [*needs_compiler, pytest.mark.usefixtures("needs_sanitizers")]

WRONG = "the server's answer is wrong: "
ASKED = ("welcome", "sent", "beliefs", "warned")
"""The answers of a session of `cpp/answers.cpp`, in order."""

ONE = np.array([8])
VALUES: dict[str, dict[str, Any]] = {
    "welcome": {"protocol": step_protocol().protocol, "version": "1", "sender": "mbc"},
    "sent": {
        "t_s": 0.0,
        "octets": b"abcdef",
        "receipt": np.array([0]),
        "left": np.array([5]),
        **{name: np.array([1, 2]) for name in ("message", "frame_bytes", "priority", "grant", "kind")},
        **{name: np.array([0.01, 0.02]) for name in ("send_s", "power_dbm", "next_s")},
        "vehicle": np.array([3, 8]),
        "length": np.array([4, 2]),
    },
    "beliefs": {
        "t_s": 0.0,
        "host": ONE,
        "vehicle": np.array([3]),
        "kind": np.array([0]),
        "position_m": np.ones((1, 2)),
        "velocity_mps": np.ones((1, 2)),
        "covariance_m2": np.ones((1, 2, 2)),
        **{
            name: np.array([np.nan])
            for name in (
                *("speed_mps", "heading_rad", "acceleration_mps2", "yaw_rate_radps"),
                *("information_age_s", "received_s", "length_m", "width_m"),
            )
        },
    },
    "warned": {
        "t_s": 0.0,
        "host": ONE,
        "vehicle": np.array([3]),
        "application": np.array([1]),
        "level": np.array([1]),
        **{name: np.array([0.5]) for name in ("time_s", "margin_m", "certainty")},
    },
}


def packed(name: str) -> bytes:
    return step_protocol().pack(name, VALUES[name])


def map_of(values: dict[str, Any]) -> bytes:
    """A framed map of MessagePack."""
    return framed(cast("bytes", msgpack.packb(values)))


def changed(name: str, **values: Any) -> bytes:
    """An answer, framed, some of whose fields are others; None leaves one out."""
    found = {**cast("dict[str, Any]", msgpack.unpackb(packed(name))), **values}
    return map_of({key: value for key, value in found.items() if value is not None})


def doubles(*values: float) -> bytes:
    return np.array(values, "<f8").tobytes()


def numbers(*values: int) -> bytes:
    return np.array(values, "<u4").tobytes()


def asked(connection: socket.socket) -> bool:
    """Whether a whole request came."""
    head = connection.recv(4, socket.MSG_WAITALL)
    return len(head) == 4 and bool(connection.recv(int.from_bytes(head, "little"), socket.MSG_WAITALL))


@contextlib.contextmanager
def answering(path: Path, sessions: Sequence[Sequence[bytes]], *, closes: bool = True) -> Generator[None]:
    """A server that sends, session after session, these octets behind the requests."""

    def serve() -> None:
        for answers in sessions:
            connection, _ = listening.accept()
            with connection, contextlib.suppress(ConnectionError):
                for octets in answers:
                    if not asked(connection):
                        break
                    connection.sendall(octets)
                while not closes and connection.recv(4096):
                    pass

    with socket.socket(socket.AF_UNIX) as listening:
        listening.bind(str(path))
        listening.listen()
        thread = threading.Thread(target=serve, daemon=True)
        thread.start()
        yield
        thread.join(30.0)
        assert not thread.is_alive()


@pytest.fixture(name="program", scope="module")
def _program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return built(tmp_path_factory.mktemp("cpp") / "answers", TRIED / "answers.cpp")


@pytest.fixture(name="loop", scope="module")
def _loop(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return built(tmp_path_factory.mktemp("cpp") / "loop", CPP / "loop.cpp")


def told(program: Path, path: Path, sessions: Sequence[Sequence[bytes]], *, silence_s: int = 0) -> list[str]:
    """What the client says to each session."""
    with answering(path, sessions, closes=not silence_s):
        return output(program, path, len(sessions), silence_s).splitlines()


def with_answer(name: str, octets: bytes) -> list[bytes]:
    """A session that is well up to one answer."""
    return [*(framed(packed(one)) for one in ASKED[: ASKED.index(name)]), octets]


CASES = {
    "another type": (framed(packed("warned")).replace(b"warned", b"welcom"), "type is not warned"),
    "the answer to another request": (framed(packed("beliefs")), "type is not warned"),
    "no map": (framed(b"\x93abc"), "message is no map of MessagePack"),
    "empty": (framed(b""), "message is cut off"),
    "a nest": (framed(b"\x81\xa1a" + b"\x91" * 100_000), "a is of a type that this protocol has not"),
    "no text before a value": (framed(b"\x81\x01\x01"), "message has a field without a name"),
    "a name that no field has": (framed(b"\x81\xa2\x1b[\x01"), "message has a field without a name"),
    "a field twice": (framed(b"\x82\xa1a\x01\xa1a\x01"), "a comes twice"),
    "octets behind": (framed(packed("warned") + b"\x00"), "message goes on after its map"),
    "longer than a frame may be": (b"\x01\x00\x00\x02", "message has 33554433 octets"),
    "a binary longer than all": (framed(b"\x81\xa1a\xc6\xff\xff\xff\xff"), "a is cut off"),
    "no level": (changed("warned", level=None), "level is missing"),
    "a text for a number": (changed("warned", t_s="soon"), "t_s is of another type"),
    "a number for a binary": (changed("warned", host=3), "host is of another type"),
    "a part of a number": (changed("warned", vehicle=b"\x01\x00\x00"), "vehicle ends within a row"),
    "fewer rows": (changed("warned", margin_m=b""), "margin_m has not as many rows as host"),
    "more rows": (changed("warned", certainty=doubles(1.0, 1.0)), "certainty has not as many rows as host"),
    "a host that was not asked for": (changed("warned", host=numbers(7)), "host 7 was not in the request"),
    "an application that was not asked for": (
        changed("warned", application=b"\x02"), "application is none that was asked for",
    ),
}  # fmt: skip


def test_an_honest_server_is_believed(program: Path, tmp_path: Path) -> None:
    assert told(program, tmp_path / "s", [[framed(packed(name)) for name in ASKED]] * 2) == ["well"] * 2


def test_what_is_wrong_with_an_answer_is_told_and_ends_the_session(program: Path, tmp_path: Path) -> None:
    sessions = [with_answer("warned", octets) for octets, _ in CASES.values()]
    lines = told(program, tmp_path / "s", sessions)
    assert dict(zip(CASES, lines, strict=True)) == {name: WRONG + why for name, (_, why) in CASES.items()}


@pytest.mark.parametrize(
    ("name", "values", "why"),
    [
        ("sent", {"vehicle": numbers(3, 9)}, "vehicle 9 was not in the request"),
        ("sent", {"vehicle": numbers(3)}, "vehicle has not as many rows as message"),
        ("sent", {"length": numbers(4, 3)}, "length does not add up to the octets"),
        ("sent", {"length": numbers(2**32 - 1, 7)}, "length does not add up to the octets"),
        ("sent", {"receipt": b""}, "receipt is not one for each reception"),
        ("beliefs", {"position_m": doubles(1.0)}, "position_m ends within a row"),
        ("beliefs", {"covariance_m2": doubles(*range(8))}, "covariance_m2 has not as many rows as host"),
        ("beliefs", {"host": numbers(1)}, "host 1 was not in the request"),
    ],
)
def test_numbers_of_rows_and_stations_are_looked_at(
    name: str, values: dict[str, bytes], why: str, program: Path, tmp_path: Path
) -> None:
    session = with_answer(name, changed(name, **values))
    assert told(program, tmp_path / "s", [session]) == [WRONG + why]


def test_another_version_is_no_session(program: Path, tmp_path: Path) -> None:
    lines = told(program, tmp_path / "s", [[changed("welcome", protocol=2)]])
    assert lines == [f"begin: {WRONG}protocol is another version"]


def test_a_server_that_is_silent_or_goes_is_given_up(program: Path, tmp_path: Path) -> None:
    welcome, sent = framed(packed("welcome")), framed(packed("sent"))
    silent = [[welcome], [welcome, sent[:3]], [welcome, sent[:50]]]
    assert told(program, tmp_path / "s", silent, silence_s=1) == ["the server is silent"] * 3
    assert told(program, tmp_path / "t", silent) == ["the server ended the session"] * 3


def test_an_error_is_refused_and_ends_the_session_where_it_says_so(program: Path, tmp_path: Path) -> None:
    error = {"type": "error", "field": "t_s", "value": "0", "expected": "later", "text": "no"}
    sessions = [[framed(packed("welcome")), map_of({**error, "ends": ends})] for ends in (0, 1)]
    assert told(program, tmp_path / "s", sessions) == [WRONG + "ends is of another type"] * 2
    for one, ends in zip(sessions, (False, True), strict=True):
        one[1] = map_of({**error, "ends": ends})
    assert told(program, tmp_path / "t", sessions) == ["refused: t_s, ends 0", "refused: t_s, ends 1"]


def test_answers_cut_off_and_garbled_never_crash_it(program: Path, tmp_path: Path) -> None:
    chance, sessions = random.Random(17), list[list[bytes]]()  # noqa: S311 - no secret
    for name in ASKED:
        whole = packed(name)
        sessions += [with_answer(name, framed(whole[:at])) for at in range(len(whole))]
        for _ in range(300):
            octets = bytearray(whole)
            for _ in range(chance.randint(1, 3)):
                octets[chance.randrange(len(octets))] = chance.choice((0x00, 0x7F, 0xC6, 0xDB, 0xDE, 0xFF))
            sessions.append(with_answer(name, framed(bytes(octets))))
    lines = told(program, tmp_path / "s", sessions)
    assert len(lines) == len(sessions)
    # Octets of a number may be any; whatever else is changed is told.
    assert {line.removeprefix("begin: ").split(": ")[0] for line in lines} <= {
        *("the server's answer is wrong", "well", "the server ended the session"),
    }
    assert sum("wrong" in line for line in lines) > len(sessions) // 2


@pytest.mark.parametrize(
    ("values", "why"),
    [
        ({"vehicle": numbers(7)}, "vehicle is none of the loop's"),
        ({"position_m": b""}, "position_m has not as many rows as host"),
    ],
)
def test_the_loop_ends_with_what_is_wrong(
    values: dict[str, bytes], why: str, loop: Path, tmp_path: Path
) -> None:
    path = tmp_path / "s"
    quiet = {name: b"" for name, value in VALUES["sent"].items() if not isinstance(value, float)}
    session = [
        framed(packed("welcome")), changed("sent", **quiet), changed("beliefs", host=numbers(1), **values),
    ]  # fmt: skip
    with answering(path, [session]):
        done = ran(loop, path, 2, 0.1)
    assert (done.returncode, done.stderr) == (1, f"{WRONG}{why}\n")

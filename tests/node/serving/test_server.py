"""Claims about the server: over a socket it is the session, and no client hurts another."""

import os
import signal
import socket
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from modelcast.cli.app import run
from modelcast.cli.signals import INTERRUPTED
from modelcast.node.serving.client import StepClient
from modelcast.node.serving.framing import framed
from modelcast.node.serving.schema import named_values, step_protocol
from modelcast.runtime.external.exchange import SessionSettings, Step
from modelcast.runtime.external.refusal import FieldError
from modelcast.runtime.external.session import Session

from ...convoy import Convoy  # noqa: TID252 - tests are no package
from .conftest import Served

SETTINGS = SessionSettings(4, capacity=50, seed=3)
SPOKEN = step_protocol()


def same(one: object, other: object) -> None:
    for name, value in named_values(one).items():
        np.testing.assert_array_equal(value, getattr(other, name), err_msg=name)


def connected(path: str) -> socket.socket:
    own = socket.socket(socket.AF_UNIX)
    own.settimeout(30.0)
    own.connect(path)
    return own


def answers(own: socket.socket) -> list[tuple[str, dict[str, Any]]]:
    """All that the server says until it hangs up."""
    found = b""
    while True:
        try:
            came = own.recv(2**16)
        except ConnectionError:
            break
        if not came:
            break
        found += came
    told: list[tuple[str, dict[str, Any]]] = []
    while found:
        length = int.from_bytes(found[:4], "little")
        told.append(SPOKEN.unpack(found[4 : 4 + length], "server"))
        found = found[4 + length :]
    return told


def test_over_a_socket_it_is_the_session(served: Served) -> None:
    near, far = Convoy(4), Convoy(4)
    session = Session(SETTINGS)
    with StepClient(SETTINGS, path=served.path) as client:
        for number in range(40):
            here, there = session.step(near.step(number)), client.step(far.step(number))
            same(here, there)
            assert here.frames() == there.frames()
            near.carry(here)
            far.carry(there)
            same(session.believe(near.vehicle, 0.1 * number), client.believe(far.vehicle, 0.1 * number))
            asked = ["fcw", "ima"]
            same(session.warnings(near.vehicle, asked), client.warnings(far.vehicle, asked))


def test_what_is_refused_is_told_and_the_session_goes_on(served: Served) -> None:
    convoy, twin = Convoy(4), Convoy(4)
    session = Session(SETTINGS)
    with StepClient(SETTINGS, path=served.path) as client:
        same(session.step(twin.step(0)), client.step(convoy.step(0)))
        with pytest.raises(
            FieldError, match=r"t_s must be more than the last, 0\.0, and at most .*, got -0\.1"
        ):
            client.step(Step(-0.1, convoy.vehicle, position_m=convoy.position_m))
        with pytest.raises(FieldError, match="host must be a station of the newest step, got 99"):
            client.believe(np.array([99]), 0.0)
        with pytest.raises(FieldError, match="application must be"):
            client.warnings(convoy.vehicle, ["nothing"])
        same(session.step(twin.step(1)), client.step(convoy.step(1)))
    with pytest.raises(FieldError, match="sender must be"):
        StepClient(SessionSettings(1, sender="none"), path=served.path)


def test_sessions_do_not_meet(served: Served) -> None:
    """Two clients in turns, over one server, as each alone."""
    convoys = [Convoy(4, seed=seed) for seed in (1, 2)]
    twins = [Convoy(4, seed=seed) for seed in (1, 2)]
    alone = [Session(SETTINGS), Session(SETTINGS)]
    with StepClient(SETTINGS, path=served.path) as one, StepClient(SETTINGS, path=served.path) as other:
        for number in range(15):
            for client, convoy, session, twin in zip((one, other), convoys, alone, twins, strict=True):
                sent, wanted = client.step(convoy.step(number)), session.step(twin.step(number))
                same(wanted, sent)
                convoy.carry(sent)
                twin.carry(wanted)


def test_a_client_that_is_killed_frees_everything(served: Served) -> None:
    words = (
        "import os, sys, numpy as np; from modelcast.node.serving.client import StepClient;"
        "from modelcast.runtime.external.exchange import *;"
        "client = StepClient(SessionSettings(4), path=sys.argv[1]);"
        "client.step(Step(0.0, np.arange(4), position_m=np.zeros((4, 2)))); os.kill(os.getpid(), 9)"
    )
    for _ in range(2):
        ended = subprocess.run([sys.executable, "-c", words, served.path], check=False)  # noqa: S603 - our own
        assert ended.returncode == -signal.SIGKILL
    served.wait_until(lambda: served.server.sessions == 0)
    with StepClient(SETTINGS, path=served.path):
        assert served.ask(lambda: served.server.sessions) == 1


def test_there_is_room_for_so_many(served: Served) -> None:
    clients = [StepClient(SETTINGS, path=served.path) for _ in range(4)]
    with pytest.raises(ConnectionAbortedError, match="session must be one of 4 at a time, got 5"):
        StepClient(SETTINGS, path=served.path)
    for one in clients:
        one.close()
    served.wait_until(lambda: served.server.sessions == 0)
    StepClient(SETTINGS, path=served.path).close()


@pytest.mark.parametrize(
    ("octets", "text"),
    [
        ((2**32 - 1).to_bytes(4, "little"), "frame must be a shorter one, got a frame of 4294967295 octets"),
        (bytes(4), "frame must be a shorter one, got a frame of 0 octets"),
        (b"POST / HTTP/1.1\r\n\r\n", "frame must be a shorter one, got a frame of"),
        (framed(b"\xc1"), "frame must be a map of MessagePack"),
        (
            framed(b"\x93\x01\x02\x03"),
            "frame must be a map of MessagePack, got no map of MessagePack, but a list",
        ),
        (framed(b"\xdf\xff\xff\xff\xff"), "frame must be a map of MessagePack"),
        (framed(b"\x81" * 3000), "frame must be a map of MessagePack"),
        (framed(b"\x82\xa1a\x01\xa1a\x02"), "keys are texts, each once"),
    ],
)
def test_what_is_no_frame_ends_the_session(octets: bytes, text: str, served: Served) -> None:
    with connected(served.path) as own:
        own.sendall(octets)
        ((name, told),) = answers(own)
    assert name == "error"
    assert told["ends"]
    assert text in told["text"]


def hello(**changed: Any) -> dict[str, Any]:
    return {"protocol": 1, "slots": 2, **changed}


@pytest.mark.parametrize(
    ("name", "values", "text"),
    [
        ("hello", hello(protocol=2), "protocol must be 1, the only one spoken here, got 2"),
        ("hello", hello(slots=0), "slots must be from 1 to 10000, got 0"),
        ("hello", hello(slots="many"), "slots must be a field of type integer, got 'many'"),
        ("hello", hello(slots=True), "slots must be a field of type integer, got True"),
        ("hello", hello(dt_s=float("nan")), "dt_s must be from 0.001 to 10, got nan"),
        ("hello", {"protocol": 1}, "slots must be there: hello needs it, integer, got nothing"),
        ("step", {"t_s": 0.0, "vehicle": np.arange(2), "position_m": np.zeros((2, 2))}, "type must be hello"),
    ],
)
def test_a_field_that_is_wrong_is_named(name: str, values: dict[str, Any], text: str, served: Served) -> None:
    with connected(served.path) as own:
        own.sendall(framed(SPOKEN.pack(name, values)))
        own.shutdown(socket.SHUT_WR)
        ((kind, told),) = answers(own)
    assert kind == "error"
    assert not told["ends"]
    assert told["text"].startswith(text)


@pytest.mark.slow
@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    noise=st.one_of(
        st.binary(max_size=400),
        st.lists(st.binary(max_size=60).map(framed), max_size=5).map(b"".join),
        st.tuples(st.integers(0, 2**32 - 1), st.binary(max_size=60)).map(
            lambda pair: pair[0].to_bytes(4, "little") + pair[1]
        ),
    ),
    begun=st.booleans(),
    cut=st.integers(0, 400),
)
def test_random_octets_hurt_no_other_session(noise: bytes, begun: bool, cut: int, served: Served) -> None:
    convoy = Convoy(2)
    with StepClient(SETTINGS, path=served.path) as client:
        first = client.step(convoy.step(0))
        with connected(served.path) as own:
            if begun:
                own.sendall(framed(SPOKEN.pack("hello", hello())))
                step = framed(SPOKEN.pack("step", named_values(Convoy(2).step(0))))
                own.sendall(step[:cut] if cut < len(step) else step)
            try:
                own.sendall(noise)
                own.shutdown(socket.SHUT_WR)
            except OSError:
                pass  # it has hung up already
            assert all(kind in {"welcome", "sent", "error"} for kind, _ in answers(own))
        convoy.carry(first)
        assert client.step(convoy.step(1)).t_s == 0.1
    assert served.told == []


def test_the_socket_is_of_its_user_alone(served: Served) -> None:
    assert Path(served.path).stat().st_mode & 0o777 == 0o600


@pytest.mark.parametrize(
    "words",
    ["", "--socket a --port 1", "--port 70000", "--port 0 --sessions 0", "--port 0 --profile none.json"],
)
def test_bad_options_are_told(words: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["serve", *words.split()]) == 2
    assert capsys.readouterr().err


@pytest.mark.parametrize("how", [pytest.param("once", marks=pytest.mark.slow), "interrupt"])
def test_the_command_serves_and_ends_cleanly(how: str, tmp_path: Path) -> None:
    words = [sys.executable, "-m", "modelcast", "serve", "--port", "0", "--profile", "default"]
    words += ["--once"] if how == "once" else []
    buffered = {name: held for name, held in os.environ.items() if name != "PYTHONUNBUFFERED"}
    with subprocess.Popen(  # noqa: S603 - our own interpreter
        words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=tmp_path, env=buffered
    ) as server:
        assert server.stdout is not None
        assert server.stderr is not None
        place = server.stdout.readline().split()[-1]
        assert place.startswith("127.0.0.1:")
        client = StepClient(
            SessionSettings(2, people_slots=1), port=int(place.split(":")[1]), timeout_s=120.0
        )
        assert client.step(Step(0.0, np.array([1]), position_m=np.zeros((1, 2)))).vehicle.tolist() == [1]
        if how == "once":
            client.close()
        else:
            server.send_signal(signal.SIGINT)
        ended = (0, "") if how == "once" else (INTERRUPTED, "modelcast: interrupted\n")
        assert (server.wait(60.0), server.stderr.read()) == ended
        client.close()

"""Claims about ``modelcast prepare``: what it made ready is all that a node runs."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from modelcast.cli.app import run
from modelcast.core.kernel_cache import CACHE_VARIABLE
from modelcast.io.write_trips import write_csv
from modelcast.node.inputs.replay import TripReplay
from modelcast.world.drive import generate_drive

ROOT = Path(__file__).parents[2]

NODES = """
import asyncio, io, json, sys
from tests.node.virtual_time import LoopClock, run_in_virtual_time
from modelcast.cli.node import sender_of_config
from modelcast.cli.prepare import rehearsed
from modelcast.core.kernel import kernels
from modelcast.node.clock import SteeredClock
from modelcast.node.config import Air, NodeConfig, Page, Pseudonyms, Sending
from modelcast.node.demo import demo_trips
from modelcast.node.inputs.replay import TripReplay
from modelcast.node.journal import Journal
from modelcast.node.live import LiveNode

class Clock(SteeredClock):
    def __init__(self):
        super().__init__(1_764_000_000.0)
    def now_s(self):
        return self.at(asyncio.get_running_loop().time())

def ready():
    return {one.label for one in kernels() if one.is_ready}

policy, port = sys.argv[1], int(sys.argv[2])
config = NodeConfig(
    sending=Sending(policy=policy),
    air=Air(group="239.255.16.81", port=port, loss_ratio=0.2),
    page=Page(on=True, port=0),
    pseudonyms=Pseudonyms(least_s=5.0, most_s=6.0),
)
met = rehearsed(config, sender_of_config(config))
before = ready()

async def main():
    stop, clock = asyncio.Event(), Clock()
    nodes = [
        LiveNode(
            config, sender_of_config(config), Journal(io.StringIO(), lambda: 0.0),
            clock=clock, gnss=TripReplay(trip, with_bus=name != "leader"),
        )
        for name, trip in demo_trips().items()
    ]
    asyncio.get_running_loop().call_later(30.0, stop.set)
    await asyncio.gather(*(node.run(stop) for node in nodes))
    return [node.node.counts["receipt: accepted"] for node in nodes]

heard = run_in_virtual_time(main())
more = sorted(ready() - before)
print(json.dumps({"told": met.ready, "before": len(before), "heard": min(heard), "more": more}))
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("policy", "port"),
    [
        pytest.param("mbc", 16821, marks=pytest.mark.slow),
        pytest.param("bsm-10hz", 16822, marks=pytest.mark.slow),
        ("j2945-free", 16823),
    ],
)
def test_what_a_rehearsal_makes_ready_is_all_that_nodes_run(policy: str, port: int) -> None:
    found = subprocess.run(  # noqa: S603 - our own interpreter and text
        [sys.executable, "-c", NODES, policy, str(port)],
        cwd=ROOT, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert found.returncode == 0, found.stderr
    told = json.loads(found.stdout)
    assert told["more"] == []
    assert told["told"] == told["before"] > 20
    assert told["heard"] > 5


def test_it_says_how_many_and_where(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert run(["prepare"]) == 0
    first, second = capsys.readouterr().out.splitlines()
    assert "kernels are ready" in first
    assert second.startswith("kept in ")
    path = tmp_path / "node.toml"
    path.write_text("[sending]\npolcy = 1\n", encoding="utf-8")
    assert run(["prepare", str(path)]) == 2
    assert "polcy" in capsys.readouterr().err


def modelcast(words: list[str], **variables: str) -> "subprocess.CompletedProcess[str]":
    return subprocess.run(  # noqa: S603 - our own interpreter
        [sys.executable, "-m", "modelcast", *words],
        env={**os.environ, **variables}, capture_output=True, text=True, check=False,
    )  # fmt: skip


def test_where_nothing_is_compiled_there_is_nothing_to_prepare() -> None:
    found = modelcast(["prepare"], NUMBA_DISABLE_JIT="1")
    assert found.returncode == 2
    assert "NUMBA_DISABLE_JIT" in found.stderr


@pytest.mark.slow
def test_a_cold_node_says_so_and_a_prepared_one_does_not(tmp_path: Path) -> None:
    """Twice a minute or so of compiling; the second in a place where nothing can be kept."""
    write_csv([TripReplay(generate_drive(3, 90.0).truth).trip], tmp_path / "drive.csv")
    node = ["node", "--gnss", f"trip:{tmp_path / 'drive.csv'}", "--duration", "1"]
    folder = {CACHE_VARIABLE: str(tmp_path / "cache")}
    made = modelcast(["prepare"], **folder)
    assert made.returncode == 0
    assert "functions compiled" in made.stdout
    assert str(tmp_path / "cache") in made.stdout
    assert "none had to be compiled" in modelcast(["prepare"], **folder).stdout
    started = [json.loads(line) for line in modelcast(node, **folder).stderr.splitlines()]
    assert [line["event"] for line in started[:2]] == ["ready", "start"]
    assert started[0]["compiled"] == 0

    (tmp_path / "file").write_text("")
    nowhere = {CACHE_VARIABLE: str(tmp_path / "file" / "cache")}
    cold = modelcast(node, **nowhere)
    lines = [json.loads(line) for line in cold.stderr.splitlines() if line.startswith("{")]
    assert [line["event"] for line in lines[:3]] == ["compiling", "ready", "start"]
    assert lines[0]["remedy"].startswith("run modelcast prepare")
    assert lines[1]["not_kept"] == lines[1]["kernels"]
    refused = modelcast(["prepare"], **nowhere)
    assert refused.returncode == 2
    assert "cannot be kept" in refused.stderr

"""What the step protocol costs beside the stations: 1,000 vehicles a step through a real socket.

Vehicles drive on a road of 5 km, six lanes each way, send models and hear all within 300 m. Server and client
share this process; the client only waits. Of each step, the processor time of the whole process from the
request to its answer, and of it what is spent inside `Fleet.sense` and `Fleet.hear_each`, which a program of
Python would spend as well. The aim for the rest is 10 ms. All of one run, medians of the steps after the
first second. ``serve_step.py [--vehicles 1000] [--steps 40]``
"""

import argparse
import asyncio
import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from measured import record
from modelcast.node.serving.client import StepClient
from modelcast.node.serving.server import StepServer
from modelcast.runtime.external.exchange import Sent, SessionSettings, Step
from modelcast.runtime.external.senders import sender_of
from modelcast.station.fleet import Fleet

ROAD_M, LANES, LANE_M, REACH_M = 5000.0, 12, 3.5, 300.0
STEP_S, WARM_STEPS, AIM_S = 0.1, 10, 0.010


class Clock:
    """Time spent in some functions since it was read."""

    def __init__(self) -> None:
        self.spent_s = 0.0

    def timed(self, what: Callable[..., Any]) -> Callable[..., Any]:
        """The same function, its time counted."""

        def counted(*words: Any, **named: Any) -> Any:
            begun_s = time.process_time()
            try:
                return what(*words, **named)
            finally:
                self.spent_s += time.process_time() - begun_s

        return counted

    def read(self) -> float:
        """The time since the last reading [s]."""
        spent_s, self.spent_s = self.spent_s, 0.0
        return spent_s


class Served:
    """A server in a thread."""

    def __init__(self, path: str) -> None:
        self._path, self._ready = path, threading.Event()
        self._thread = threading.Thread(target=lambda: asyncio.run(self._run()))
        self._thread.start()
        self._ready.wait()

    async def _run(self) -> None:
        self._loop, self._stop = asyncio.get_running_loop(), asyncio.Event()
        server = StepServer(sender_of, most=1, tell=print)
        listening = await server.listen(path=self._path, port=0)
        self._ready.set()
        await self._stop.wait()
        listening.close()
        await server.close()

    def stop(self) -> None:
        """Stop it, and wait until it has."""
        self._loop.call_soon_threadsafe(self._stop.set)
        self._thread.join()


class Road:
    """Vehicles on straight lanes that speed up and slow down, and a radio that carries so far."""

    def __init__(self, vehicles: int) -> None:
        rng = np.random.default_rng(1)
        self.vehicle = np.arange(vehicles)
        lane = self.vehicle % LANES
        self.east_m = rng.uniform(0.0, ROAD_M, vehicles)
        self.north_m = LANE_M * lane
        self.way = np.where(lane < LANES // 2, 1.0, -1.0)
        self.phase = rng.uniform(0.0, 2.0 * np.pi, vehicles)
        self.heard: dict[str, Any] = {}

    def step(self, number: int) -> Step:
        """Where they are."""
        phase = 0.5 * STEP_S * number + self.phase
        speed_mps = 25.0 + 3.0 * np.sin(phase)
        if number:
            self.east_m = self.east_m + self.way * STEP_S * speed_mps
        return Step(
            STEP_S * number,
            self.vehicle,
            position_m=np.stack([self.east_m, self.north_m], axis=1),
            speed_mps=speed_mps,
            heading_rad=np.where(self.way > 0, np.pi / 2, 3.0 * np.pi / 2),
            acceleration_mps2=1.5 * np.cos(phase),
            yaw_rate_radps=np.zeros(self.vehicle.size),
            **self.heard,
        )

    def carry(self, sent: Sent) -> int:
        """Who hears what; returns how many receptions there are."""
        away_m = np.abs(self.east_m[sent.vehicle][:, None] - self.east_m[None, :])
        away_m[np.arange(sent.vehicle.size), sent.vehicle] = np.inf
        row, host = np.nonzero(away_m < REACH_M)
        self.heard = {"receiver": host, "received_s": sent.send_s[row], "message": sent.message[row]}
        return int(host.size)


def main() -> int:
    """Measure and print; 1 where the aim is missed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--vehicles", type=int, default=1000)
    parser.add_argument("--steps", type=int, default=40)
    given = parser.parse_args()
    clock = Clock()
    Fleet.sense, Fleet.hear_each = clock.timed(Fleet.sense), clock.timed(Fleet.hear_each)  # type: ignore[method-assign]
    road, rows = Road(given.vehicles), list[tuple[float, float, int, int]]()
    with tempfile.TemporaryDirectory() as folder:
        path = str(Path(folder) / "s")
        served = Served(path)
        with StepClient(SessionSettings(given.vehicles, dt_s=STEP_S, spread_s=1.0), path=path) as client:
            for number in range(given.steps):
                step = road.step(number)
                clock.read()
                begun_s = time.process_time()
                sent = client.step(step)
                rows.append(
                    (time.process_time() - begun_s, clock.read(), sent.message.size, step.receiver.size)
                )
                road.carry(sent)
        served.stop()
    waited_s, own_s, messages, receptions = np.array(rows[WARM_STEPS:]).T
    beside_s = waited_s - own_s
    middle = float(np.median(beside_s))
    stations = "its stations", 1e3 * float(np.median(own_s))
    sizes = {"vehicles": given.vehicles}
    record("step protocol beside its stations", 1e3 * middle, "ms a step", peer=stations, sizes=sizes)
    print(
        f"{given.vehicles} vehicles, {messages.mean():.0f} messages and {receptions.mean():.0f} receptions a "
        f"step: {1e3 * np.median(waited_s):.1f} ms, {1e3 * np.median(own_s):.1f} ms of it "
        f"for its stations and {1e3 * middle:.1f} ms beside them (most {1e3 * beside_s.max():.1f} ms), "
        f"{middle / np.median(own_s):.1%}"
    )
    return int(middle > AIM_S)


if __name__ == "__main__":
    raise SystemExit(main())

"""Nodes as processes, and what is seen of one from outside: map, figures, journal, memory."""

import asyncio
import contextlib
import json
import re
import signal
import sys
import time
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

__all__ = ["Memory", "NodeProcess", "NodeView"]

CLOCK = Path(__file__).with_name("soak_clock.py")
_SAMPLE = re.compile(r"(\w+)(?:\{\w+=\"(.*)\"\})? (\S+)")
_LINE_OCTETS = 2**25
_RETRY_S = 0.1
_WAIT_S = 10.0


@dataclass(frozen=True, slots=True)
class Memory:
    """Resident memory of a process now, and the most it ever had [MB]."""

    now_mb: float
    peak_mb: float


@dataclass(frozen=True, slots=True)
class NodeView:
    """A line of a node's map, as any other program gets it, and when it came [s]."""

    arrived_utc_s: float
    document: Mapping[str, Any]


class NodeProcess:
    """``modelcast node`` run on a configuration.

    Parameters
    ----------
    name
        Of the vehicle.
    config
        The TOML file.
    socket_path
        Where its map is served, as the file says.
    metrics_port
        Where its figures are, as the file says.
    take
        Takes every line of its map.
    """

    def __init__(
        self,
        name: str,
        config: Path,
        *,
        socket_path: Path,
        metrics_port: int,
        take: Callable[[str, NodeView], None],
    ) -> None:
        self.name, self._config, self._socket, self._port = name, config, socket_path, metrics_port
        self._take = take
        self._process: asyncio.subprocess.Process | None = None
        self._tasks: list[asyncio.Task[None]] = []
        self._meant_to_end = False
        self.events: list[tuple[float, Mapping[str, Any]]] = []
        """Lines of the journal and when they came."""
        self.noise: list[str] = []
        """Lines that are none: an error that was not met."""
        self.crashes = 0
        """How often it ended without being asked to."""

    async def start(self, *, told_clock: bool = False) -> None:
        """Start it; its map is listened to from when it is there.

        Parameters
        ----------
        told_clock
            Give it a clock that `tell_clock` moves.
        """
        words = (str(CLOCK),) if told_clock else ("-m", "modelcast", "node")
        self._meant_to_end = False
        self._process = await asyncio.create_subprocess_exec(
            sys.executable, *words, str(self._config),
            stdin=asyncio.subprocess.PIPE if told_clock else asyncio.subprocess.DEVNULL,
            stdout=asyncio.subprocess.DEVNULL, stderr=asyncio.subprocess.PIPE, limit=_LINE_OCTETS,
        )  # fmt: skip
        self._tasks = [
            asyncio.create_task(one) for one in (self._hear_journal(), self._hear_map(), self._guard())
        ]

    def tell_clock(self, offset_s: float) -> None:
        """Set its clock to the machine's plus an offset [s]."""
        assert self._process is not None
        assert self._process.stdin is not None
        self._process.stdin.write(f"{offset_s}\n".encode())

    async def stop(self) -> float:
        """Ask it to end by SIGTERM; returns how long that took [s]."""
        return await self._ended(signal.SIGTERM)

    async def kill(self) -> None:
        """End it by SIGKILL."""
        await self._ended(signal.SIGKILL)

    def pause(self) -> None:
        """Give it no time at all."""
        assert self._process is not None
        self._process.send_signal(signal.SIGSTOP)

    def resume(self) -> None:
        """Let it go on."""
        assert self._process is not None
        self._process.send_signal(signal.SIGCONT)

    async def _ended(self, how: signal.Signals) -> float:
        process, begin_s = self._process, time.monotonic()
        self._meant_to_end = True
        if process is not None and process.returncode is None:
            process.send_signal(how)
            try:
                async with asyncio.timeout(_WAIT_S):
                    await process.wait()
            except TimeoutError:
                process.kill()
                await process.wait()
        took_s = time.monotonic() - begin_s
        if process is not None and how is signal.SIGTERM and process.returncode != 0:
            self.crashes += 1
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        self._process = None
        return took_s

    async def figures(self) -> Mapping[tuple[str, str], float]:
        """Its figures by name and label; none where it does not answer."""
        with contextlib.suppress(OSError, TimeoutError):
            async with asyncio.timeout(_WAIT_S):
                reader, writer = await asyncio.open_connection("127.0.0.1", self._port)
                writer.write(b"GET /metrics HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
                text = (await reader.read()).decode().partition("\r\n\r\n")[2]
                writer.close()
            samples = [_SAMPLE.fullmatch(line) for line in text.splitlines() if not line.startswith("#")]
            return {(one[1], one[2] or ""): float(one[3]) for one in samples if one is not None}
        return {}

    async def counts(self) -> Counter[str]:
        """What it refused by reason, and the steps it left out."""
        found: Counter[str] = Counter()
        for (name, label), value in (await self.figures()).items():
            if name in {"modelcast_refused_total", "modelcast_receipt_total"} and label != "accepted":
                found[label] += int(value)
            if name == "modelcast_skipped_steps_total":
                found["steps left out"] += int(value)
        return found

    def memory(self) -> Memory | None:
        """Its memory; None where it does not run, or the machine does not say."""
        if self._process is None:
            return None
        try:
            text = Path(f"/proc/{self._process.pid}/status").read_text(encoding="ascii")
        except OSError:
            return None
        found = dict(re.findall(r"(VmRSS|VmHWM):\s+(\d+) kB", text))
        if len(found) < 2:
            return None
        return Memory(int(found["VmRSS"]) / 1024.0, int(found["VmHWM"]) / 1024.0)

    async def _guard(self) -> None:
        assert self._process is not None
        await self._process.wait()
        if not self._meant_to_end:
            self.crashes += 1

    async def _hear_journal(self) -> None:
        assert self._process is not None
        assert self._process.stderr is not None
        while line := await self._process.stderr.readline():
            try:
                self.events.append((time.time(), json.loads(line)))
            except ValueError:
                self.noise.append(line.decode(errors="replace").rstrip())

    async def _hear_map(self) -> None:
        while True:
            try:
                reader, writer = await asyncio.open_unix_connection(str(self._socket), limit=_LINE_OCTETS)
            except OSError:
                await asyncio.sleep(_RETRY_S)
                continue
            with contextlib.suppress(OSError):
                while line := await reader.readline():
                    self._take(self.name, NodeView(time.time(), json.loads(line)))
            writer.close()

"""What nodes do when things go wrong: ``make soak``, ten minutes; returns 1 where a stated bound is broken.

Four nodes run as processes of their own, each with a gpsd that plays a drive, one with a bus too. They hear
each other through a relay that carries frames as badly as it is told. One fault after another is done to
them. What their maps say, as any other program gets it, is held against where the vehicles truly are. Two
more nodes, which nothing is done to, run beside all the time: their memory and lateness are those of a quiet
road. An empty event loop runs beside as well: what it is late by is the machine's.

Everything is on the loopback interface; the machine's clock and disk are not touched. Needs Linux.
"""

import argparse
import asyncio
import math
import os
import signal
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from modelcast.node.demo import DEMO_S
from page_blocks import put
from soak_faults import FAULTS, SHORT, Fault, Seen
from soak_octets import altered_octets
from soak_record import Stretch
from soak_stand import Stand

__all__ = ["main"]

PAGE = Path(__file__).parents[1] / "docs" / "node.md"
BLOCK = "soak"
LOOP = Path(__file__).with_name("soak_loop.py")

MOST_MB = 450.0
"""Resident memory that no node may exceed."""

MOST_SLOPE_MB_PER_H = 12.0
"""Of a node on a quiet road, over at least eight minutes: two of a thousand pages an hour, and noise."""

ENDS_S = 5.0
"""Longest until a process is gone after SIGTERM; what it does within 1 s is a fault of its own."""

_SLOPE_FROM_S, _SLOPE_LEAST_S = 60.0, 400.0
_LOOKS_ON_S = 10.0
"""So long is looked on at least, where a fault allows for more."""

_QUIET = ("leader", "second")
_SETTLES_S = 120.0
_MOST_REASONS = 3


@dataclass(slots=True)
class Outcome:
    """What came of a fault."""

    fault: Fault
    stretch: Stretch
    recovery_s: float
    counts: Counter[str]
    peak_mb: float
    crashes: int
    seen: Seen
    broken: list[str] = field(default_factory=list)


def judged(outcome: Outcome) -> list[str]:
    """Bounds that were broken, in words."""
    bounds, stretch = outcome.fault.bounds, outcome.stretch
    checks = [
        ("tracked", -stretch.tracked_ratio, -bounds.tracked_ratio),
        ("p95 error, m", stretch.error_p95_m, bounds.error_p95_m),
        ("recovery, s", outcome.recovery_s, bounds.recovery_s),
        ("memory, MB", outcome.peak_mb, MOST_MB),
        ("strangers", stretch.strangers, bounds.strangers),
        ("crashes", outcome.crashes, 0),
        *((name, outcome.seen.get(name, math.inf), most) for name, most in bounds.seen.items()),
    ]
    return [
        f"{outcome.fault.name}: {name} {abs(value):.2f}, bound {abs(most):.2f}"
        for name, value, most in checks
        if not (value <= most or (math.isnan(value) and most == math.inf))
    ]


async def one_fault(stand: Stand, fault: Fault) -> Outcome:
    """Do a fault, and look at what it does."""
    before, crashes_before, pairs = (
        await stand.counts(),
        stand.crashes,
        stand.pairs(fault.hosts, fault.remotes),
    )
    begin_s = time.time()
    async with fault.during(stand) as seen:
        await asyncio.sleep(fault.lasts_s)
        end_s = time.time()
    counts = await stand.counts()
    await asyncio.sleep(min(fault.after_s, _LOOKS_ON_S))
    left_s = end_s + fault.after_s - time.time()
    await stand.until(
        lambda: stand.maps.recovery_s(end_s, time.time(), pairs) < math.inf, at_most_s=left_s, each_s=1.0
    )
    stretch = stand.maps.stretch(begin_s + 0.2, end_s, pairs)
    recovery_s = stand.maps.recovery_s(end_s, time.time(), pairs)
    peak_mb = max(
        (now for rows in stand.memory.values() for at_s, now, _ in rows if at_s >= begin_s), default=math.nan
    )
    outcome = Outcome(
        fault, stretch, recovery_s, counts - before, peak_mb, stand.crashes - crashes_before, dict(seen)
    )
    outcome.broken = judged(outcome)
    return outcome


def row(outcome: Outcome) -> str:
    """Of the table."""
    reasons = outcome.counts.copy()
    left_out = reasons.pop("steps left out", 0)
    refused = ", ".join(f"{many} {why}" for why, many in reasons.most_common(_MOST_REASONS))
    seen = "; ".join(_words(name, value) for name, value in outcome.seen.items())
    name = outcome.fault.name + (f" ({seen})" if seen else "")
    strangers = outcome.stretch.strangers
    return (
        f"| {name} | {100 * outcome.stretch.tracked_ratio:.1f} % | {outcome.stretch.error_p95_m:.2f} m | "
        f"{outcome.recovery_s:.1f} s | {refused or 'none'} | {strangers or ''} | {left_out} | "
        f"{outcome.peak_mb:.0f} MB |"
    )


def _words(name: str, value: float) -> str:
    """A figure whose name ends with its unit."""
    text, _, unit = name.partition(", ")
    return f"{text} {value:.1f} {unit}" if unit else f"{text} {value:.0f}"


COLUMNS = (
    "what goes wrong",
    "tracked meanwhile",
    "p95 error",
    "right again after",
    "refused, most frequent",
    "strangers",
    "steps left out",
    "memory",
)
HEAD = (f"| {' | '.join(COLUMNS)} |", "|" + len(COLUMNS) * "---|")


def slope_mb_per_h(rows: Sequence[tuple[float, float, float]]) -> float:
    """Growth of a node's resident memory after its first minute; not a number where that is too short."""
    table = np.array(rows).reshape(-1, 3)
    table = table[table[:, 0] >= table[0, 0] + _SLOPE_FROM_S] if table.size else table
    if not table.size or table[-1, 0] - table[0, 0] < _SLOPE_LEAST_S:
        return math.nan
    return float(np.polyfit(table[:, 0] - table[0, 0], table[:, 1], 1)[0] * 3600.0)


class Soak:
    """A run, and what it has to say."""

    def __init__(
        self, *, short: bool, lasts_s: float, seed: int, only: Sequence[str], quiet: bool = False
    ) -> None:
        self._short, self._lasts_s, self._seed, self._only = short, lasts_s, seed, only
        self._nothing_happens = quiet
        self.lines: list[str] = []
        self.broken: list[str] = []

    async def run(self, folder: Path) -> None:
        """Do everything; SIGTERM and Ctrl-C end the nodes too."""
        rng = np.random.default_rng(self._seed)
        drives_s = max(DEMO_S, self._lasts_s + 120.0)
        stand = Stand(folder / "faults", lasts_s=drives_s, rng=rng)
        quiet = Stand(folder / "quiet", lasts_s=drives_s, rng=rng, names=_QUIET, relayed=False)
        loop = await asyncio.create_subprocess_exec(sys.executable, str(LOOP), stdout=asyncio.subprocess.PIPE)
        this = asyncio.current_task()
        assert this is not None
        asyncio.get_running_loop().add_signal_handler(signal.SIGTERM, this.cancel)
        try:
            await self._all(stand, quiet)
            await self._last_words(stand, quiet, loop)
        finally:
            for node in (*stand.nodes.values(), *quiet.nodes.values()):
                await node.kill()  # those that have not ended
            if loop.returncode is None:
                loop.kill()
                await loop.wait()

    async def _all(self, stand: Stand, quiet: Stand) -> None:
        """Every fault that was asked for, or none at all."""
        begin_s = time.time()
        if not self._short:
            await quiet.start()
        if self._nothing_happens:
            await asyncio.sleep(self._lasts_s)
            return
        await stand.start()
        self._say(*HEAD)
        settled_s = await stand.until(lambda: _settled(stand), at_most_s=_SETTLES_S)
        if settled_s == math.inf:
            self.broken.append(f"the nodes did not hear each other within {_SETTLES_S:g} s")
        for fault in FAULTS:
            if self._short and fault.name not in SHORT:
                continue
            if self._only and not any(one in fault.name for one in self._only):
                continue
            if fault.skip:
                self._say(f"| {fault.name} | skipped: {fault.skip} | | | | | | |")
                continue
            outcome = await one_fault(stand, fault)
            self.broken += outcome.broken
            self._say(row(outcome))
        await self._octets(stand)
        await asyncio.sleep(0.0 if self._short else max(begin_s + self._lasts_s - time.time(), 0.0))

    def _say(self, *lines: str) -> None:
        self.lines += lines
        for line in lines:
            print(line, flush=True)

    async def _octets(self, stand: Stand) -> None:
        """Every octet of real frames, in this process."""
        by_length = {len(octets): (sent_s, octets) for sent_s, octets in stand.frames}
        longest = sorted(by_length.items())[-(1 if self._short else 3) :]
        origin = stand.origin("leader")
        if not longest or origin is None:
            self.broken.append("no frame was heard whose octets could be altered")
            return
        found = await asyncio.to_thread(altered_octets, [frame for _, frame in longest], origin)
        reasons = Counter({why: many for why, many in found.items() if why not in {"frames", "altered"}})
        words = ", ".join(f"{many} {why}" for why, many in reasons.most_common(6))
        self._say(
            "",
            f"Every octet of {found['frames']} frames altered to each of 255 other values, "
            f"{found['altered']} frames: {words}. None raised an error.",
        )

    async def _last_words(self, stand: Stand, quiet: Stand, loop: asyncio.subprocess.Process) -> None:
        """Memory, lateness, and the end of all nodes."""
        beside = stand if self._short else quiet
        figures = [await node.figures() for node in beside.nodes.values()]
        loop.terminate()
        text, _ = await loop.communicate()
        late = [
            1e3 * max(one.get(("modelcast_lateness_seconds", share), math.nan) for one in figures)
            for share in ("0.5", "0.99")
        ]
        idle = [float(word) for word in text.split()]
        slopes = [slope_mb_per_h(rows) for rows in beside.memory.values()]
        took_s = [s for one in (stand, quiet) if one.nodes for s in await one.stop()]
        who = "nodes" if self._short else "nodes that nothing was done to"
        self._say(
            "",
            f"Steps of the {who} began {late[0]:.1f} ms late at the median and {late[1]:.1f} ms at p99; "
            f"an empty loop beside them {idle[0]:.1f} and {idle[1]:.1f} ms.",
        )
        if math.isnan(max(slopes)):
            self._say("Memory over time: skipped, the run is too short for a slope.")
        else:
            self._say(f"Their memory grew by {max(slopes):.1f} MB/h.")
            if max(slopes) > MOST_SLOPE_MB_PER_H:
                self.broken.append(f"memory grew by {max(slopes):.1f} MB/h, bound {MOST_SLOPE_MB_PER_H:g}")
        self._say(
            f"All ended within {max(took_s):.2f} s of SIGTERM. Crashes: {stand.crashes + quiet.crashes}."
        )
        if max(took_s) > ENDS_S:
            self.broken.append(f"a node took {max(took_s):.2f} s to end, bound {ENDS_S:g}")
        if quiet.crashes or stand.crashes:
            told = [line for node in (*stand.nodes.values(), *quiet.nodes.values()) for line in node.noise]
            self.broken.append("crashes; what they said: " + " / ".join(told[-10:]))


def _settled(stand: Stand) -> bool:
    """Whether every node tracks every other, and has for a while."""
    now_s = time.time()
    return stand.maps.recovery_s(now_s - 3.0, now_s, stand.pairs()) == 0.0


def main(arguments: list[str] | None = None) -> int:
    """Run, print, and write where asked."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    kind = parser.add_mutually_exclusive_group()
    kind.add_argument("--short", action="store_true", help="six of the faults, two to three minutes")
    kind.add_argument("--quiet", action="store_true", help="no faults: memory and lateness alone")
    parser.add_argument("--minutes", type=float, default=10.0, help="least time of the whole run")
    parser.add_argument("--only", nargs="+", default=[], help="faults whose names hold one of these words")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--write", action="store_true", help="put the table into docs/node.md")
    parser.add_argument("--check", action="store_true", help="run nothing; 1 where the page lacks a fault")
    asked = parser.parse_args(arguments)
    if asked.check:
        text = PAGE.read_text(encoding="utf-8")
        return int(any(f"| {fault.name}" not in text for fault in FAULTS))
    if sys.platform != "linux":
        print("skipped: what a process weighs is read as Linux tells it")
        return 0
    soak = Soak(
        short=asked.short, lasts_s=60.0 * asked.minutes, seed=asked.seed, only=asked.only, quiet=asked.quiet
    )
    with tempfile.TemporaryDirectory(prefix="soak-") as folder:
        try:
            asyncio.run(soak.run(Path(folder)))
        except asyncio.CancelledError:
            print("ended by SIGTERM")
            return 1
    for line in soak.broken:
        print(f"BROKEN {line}")
    if asked.write:
        cores = os.cpu_count() or 0
        load = os.getloadavg()[2]
        told = (
            f"By `make soak` on {time.strftime('%Y-%m-%d')}, {cores} cores, mean load {load:.1f} at its end:"
        )
        if asked.quiet:
            told = f"{told[:-1]}, {asked.minutes:g} minutes in which nothing was done to two nodes:"
        broken = ["", "Bounds that were broken: " + "; ".join(soak.broken) + "."] if soak.broken else []
        put(
            {PAGE: {f"{BLOCK} quiet" if asked.quiet else BLOCK: [told, "", *soak.lines, *broken]}},
            check=False,
        )
    return int(bool(soak.broken))


if __name__ == "__main__":
    sys.exit(main())

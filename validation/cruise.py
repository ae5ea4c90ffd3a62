"""What messages and models are worth to platoons that drive by them: the tables of ``docs/cruise.md``.

``cruise.py`` drives 8 platoons of 8 vehicles by the PATH law for each sender and loss: behind a sinusoid,
with independent losses and in bursts, with and without a ranging sensor; behind a hard stop; and behind
recorded leaders, the first vehicle of every file of `LEADERS` below ``MODELCAST_DATA``. The published
scenario of arXiv 2303.08076 is judged by them without loss. ``--write`` puts the tables into the page,
``--check`` tells by its exit code whether the page has them. Ten minutes on a core.
"""

import argparse
import os
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import groupby, pairwise
from pathlib import Path

import numpy as np

from modelcast.apps.cruise.acc import Acc
from modelcast.apps.cruise.base import AbstractCruiseLaw
from modelcast.apps.cruise.path import PathCacc
from modelcast.apps.cruise.ploeg import Ploeg
from modelcast.io.trips import read_trips
from modelcast.report.cruise import sender_label
from modelcast.runtime.platoon.drive import DriveSettings
from modelcast.study.cruise.run import PERFECT, REFERENCE, run_cruise
from modelcast.study.cruise.settings import CruiseSettings, Loss
from modelcast.study.table import Row
from modelcast.world.platoon.leaders import Braking, RecordedSpeed, recorded_leader
from page_blocks import put

PAGE = Path(__file__).parents[1] / "docs" / "cruise.md"
LEADERS = ("openacc_zalazone/*.csv", "roads/tampa_dev.parquet")
LONGEST_S = 120.0
PUBLISHED_FEWER, PUBLISHED_CHANGE = 0.47, 0.01
LAG_S = 0.5

LOSSES = tuple(Loss(ratio) for ratio in (0.0, 0.2, 0.4, 0.6, 0.8, 0.9))
SENDERS = ("bsm-10hz", "bsm-5hz", "bsm-2hz", "baseline", "free", "mbc", "j2945", "j2945-mbc")
SINUSOID = CruiseSettings(senders=SENDERS, thresholds_m=(0.02, 0.2), losses=LOSSES)
FEW = (Loss(0.0), Loss(0.4), Loss(0.8))
BRAKING = replace(SINUSOID, leader=Braking(), losses=FEW, drive=DriveSettings(duration_s=30.0))
BLIND = replace(SINUSOID, losses=FEW, drive=DriveSettings(ranging=False))
BURSTS = replace(SINUSOID, losses=tuple(Loss(ratio, 1.0) for ratio in (0.2, 0.4, 0.8)))


@dataclass(frozen=True)
class Law:
    """A law under theory, and how it is called."""

    label: str
    law: AbstractCruiseLaw


LAWS = (
    Law("PATH, 0.2 rad/s", PathCacc()),
    Law("PATH, 0.2 Hz taken at its word", PathCacc(bandwidth_radps=0.4 * np.pi)),
    Law("Ploeg, headway 0.5 s", Ploeg()),
    Law("Ploeg, headway 1.2 s", Ploeg(headway_s=1.2)),
    Law("ACC, headway 0.3 s", Acc(headway_s=0.3)),
    Law("ACC, headway 1.2 s", Acc()),
)


def theory() -> Iterator[str]:
    """Greatest growth of spacing error and speed from follower to follower, over all frequencies."""
    s = 1j * np.linspace(0.01, 20.0, 4000)
    yield "| law | spacing error | speed |"
    yield "|---|--:|--:|"
    for one in LAWS:
        headway_s = float(np.diff(one.law.gap_m(np.array([0.0, 1.0])))[0])
        places = [np.ones_like(s)]
        for _ in range(7):
            places.append(one.law.response(s, places[-1], places[0], LAG_S))
        errors = [np.abs(own - ahead + headway_s * s * own) for ahead, own in pairwise(places)]
        growth = max(float(np.max(own / ahead)) for ahead, own in pairwise(errors))
        speed = max(float(np.max(np.abs(own / ahead))) for ahead, own in pairwise(places))
        yield f"| {one.label} | {growth:.2f} | {speed:.2f} |"


def _cell(row: Row) -> str:

    gap = f"{row.gap_min_m:.1f} m" if not row.collisions else f"{row.collisions} collide"
    return f"{row.spacing_amplification:.2f}, {gap}"


def _percent(row: Row) -> str:
    return f"{100 * row.loss_ratio:g} % lost"


def by_loss(rows: Sequence[Row]) -> Iterator[str]:
    """One line a sender: messages a second at the least loss, then growth and least gap by loss."""
    sent = [row for row in rows if row.sender != PERFECT]
    heads = list(dict.fromkeys(_percent(row) for row in sent))
    yield f"| sender | messages/s | {' | '.join(heads)} |"
    yield "|---|--:|" + "---|" * len(heads)
    for row in rows:
        if row.sender == PERFECT:
            yield f"| perfect knowledge | - | {_cell(row)} |" + " |" * (len(heads) - 1)
    for label, group in groupby(sent, key=sender_label):
        each = list(group)
        rates = f"{each[0].rate_hz:.2f}"
        if len({f"{row.rate_hz:.1f}" for row in each}) > 1:
            rates = f"{min(row.rate_hz for row in each):.2f} to {max(row.rate_hz for row in each):.2f}"
        yield f"| {label} | {rates} | {' | '.join(_cell(row) for row in each)} |"


def comfort(rows: Sequence[Row]) -> Iterator[str]:
    """Comfort and airtime at no loss and at 40 %."""
    yield "| sender | lost | rms acceleration | rms jerk | rms spacing error | airtime a vehicle |"
    yield "|---|--:|--:|--:|--:|--:|"
    for row in rows:
        if row.loss_ratio not in {0.0, 0.4}:
            continue

        airtime = "-" if row.sender == PERFECT else f"{1e3 * row.airtime_per_s:.2f} ms/s"
        name = "perfect knowledge" if row.sender == PERFECT else sender_label(row)
        yield (
            f"| {name} | {100 * row.loss_ratio:g} % | {row.acceleration_rms_mps2:.2f} m/s² | "
            f"{row.jerk_rms_mps3:.2f} m/s³ | {row.spacing_rms_m:.2f} m | {airtime} |"
        )


def leaders(data: Path) -> Iterator[RecordedSpeed]:
    """The first vehicle of each file."""
    for pattern in LEADERS:
        for path in sorted(data.glob(pattern)):
            yield recorded_leader(next(iter(read_trips(path))))


def recorded(data: Path) -> dict[str, list[Row]]:
    """Rows behind each recorded leader."""
    few = ("bsm-10hz", "bsm-5hz", "bsm-2hz", "baseline", "free", "mbc")
    found: dict[str, list[Row]] = {}
    for leader in leaders(data):
        drive = DriveSettings(duration_s=min(LONGEST_S, np.floor(leader.lasts_s)))
        losses = (Loss(0.0), Loss(0.4))
        study = replace(SINUSOID, senders=few, losses=losses, leader=leader, drive=drive)
        found[leader.name] = list(run_cruise(study).rows)
    return found


def over_leaders(found: dict[str, list[Row]], loss_ratio: float) -> Iterator[str]:
    """Means over the recorded leaders, and their worst."""
    yield (
        "| sender | messages/s | fewer | speed change | worst leader's | growth | stable | least gap |"
        " collisions |"
    )
    yield "|---|" + "--:|" * 8
    pooled: dict[str, list[Row]] = {}
    for rows in found.values():
        for row in rows:
            if row.loss_ratio == loss_ratio and row.sender != PERFECT:
                pooled.setdefault(sender_label(row), []).append(row)
    for label, rows in pooled.items():
        changes = [row.speed_change_ratio for row in rows]
        yield (
            f"| {label} | {np.mean([row.rate_hz for row in rows]):.2f} | "
            f"{100 * np.mean([row.fewer_messages_ratio for row in rows]):.1f} % | "
            f"{100 * np.mean(changes):.2f} % | {100 * max(changes):.2f} % | "
            f"{np.mean([row.spacing_amplification for row in rows]):.2f} | "
            f"{100 * np.mean([row.stable_ratio for row in rows]):.0f} % | "
            f"{min(row.gap_min_m for row in rows):.2f} m | "
            f"{sum(row.collisions for row in rows)}/{sum(row.followers for row in rows)} |"
        )


def published(sinusoid: Sequence[Row], found: dict[str, list[Row]]) -> Iterator[str]:
    """Senders without loss against 47 % and 1 %: behind the sinusoid and the recorded leaders."""
    yield "| sender | fewer | speed change | met | fewer, recorded | speed change, mean | met by leaders |"
    yield "|---|--:|--:|---|--:|--:|--:|"
    for row in _plain(sinusoid):
        label = sender_label(row)
        others = [other for rows in found.values() for other in _plain(rows) if sender_label(other) == label]
        recorded_cells = "- | - | -"
        if others:
            fewer = np.mean([other.fewer_messages_ratio for other in others])
            change = np.mean([other.speed_change_ratio for other in others])
            met = sum(_met(other) for other in others)
            recorded_cells = f"{100 * fewer:.1f} % | {100 * change:.2f} % | {met} of {len(others)}"
        yield (
            f"| {label} | {100 * row.fewer_messages_ratio:.1f} % | {100 * row.speed_change_ratio:.2f} % | "
            f"{'yes' if _met(row) else 'no'} | {recorded_cells} |"
        )


def _plain(rows: Sequence[Row]) -> list[Row]:
    """Those without loss, but for the reference's."""
    return [row for row in rows if row.loss_ratio == 0.0 and row.sender not in {PERFECT, REFERENCE}]


def _met(row: Row) -> bool:
    return row.fewer_messages_ratio >= PUBLISHED_FEWER and row.speed_change_ratio < PUBLISHED_CHANGE


def main() -> int:
    """Make the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    which = parser.add_mutually_exclusive_group()
    which.add_argument("--write", action="store_true", help="put the tables into the page")
    which.add_argument("--check", action="store_true", help="exit with 1 where the page has others")
    chosen = parser.parse_args()
    named = os.environ.get("MODELCAST_DATA")
    if not named:
        parser.error("name the folder of recorded trips in MODELCAST_DATA")
    sinusoid = run_cruise(SINUSOID).rows
    found = recorded(Path(named))
    blocks = {
        "theory": list(theory()),
        "sinusoid": list(by_loss(sinusoid)),
        "comfort": list(comfort(sinusoid)),
        "bursts": list(by_loss(run_cruise(BURSTS).rows)),
        "radio-only": list(by_loss(run_cruise(BLIND).rows)),
        "braking": list(by_loss(run_cruise(BRAKING).rows)),
        "leaders": [f"{len(found)} leaders: {', '.join(f'`{name}`' for name in found)}."],
        "recorded": list(over_leaders(found, 0.0)),
        "recorded-lost": list(over_leaders(found, 0.4)),
        "published": list(published(sinusoid, found)),
    }
    if chosen.write or chosen.check:
        return put({PAGE: blocks}, check=chosen.check)
    for name, lines in blocks.items():
        sys.stdout.write("\n".join([f"## {name}", *lines, "", ""]))
    return 0


if __name__ == "__main__":
    sys.exit(main())

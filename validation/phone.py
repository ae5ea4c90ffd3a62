"""The tables of docs/people-cost.md: what a person's device sends, receives and computes in an hour.

``phone.py FOLDER [--times] [--write | --check]``: a folder that holds the output of the call in ``vru.py``.
Messages are what the runs counted, times 3,600; means over seeds. With ``--times`` processor times are
measured here, on one thread, the shortest of the rounds: a step of a walking station, a message heard, a
signature made and checked; else their table is left as it is. ``--write`` puts the tables into the page,
``--check`` tells by its exit code whether the page has them; times are never checked.
"""

import argparse
import json
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from modelcast.core.kinds import Kind
from modelcast.messages.security.p256 import PrivateKey, PublicKey
from modelcast.models.profile import default_profile, people_profile
from modelcast.station.fleet import Fleet
from modelcast.station.receiver.ears import Ears
from modelcast.station.sender.names import MODEL_SENDERS
from modelcast.station.sender.sender import Sender, named_sender
from modelcast.station.station import Station
from page_blocks import put

PAGE = Path(__file__).parents[1] / "docs" / "people-cost.md"
VEHICLES = Ears((default_profile().bank,))
"""A person's device understands what vehicles send."""

HOUR_S, STEP_S, ROUNDS = 3600.0, 0.1, 60
WALK_MPS, DRIVE_MPS, REMOTES, STEPS = 1.34, 10.0, 40, 100
MESSAGE_HEADS = (
    "people send by", "sent/h", "on the air, ms/h", "received/h", "of people, unread/h", "too far, unread/h",
    "read/h",
)  # fmt: skip
TIME_HEADS = ("people send by", "own steps [s/h]", "hearing [s/h]", "signing [s/h]", "checking [s/h]", "sum")


def _means(rows: Sequence[Mapping[str, Any]]) -> dict[str, dict[str, float]]:
    """Figures of a device by policy, means over seeds."""
    found: dict[str, dict[str, float]] = {}
    for policy in dict.fromkeys(row["people_policy"] for row in rows):
        own = [row for row in rows if row["people_policy"] == policy]
        names = [name for name in own[0] if name.endswith(("_hz", "_ratio"))]
        found[policy] = {name: float(np.mean([row[name] for row in own])) for name in names}
    return found


def _table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    lines = [f"| {' | '.join(cells)} |" for cells in (heads, *rows)]
    return [lines[0], "|" + "---|" * len(heads), *lines[1:]]


def message_table(means: Mapping[str, Mapping[str, float]]) -> list[str]:
    """A row a policy: messages an hour."""
    cells = [
        (
            policy,
            f"{HOUR_S * one['message_rate_hz']:,.0f}",
            f"{1e3 * HOUR_S * one['airtime_ratio']:,.0f}",
            *(
                f"{HOUR_S * one[f'{name}_rate_hz']:,.0f}"
                for name in ("received", "unread", "far", "read")
            ),
        )
        for policy, one in means.items()
    ]  # fmt: skip
    return _table(MESSAGE_HEADS, cells)


def _least_s(run: Callable[[], object], calls: int) -> float:
    """Shortest processor time of one call over the rounds [s]; each run makes all calls of a round."""
    run()
    found: list[float] = []
    for _ in range(ROUNDS):
        begin = time.process_time()
        run()
        found.append((time.process_time() - begin) / calls)
    return min(found)


def _person(policy: str) -> Sender:
    """What a person sends by: models by the shipped profile of people."""
    bank = people_profile().bank if policy in MODEL_SENDERS else None
    return named_sender(policy, bank=bank).of_kind(Kind.PEDESTRIAN)


def _step_s(policy: str) -> float:
    """Processor time of a step of somebody who walks and hears nobody [s]."""

    def walk() -> None:
        station = Station(_person(policy), temporary_id=1)
        for step in range(STEPS):
            t_s = STEP_S * step
            station.sense(t_s, (WALK_MPS * t_s, 0.1 * np.sin(t_s)), speed_mps=WALK_MPS, heading_rad=np.pi / 2)

    return _least_s(walk, STEPS)


def _hear_s(policy: str) -> float:
    """Processor time of a message heard, as they come from vehicles around, step by step [s]."""
    fleet, name = Fleet(named_sender(policy), slots=REMOTES), np.arange(1, REMOTES + 1)
    steps: list[tuple[list[bytes], list[float]]] = []
    for step in range(STEPS):
        t_s = STEP_S * step
        place_m = np.column_stack([DRIVE_MPS * t_s + 3.0 * name, 3.5 * (name % 4)])
        columns = {
            "speed_mps": np.full(REMOTES, DRIVE_MPS),
            "heading_rad": np.full(REMOTES, np.pi / 2),
            "acceleration_mps2": np.zeros(REMOTES),
            "yaw_rate_radps": np.zeros(REMOTES),
        }
        sent = fleet.sense(t_s, name, place_m, **columns)
        steps.append(([one.octets for one in sent], [t_s + STEP_S] * len(sent)))

    def hear() -> None:
        station = Station(_person(policy), temporary_id=999, ears=VEHICLES)
        for octets, received_s in steps:
            station.hear(octets, received_s=received_s)

    return _least_s(hear, sum(len(octets) for octets, _ in steps))


def time_table(means: Mapping[str, Mapping[str, float]]) -> list[str]:
    """A row a policy: processor time an hour, measured here."""
    key, data = PrivateKey(3), bytes(64)
    public, signature = PublicKey(key.public_octets), key.sign(data)
    sign_s = _least_s(lambda: [key.sign(data) for _ in range(STEPS)], STEPS)
    check_s = _least_s(lambda: [public.verifies(data, signature) for _ in range(STEPS)], STEPS)
    cells: list[Sequence[str]] = []
    for policy, one in means.items():
        parts = (
            HOUR_S / STEP_S * _step_s(policy),
            HOUR_S * one["read_rate_hz"] * _hear_s(policy),
            HOUR_S * one["message_rate_hz"] * sign_s,
            HOUR_S * one["read_rate_hz"] * check_s,
        )
        cells.append((policy, *(f"{part:.1f}" for part in parts), f"{sum(parts):.0f}"))
    return _table(TIME_HEADS, cells)


def main() -> int:
    """Print the tables, and write or check them where asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--times", action="store_true")
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--check", action="store_true")
    given = parser.parse_args()
    document = json.loads((given.folder / "summary.json").read_text(encoding="utf-8"))
    means = _means(document["people"])
    blocks = {"phone-messages": message_table(means)}
    if given.times and not given.check:
        blocks["phone-times"] = time_table(means)
    for name, lines in blocks.items():
        print(f"{name}\n", *lines, sep="\n")
    if given.write or given.check:
        return put({PAGE: blocks}, check=given.check)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())

"""Is what is evaluated, what is simulated and what drives the same? Every trip, bank and rule, byte for byte.

Drives each trip by the trip runtime, by a fleet of one on an ideal channel and by a lone `Station`, and lets
a host hear it over a lossy channel (`modelcast.study.agreement`); where the recording states the whole motion
also by a node that another node hears (`modelcast.node.agreement`). Prints a row a trip, a table of banks and
rules, and every difference by its first byte; ends with 1 where there is one.
"""

import argparse
import multiprocessing
import os
import sys
from collections import Counter
from pathlib import Path

from modelcast.core.exceptions import ModelcastError
from modelcast.io.trips import read_trips
from modelcast.node.agreement import node_agreement, states_its_motion
from modelcast.station.banks import named_bank
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.study.agreement import agreement
from modelcast.study.case import make_case
from modelcast.study.settings import EvaluationSettings
from modelcast.trips.trajectory import Trajectory
from trip_sources import folders

BANKS = ("default", "paper", "ctra", "gp-intercept+cv", "shs", "hdp-hmm+ctra+shs+cv", "imm", "learned+imm+cv")
RULES = ("guarded/never", "hindsight/cheapest", "order/on-failure", "keep/on-failure", "survivor/on-failure")
THRESHOLD_M = 0.3

Outcome = tuple[str, str, str, int, str]
"""Trip, bank, rules, messages, and what differs: empty for nothing."""


def compared(trip: Trajectory) -> list[Outcome]:
    """Every bank and rule over one trip."""
    settings = EvaluationSettings()
    case = make_case(trip, settings)
    found: list[Outcome] = []
    for bank_name in BANKS:
        named = named_bank(bank_name)
        for rule in RULES:
            start, identify = rule.split("/")
            try:
                costs = named.costs("bytes") if identify == "cheapest" else None
                policy = ErrorDriven(THRESHOLD_M, start, identify, costs=costs)  # type: ignore[arg-type]
                one = agreement(case, named.bank, policy)
                node = node_agreement(case, named.bank, policy) if states_its_motion(case) else None
            except ValueError as error:
                found.append((trip.trip_id, bank_name, rule, 0, f"refused: {error}"))
                continue
            parts = (
                ("fleet", one.fleet),
                ("station", one.station),
                ("host", one.host),
                ("motion", one.motion),
                ("node", "" if node is None else node.sent),
                ("node's host", "" if node is None else node.host),
            )
            off = "; ".join(f"{name}: {text}" for name, text in parts if text)
            found.append((trip.trip_id, bank_name, rule, one.messages, off))
    return found


def chosen(data: Path, most: int) -> list[Trajectory]:
    """Up to so many trips of each source, spread evenly over it; 0 for all."""
    trips: list[Trajectory] = []
    for path in folders(data):
        try:
            own = list(read_trips(path))
        except ModelcastError as error:
            print(f"{path.name}: {error}", file=sys.stderr)
            continue
        step = max(1, len(own) // most) if most else 1
        trips += own[::step][: most or None]
    return trips


def main() -> int:
    """Compare, and print what was found."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--most", type=int, default=0, help="trips of each source; 0 for all")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    given = parser.parse_args()
    trips = chosen(Path(os.environ["MODELCAST_DATA"]), given.most)
    agreed: Counter[tuple[str, str]] = Counter()
    refused: dict[tuple[str, str], str] = {}
    messages, differences = 0, 0
    with multiprocessing.get_context("spawn").Pool(given.jobs) as pool:
        for number, outcomes in enumerate(pool.imap(compared, trips), start=1):
            sent = sum(one[3] for one in outcomes)
            off = [one for one in outcomes if one[4] and not one[4].startswith("refused")]
            print(
                f"{number}/{len(trips)} {outcomes[0][0]}: {sent} messages, {len(off)} differences", flush=True
            )
            for trip, bank, rule, count, text in outcomes:
                if text.startswith("refused"):
                    refused[bank, rule] = text
                elif text:
                    differences += 1
                    print(f"  {trip}, {bank}, {rule}: {text}", flush=True)
                else:
                    agreed[bank, rule] += 1
                    messages += count
    print(f"\n{'bank':18s}" + "".join(f"{rule:>22s}" for rule in RULES))
    for bank in BANKS:
        cells = [
            "refused" if (bank, rule) in refused else f"{agreed[bank, rule]}/{len(trips)}" for rule in RULES
        ]
        print(f"{bank:18s}" + "".join(f"{cell:>22s}" for cell in cells))
    for key, text in refused.items():
        print(f"{'/'.join(key)}: {text}")
    by_node = sum(states_its_motion(make_case(trip, EvaluationSettings())) for trip in trips)
    print(f"by a node too: {by_node} of {len(trips)} trips")
    print(f"{messages} messages equal byte for byte in all runtimes, {differences} differences")
    return 1 if differences else 0


if __name__ == "__main__":
    sys.exit(main())

"""Which tests take the time: the heaviest files and tests of a run that pytest wrote with ``--junitxml``.

``make test`` writes ``out/test-times.xml``, and CI prints the heaviest at its end, so that it is seen where a
test grows to what belongs in ``make verify``. ``--limit`` fails by one: of use on an idle machine alone.
"""

import argparse
import sys
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from xml.etree import ElementTree as ET

__all__ = ["main", "read_times", "times_by_file"]


def read_times(path: Path) -> dict[str, float]:
    """Seconds of each test, set-up and tear-down too, by its module and name.

    Parameters
    ----------
    path
        What ``pytest --junitxml`` wrote.
    """
    cases = ET.parse(path).iter("testcase")  # noqa: S314 - our own pytest wrote it
    return {f"{one.get('classname')}::{one.get('name')}": float(one.get("time", 0.0)) for one in cases}


def times_by_file(times: dict[str, float]) -> Counter[str]:
    """Seconds of each module, of the times of its tests."""
    total = Counter[str]()
    for name, time_s in times.items():
        total[name.partition("::")[0]] += time_s
    return total


def heaviest(times: Iterable[tuple[str, float]], most: int) -> list[str]:
    """Lines of the longest ones."""
    return [f"{time_s:8.1f} s  {name}" for name, time_s in sorted(times, key=lambda one: -one[1])[:most]]


def main(arguments: list[str]) -> int:
    """Print them; 1 where a test took longer than the limit."""
    parser = argparse.ArgumentParser(description="The heaviest files and tests of a run.")
    parser.add_argument("path", type=Path, help="what pytest --junitxml wrote")
    parser.add_argument("--most", type=int, default=15, help="how many of each are shown")
    parser.add_argument("--limit", type=float, default=float("inf"), help="longest that a test may take [s]")
    asked = parser.parse_args(arguments)
    times = read_times(asked.path)
    print(f"{len(times)} tests, {sum(times.values()):.0f} s in all processes together")
    print(*heaviest(times_by_file(times).items(), asked.most), "", sep="\n")
    print(*heaviest(times.items(), asked.most), sep="\n")
    long = [name for name, time_s in times.items() if time_s > asked.limit]
    for name in long:
        print(f"over {asked.limit:g} s: shorten {name}, or mark it slow", file=sys.stderr)
    return 1 if long else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

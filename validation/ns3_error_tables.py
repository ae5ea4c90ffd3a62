"""Measure the packet errors of ns-3's table-based error model, and compare them with ours.

Usage: python validation/ns3_error_tables.py NS3_PYTHON
NS3_PYTHON is the interpreter of a virtual environment with pip's ``ns3`` 3.44. Needs g++. Prints the tables
as `modelcast.channel.table_error_model` has them, and ends with 1 where they are others.
"""

import argparse
import subprocess
import sys
from pathlib import Path

from modelcast.channel.table_error_model import ERROR_TABLES, TABLE_STEP_DB
from ns3 import folder_of  # puts the example on the path
from ns3_radio.program import build, environment

Table = tuple[float, tuple[float, ...]]


def measured(python: str) -> dict[tuple[float, int], Table]:
    """What ns-3 answers: SINR of the first entry below 1, and packet errors down to the last above 0."""
    ns3 = folder_of(python)
    program = build(Path(__file__).with_name("ns3_error_tables.cc"), ns3)
    asked = [str(program), "--from=-10", "--to=40", f"--step={TABLE_STEP_DB}"]
    run = subprocess.run(asked, capture_output=True, text=True, check=True, env=environment(ns3))  # noqa: S603
    found: dict[tuple[float, int], list[tuple[float, float]]] = {}
    for line in run.stdout.splitlines():
        rate_mbps, size_bytes, snr_db, lost = line.split()
        if 0.0 < float(lost) < 1.0:
            found.setdefault((float(rate_mbps), int(size_bytes)), []).append((float(snr_db), float(lost)))
    return {key: (rows[0][0], tuple(lost for _, lost in rows)) for key, rows in found.items()}


def main() -> int:
    """Print what was measured and say whether ours is the same."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("python", metavar="NS3_PYTHON")
    found = measured(parser.parse_args().python)
    for key, table in found.items():
        print(f"    {key}: {table},")
    same = found == ERROR_TABLES
    print("ours are the same" if same else "ours are others")
    return int(not same)


if __name__ == "__main__":
    sys.exit(main())

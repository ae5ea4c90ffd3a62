"""The table of docs/applications.md with people on the air, from what ``network`` wrote.

``vru.py FOLDER [--write | --check]``: a folder that holds the output of

    modelcast network --scenario crossing --application vru --density 15 --radio dsrc --blocks 3
        --pedestrians 60 --cyclists 20 --policy bsm-10hz baseline mbc --against bsm-10hz --threshold 0.2
        --duration 60 --warm-up 5 --seeds 3 --certificates always --out FOLDER

``--write`` puts the table into the page, ``--check`` tells by its exit code whether the page has it.
"""

import argparse
import json
from pathlib import Path

from fleet_warnings import fleet_table
from page_blocks import put

PAGE = Path(__file__).parents[1] / "docs" / "applications.md"


def main() -> int:
    """Print the table, and write or check it where asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--check", action="store_true")
    given = parser.parse_args()
    document = json.loads((given.folder / "summary.json").read_text(encoding="utf-8"))
    lines = fleet_table(document["warnings"])
    print(*lines, sep="\n")
    if given.write or given.check:
        return put({PAGE: {"vru": lines}}, check=given.check)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())

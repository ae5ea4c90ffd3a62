"""The tables of docs/capacity.md, from what ``modelcast capacity`` wrote.

``capacity.py FOLDER [--write | --check]``: a folder that holds the output of six calls. Five of them are

    modelcast capacity --length 2000 --duration 7 --warm-up 4 --seeds 2 --ratio 1.15 --lowest 50
        --highest 1600 --certificates always WORDS --out FOLDER/NAME

with NAME and WORDS

    loaded    --policy bsm-10hz baseline free mbc j2945 j2945-mbc --threshold 0.02 0.5
    sidelink  --radio sidelink --policy bsm-10hz j2945-mbc
    ins       --sensor ins --position absolute relative --policy bsm-10hz j2945-mbc
    unshared  --sensor gnss --latency 0 --position absolute relative --policy bsm-10hz j2945-mbc
    shared    the same with --shared-bias 0.97

and the sixth is

    modelcast capacity --scenario braking --length 1500 --margin 0 --duration 25 --warm-up 5 --seeds 2
        --ratio 1.3 --lowest 30 --highest 480 --certificates always --radio ideal dsrc --missed 0.01 0.25
        --policy bsm-10hz mbc j2945 --threshold 0.02 --out FOLDER/warnings

``--write`` puts the tables into the page, ``--check`` tells by its exit code whether the page has them.
"""

import argparse
from pathlib import Path

from page_blocks import put

PAGE = Path(__file__).parents[1] / "docs" / "capacity.md"
CALLS = ("loaded", "sidelink", "ins", "unshared", "shared", "warnings")


def table(folder: Path) -> list[str]:
    """The table of one call, without the sentence above it, which the page has once."""
    lines = (folder / "table.md").read_text(encoding="utf-8").splitlines()
    return [line for line in lines if line.startswith("|")]


def main() -> int:
    """Print the tables, and write or check them where asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--check", action="store_true")
    given = parser.parse_args()
    blocks = {name: table(given.folder / name) for name in CALLS}
    for name, lines in blocks.items():
        print(f"{name}\n", *lines, sep="\n")
    if given.write or given.check:
        return put({PAGE: blocks}, check=given.check)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())

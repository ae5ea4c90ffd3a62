"""Weigh an installation: which part of it is how heavy.

Installs this checkout, as the locks have its packages, into empty environments outside of it: alone, and with
each extra. Every distribution is weighed by the files that it names as its own. Needs uv, and a package index
or uv's cache. ``--write`` puts the tables into the block ``weight`` of ``docs/install.md``.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "validation"))

from modelcast.core.extras import EXTRAS  # noqa: E402 - after the folder of scripts is known
from page_blocks import put  # noqa: E402 - a script of this repository

_LEAST_MB = 2.0
"""Lighter distributions stand in one row."""

_UNLOCKED = {"sumo", "etsi", "mcap"}
"""Extras whose packages the lock of development does not hold, or holds in part."""

_WEIGH = """
import json, pathlib
from importlib.metadata import distributions
weight = {}
for one in distributions():
    total = 0
    for name in one.files or ():
        path = pathlib.Path(one.locate_file(name))
        if path.is_file() and path.suffix != ".pyc":
            total += path.stat().st_size
    weight[one.metadata["Name"].lower()] = total / 1e6
print(json.dumps(weight))
"""


def run(*words: str) -> str:
    """Run one of our own commands; what it printed."""
    known = {
        name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "VIRTUAL_ENV"))
    }
    ended = subprocess.run(words, env=known, capture_output=True, text=True, check=False)  # noqa: S603 - ours
    if ended.returncode:
        raise SystemExit(f"{' '.join(words)}:\n{ended.stderr}")
    return ended.stdout


def weighed(extra: str, python: str, *, compiled: bool = False) -> tuple[Mapping[str, float], float]:
    """Megabytes of each distribution; and of the whole environment, where asked for compiled to bytecode."""
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / "venv"
        uv = [sys.executable, "-m", "uv"]
        run(*uv, "venv", "--quiet", "--python", python, str(place))
        program = str(place / ("Scripts" if os.name == "nt" else "bin") / "python")
        source = f"{ROOT}[{extra}]" if extra else str(ROOT)
        locked = ["--constraint", str(ROOT / "requirements-dev.lock")] if extra not in _UNLOCKED else []
        run(*uv, "pip", "install", "--quiet", "--python", program, *locked, source)
        found: dict[str, float] = json.loads(run(program, "-c", _WEIGH))
        if compiled:
            run(program, "-m", "compileall", "-q", str(place))
        whole = sum(path.stat().st_size for path in place.rglob("*") if path.is_file()) / 1e6
        return found, whole


def tables(python: str) -> Sequence[str]:
    """The lines of the block."""
    base, compiled = weighed("", python, compiled=True)
    rows = sorted(base.items(), key=lambda one: -one[1])
    heavy = [(name, size) for name, size in rows if size >= _LEAST_MB]
    rest = sum(size for _, size in rows) - sum(size for _, size in heavy)
    version = run(python, "-c", "import platform; print(platform.python_version())").strip()
    lines = [
        f"Alone {sum(base.values()):.0f} MB in {len(base)} packages; Python {version}, {sys.platform}.",
        f"Compiled to bytecode, as pip does at once, it is {compiled:.0f} MB.",
        "",
        "| package | MB |",
        "|---|---|",
        *(f"| {name} | {size:.0f} |" for name, size in heavy),
        f"| {len(rows) - len(heavy)} others | {rest:.0f} |",
        "",
        "| extra | more MB | for |",
        "|---|---|---|",
    ]
    for name, extra in EXTRAS.items():
        found, _ = weighed(name, python)
        more = sum(size for one, size in found.items() if one not in base)
        lines.append(f"| `{name}` | {more:.0f} | {extra.needed_by} |")
    return lines


def main() -> int:
    """Weigh, and print or write."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--python", default=sys.executable, help="interpreter to install for")
    parser.add_argument("--write", action="store_true", help="write the block of docs/install.md")
    given = parser.parse_args()
    lines = tables(given.python)
    print(*lines, sep="\n")
    return put({ROOT / "docs" / "install.md": {"weight": lines}}, check=False) if given.write else 0


if __name__ == "__main__":
    raise SystemExit(main())

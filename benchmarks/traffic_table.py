"""Does the hybrid collide less than the baseline at every density? Print a finished sweep as a page.

``python benchmarks/traffic_table.py out/traffic > docs/traffic-table.md``: the verdicts of ``traffic.md`` in
a folder of ``modelcast network`` or ``run_traffic``, with the command that makes the folder.
"""

import json
import sys
from pathlib import Path
from typing import Any


def command(summary: dict[str, Any]) -> str:
    """The command that makes the runs of a summary."""
    runs, options = summary["runs"], summary["options"]

    def varied(name: str) -> str:
        return " ".join(dict.fromkeys(f"{row[name]:g}" if name != "radio" else row[name] for row in runs))

    banks = " ".join(dict.fromkeys(row["bank"] for row in runs if row["bank"] != "none"))
    own = [row["threshold_m"] for row in runs if row["threshold_m"] is not None]
    thresholds = " ".join(dict.fromkeys(f"{value:g}" for value in own))
    rules = "".join(
        f" --{name} {options[name]}" for name in ("start", "identify") if options[name] is not None
    )
    return (
        f"modelcast network --policy baseline mbc --bank {banks}{rules} --threshold {thresholds} \\\n"
        f"    --density {varied('density_per_km')} --radio {varied('radio')} \\\n"
        f"    --seeds {1 + max(row['run'] for row in runs)} --duration {options['duration_s']:g} "
        f"--warm-up {options['warm_up_s']:g} --length {options['length_m']:g} --out out/traffic"
    )


def main(folder: Path) -> None:
    """Print the page."""
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    print("# The hybrid against the baseline in traffic\n")
    print(f"Printed by `benchmarks/traffic_table.py`, modelcast {summary['modelcast']}, from the folder of\n")
    print(f"```sh\n{command(summary)}\n```\n")
    print((folder / "traffic.md").read_text(encoding="utf-8"), end="")


if __name__ == "__main__":
    main(Path(sys.argv[1]))

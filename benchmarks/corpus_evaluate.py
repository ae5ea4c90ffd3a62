"""How fast `modelcast evaluate --rates-only` is on a corpus, and what memory it takes.

``python benchmarks/corpus_evaluate.py --work FOLDER``: makes rows and corpora (`corpus_rows`, `corpus`;
kept in the folder), evaluates them at the defaults (four thresholds, default bank, baseline and references)
with one process and with two, and prints the table of docs/corpora.md. Rows a second and core are rows over
processor time of all processes; memory is the most that their resident sets held together.
"""

import argparse
import shutil
import sys
from pathlib import Path

from corpus import MILLION, ingest, measured
from corpus_rows import write_rows
from measured import record

COMMAND = (sys.executable, "-m", "modelcast", "evaluate")


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--work", type=Path, required=True)
    parser.add_argument("--millions", type=int, nargs="+", default=[1, 2, 4, 8])
    parser.add_argument("--jobs", type=int, nargs="+", default=[1, 2])
    asked = parser.parse_args()
    print("| rows | processes | wall, s | processor, s | rows/s | rows/s and core | memory, MiB |")
    print("|--:|--:|--:|--:|--:|--:|--:|", flush=True)
    for millions in asked.millions:
        corpus = asked.work / f"evaluated-{millions}m"
        if not (corpus / "corpus.json").is_file():
            source = asked.work / f"rows-{millions}m"
            if not source.is_dir():
                write_rows(millions * MILLION, source)
            ingest(source, corpus, max(asked.jobs))
        for jobs in asked.jobs:
            out = asked.work / "evaluation"
            shutil.rmtree(out, ignore_errors=True)
            words = [str(corpus), "--rates-only", "--out", str(out), "--jobs", str(jobs), "--quiet"]
            run = measured([*COMMAND, *words])
            rows = millions * MILLION
            sizes = {"rows": rows, "processes": jobs}
            record("evaluate", rows / run.processor_s, "rows/s and core", sizes=sizes)
            record("evaluate, memory", run.resident_bytes / 2**20, "MiB", sizes=sizes)
            rates = f"{rows / run.wall_s:,.0f} | {rows / run.processor_s:,.0f}"
            print(
                f"| {rows:,} | {jobs} | {run.wall_s:.0f} | {run.processor_s:.0f} | {rates} | "
                f"{run.resident_bytes / 2**20:,.0f} |",
                flush=True,
            )


if __name__ == "__main__":
    main()

"""Makes docs/wrong-uses.md of the table of wrong uses: ``python -m tests.cli.wrong_uses_page --write``."""

import argparse
import sys
import tempfile
from pathlib import Path

from tests.cli.wrong_uses import GROUPS, made_files
from tests.cli.wrong_uses_answers import PAGE, answered, page


def main() -> None:
    """Print the page, or write it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--write", action="store_true", help="write docs/wrong-uses.md instead of printing it"
    )
    write = parser.parse_args().write
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        made_files(folder)
        text = page({use: answered(use, folder) for uses in GROUPS.values() for use in uses})
    if write:
        PAGE.write_text(text, encoding="utf-8")
    else:
        sys.stdout.write(text)


if __name__ == "__main__":
    main()

"""People on foot and on bicycles: the shipped profile of people, and how it fares on tracks it has not seen.

``people.py profile`` prints the profile that ships as ``people``; with ``--write`` it puts the file into the
package, with ``--check`` it tells by its exit code whether the package has it.
"""

import argparse
import sys

from modelcast.models.bank import Bank
from modelcast.models.profile import Profile
from modelcast.models.shipped import PEOPLE, profile_path
from modelcast.models.stop_and_go import StopAndGo


def shipped() -> Profile:
    """The profile of people: one sub-model without trained weights."""
    found = {
        "constants": "round numbers, chosen on every other track of each recording of docs/people.md",
        "trained": "nothing",
    }
    return Profile(Bank((StopAndGo(),), PEOPLE), start="hindsight", identify="never", record=found)


def profile(*, write: bool, check: bool) -> int:
    """Print the shipped profile, write it or compare it."""
    path, text = profile_path(PEOPLE), shipped().text
    if write:
        path.write_text(text, encoding="utf-8", newline="\n")
    if check:
        return int(not path.exists() or path.read_text(encoding="utf-8") != text)
    print(text, end="")
    return 0


def main() -> int:
    """Make the profile."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("what", choices=("profile",))
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--check", action="store_true")
    given = parser.parse_args()
    return profile(write=given.write, check=given.check)


if __name__ == "__main__":
    sys.exit(main())

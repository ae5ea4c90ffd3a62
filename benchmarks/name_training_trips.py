"""Write the fingerprints of the trips that the shipped profile was trained on into it.

Run it with the folder of recorded trips, from the root of the project::

    MODELCAST_DATA=DIR python benchmarks/name_training_trips.py

Every trip of the profile's record must be there, with its format and duration. Nothing else of the profile
changes, so its identity stays; the file is rewritten only where fingerprints differ.
"""

import os
from pathlib import Path

from modelcast.io.profile import read_profile, write_profile
from modelcast.io.trips import read_trips
from modelcast.study.training.profile import named_training_trips

__all__ = ["main"]

PROFILE = Path(__file__).parents[1] / "src" / "modelcast" / "profiles" / "default.json"
FOLDERS = ("openacc_zalazone", "spmd", "comma2k19")


def main() -> None:
    """Compute them, compare, write."""
    data = Path(os.environ["MODELCAST_DATA"])
    before = read_profile(PROFILE)
    after = named_training_trips(before, list(read_trips([data / folder for folder in FOLDERS])))
    if after.identity != before.identity:
        raise AssertionError("the identity has changed")
    if after != before:
        write_profile(after, PROFILE)
    print(f"{len(after.training_trips)} trips, identity {after.identity}")


if __name__ == "__main__":
    main()

"""Generated drives as files: trips to try commands on, before there are some of one's own."""

from dataclasses import replace
from pathlib import Path

__all__ = ["DRIVES", "write_drives"]

DRIVES = 6
"""Enough to train on some of them and judge on the others."""


def write_drives(out: Path, *, duration_s: float, seed: int, shown: str) -> list[str]:
    """Write `DRIVES` generated drives, each a CSV of what its receiver and its vehicle bus said.

    Parameters
    ----------
    out
        The folder; one that an earlier call wrote is replaced.
    duration_s
        Length of a drive [s].
    seed
        Seed of the first; the others follow.
    shown
        What errors call the folder.

    Returns
    -------
    list of str
        Names of the files, in order.

    Raises
    ------
    ConfigError
        Where the folder holds what this command did not write.
    ValueError
        Where the drives are too short for their manoeuvres.
    """
    from modelcast.io.output import atomic_folder
    from modelcast.io.write_trips import write_csv
    from modelcast.world.drive import generate_drive

    names = [f"drive-{number}" for number in range(1, DRIVES + 1)]
    with atomic_folder(out, command="demo --trips", shown=shown) as folder:
        for number, name in enumerate(names):
            drive = generate_drive(seed=seed + number, duration_s=duration_s)
            with (folder / f"{name}.csv").open("wb") as file:
                write_csv(replace(drive.input, trip_id=name), file)
    return [f"{name}.csv" for name in names]

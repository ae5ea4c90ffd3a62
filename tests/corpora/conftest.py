"""Sources of small corpora."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from modelcast.io.write_trips import write_parquet
from modelcast.trips.trajectory import Trajectory, build_trajectory


def wsu_row(device: int, trip: int, at: int, *, valid: int = 1, latitude: float | None = None) -> str:
    """A row of DataWsu: a car that goes north at 10 m/s."""
    north = 42.0 + at * 1.0 / 111_320.0 if latitude is None else latitude
    return (
        f"{device},{trip},{10 * at},{valid},{1349093298700 + 100 * at},{north:.7f},-83.4,180.0,0.5,31.0,"
        f"1.0,1.7,1,0,1,-0.67,36.0,0.0,0.0,0,0.02,5,0,0,0,0.0,0.0\n"
    )


@pytest.fixture
def sources(tmp_path: Path) -> Callable[[], Path]:
    """Write a folder of sources once: vehicles with several trips each, in disorder, with faults."""

    def write() -> Path:
        folder = tmp_path / "data"
        folder.mkdir(exist_ok=True)
        rng = np.random.default_rng(3)
        for name, trips in (("april", (1, 2)), ("may", (3,))):
            rows = [
                wsu_row(10100 + device, trip, at, valid=int(at != 7))
                for device in range(6)
                for trip in trips
                for at in range(40)
            ]
            rng.shuffle(rows)
            (folder / f"{name}.csv").write_text("".join(rows))
        many = [wsu_row(10100, 9, at) for at in range(300)]
        (folder / "broken.csv").write_text("".join([*many, "1,2,x\n", wsu_row(1, 1, 1)]))
        (folder / "lost.csv").write_text(
            "".join(wsu_row(10199, 1, at, latitude=91.0 if at else 42.0) for at in range(3))
        )
        (folder / "notes.txt").write_text("of no format\n")
        write_parquet(odd_trips(), folder / "odd.parquet")
        return folder

    return write


def odd_trips() -> list[Trajectory]:
    """Trips with a gap, with uneven steps, and without any optional column."""
    t = np.arange(60) * 0.1
    gap_t = np.where(t > 3.0, t + 5.0, t)
    uneven_t = t + 0.04 * np.sin(np.arange(60))
    line = np.stack([12.0 * t, 0.3 * t**2], axis=1)
    return [
        build_trajectory("odd/gap", gap_t, line, speed_mps=np.full(60, 12.0), start_unix_s=1.6e9),
        build_trajectory("odd/uneven", uneven_t, np.stack([12.0 * uneven_t, 0 * t], axis=1)),
        build_trajectory("april/10100-1", t, line, heading_rad=0 * t, up_m=t),
    ]

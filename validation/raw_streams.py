"""A drive's own streams, as late and as uneven as they were logged, against the same drive resampled.

One comma2k19 segment: fixes at 10 Hz that were logged 60 to 130 ms after their epoch, speed at 83 Hz and
the gyro at 104 Hz. A station that evaluates a trip takes each fix at its epoch; a node has a tick of its
own and must carry the newest fix on to it. Printed is how far the node's motion at its ticks is from the
recorded trip at the same instants, for ticks of several phases, and what a tick costs.
"""

import argparse
import os
import sys
import time
from pathlib import Path

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.io.trips import read_trips
from modelcast.node.inputs.motion_source import MotionSource
from modelcast.node.inputs.samples import BusValue, GnssFix, Sample
from page_blocks import put

__all__ = ["main"]

SHORTEST_S = 0.06
"""From an epoch to its log at the least: what comma2k19's reader says of it."""
PAGE = Path(__file__).parents[1] / "docs" / "node-inputs.md"
PHASES = 5
BEGIN_S = 3.0


def streams(folder: Path) -> tuple[list[Sample], float]:
    """Samples of a segment in order of arrival, on the device's clock, and UTC at its 0 [s]."""
    log = next(folder.rglob("processed_log"))

    def read(name: str) -> tuple[FloatArray, FloatArray]:
        return np.load(log / name / "t", allow_pickle=False), np.load(
            log / name / "value", allow_pickle=False
        )

    logged_s, fixes = read("GNSS/live_gnss_ublox")
    utc_s = fixes[:, 3] / 1000.0
    zero_s = float((utc_s - logged_s).max()) + SHORTEST_S
    samples: list[Sample] = []
    for at_s, row, measured_s in zip(
        logged_s.tolist(), fixes.tolist(), (utc_s - zero_s).tolist(), strict=True
    ):
        samples.append(
            GnssFix(
                received_s=at_s, measured_s=measured_s, latitude_deg=row[0], longitude_deg=row[1],
                speed_mps=row[2], heading_rad=np.radians(row[5]), altitude_m=row[4],
            )
        )  # fmt: skip
    for name, quantity, column in (("CAN/speed", "speed_mps", 0), ("IMU/gyro", "yaw_rate_radps", 2)):
        times_s, values = read(name)
        columns = values.reshape(times_s.size, -1)[:, column]
        for at_s, value in zip(times_s.tolist(), columns.tolist(), strict=True):
            samples.append(BusValue(quantity, value, at_s, at_s))
    return sorted(samples, key=lambda one: one.received_s), zero_s


def main(arguments: list[str] | None = None) -> int:
    """Print the differences; returns 1 where their median exceeds 10 cm."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true", help="put the table into docs/node-inputs.md")
    given = parser.parse_args(arguments)
    folder = Path(os.environ["MODELCAST_DATA"]) / "comma2k19"
    (trip,) = read_trips(folder)
    samples, zero_s = streams(folder)
    assert trip.start_unix_s is not None
    begin_s = trip.start_unix_s - zero_s
    lines = [
        "| tick's phase | ticks | place p50 | p95 | speed p95 | heading p95 | age of the fix p50 | a tick |",
        "|---|---|---|---|---|---|---|---|",
    ]
    medians: list[float] = []
    for phase_s in (0.1 / PHASES * np.arange(PHASES)).tolist():
        source, at = MotionSource(trip.origin), 0
        rows: list[tuple[float, ...]] = []
        spent_s: list[float] = []
        for since_s in (phase_s + np.arange(BEGIN_S, float(trip.t_s[-1]) - 0.2, 0.1)).tolist():
            now_s = begin_s + since_s
            first = at
            while at < len(samples) and samples[at].received_s <= now_s:
                at += 1
            before_s = time.perf_counter()
            source.feed(samples[first:at])
            motion = source.at(now_s)
            spent_s.append(time.perf_counter() - before_s)
            if motion is None or motion.mode != "gnss+can":
                continue
            place_m = [np.interp(since_s, trip.t_s, trip.position_m[:, axis]) for axis in (0, 1)]
            assert trip.speed_mps is not None
            assert trip.heading_rad is not None
            turned = np.interp(since_s, trip.t_s, np.unwrap(trip.heading_rad)) - motion.heading_rad
            rows.append(
                (
                    float(np.hypot(*(np.array(motion.position_m) - place_m))),
                    abs(motion.speed_mps - float(np.interp(since_s, trip.t_s, trip.speed_mps))),
                    abs(float(np.degrees((turned + np.pi) % (2.0 * np.pi) - np.pi))),
                    motion.age_s,
                )
            )
        found = np.array(rows)
        place, speed, heading, age = found.T
        medians.append(float(np.median(place)))
        lines.append(
            f"| {1e3 * phase_s:.0f} ms | {len(found)} | {100 * medians[-1]:.1f} cm | "
            f"{100 * np.quantile(place, 0.95):.1f} cm | {np.quantile(speed, 0.95):.2f} m/s | "
            f"{np.quantile(heading, 0.95):.2f}° | {1e3 * np.median(age):.0f} ms | "
            f"{1e6 * np.median(spent_s):.0f} µs |"
        )
    print("\n".join(lines))
    if given.write:
        put({PAGE: {"raw streams": lines}}, check=False)
    return int(max(medians) > 0.1)


if __name__ == "__main__":
    sys.exit(main())

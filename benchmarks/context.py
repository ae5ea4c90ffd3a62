"""Does context tell what comes? The road's turn and the leader's motion against what happened 3 s later.

    python benchmarks/context.py TRIPS...

Of moving cars with the road known: the turn of the course over the next 3 s, predicted by the remembered
road, by the present yaw rate, and as none. With a leader known: the change of speed over the next 3 s, by a
line through the own acceleration, and by one through the leader's gap, relative speed and accelerations too,
fitted and judged on the same samples.
"""

import argparse

import numpy as np

from modelcast.core.arrays import FloatArray
from modelcast.io.trips import read_trips
from modelcast.models.context_columns import LEADER_GAP, LEADER_KNOWN, ROAD_KNOWN, ROAD_TURN
from modelcast.models.point_kernels import ACCELERATION, VELOCITY_EAST, VELOCITY_NORTH, YAW_RATE
from modelcast.runtime.trip.context import TripContexts
from modelcast.station.sensing.sensing import sample_matrix
from modelcast.station.sensing.velocity import velocity_estimator_for

AHEAD_S = 3.0
MOVES_MPS = 2.0


def rms(values: FloatArray) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(values**2)))


def residual(columns: FloatArray, wanted: FloatArray) -> float:
    """Root mean square of what a line leaves."""
    table = np.column_stack([columns, np.ones(len(columns))])
    return rms(wanted - table @ np.linalg.lstsq(table, wanted, rcond=None)[0])


def main() -> None:
    """Print both comparisons."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("trips", nargs="+")
    trips = list(read_trips(parser.parse_args().trips))
    contexts = TripContexts(trips)
    rows: list[FloatArray] = []
    for which, trip in enumerate(trips):
        samples = sample_matrix(trip, velocity_estimator_for(trip))
        speed = np.hypot(samples[:, VELOCITY_EAST], samples[:, VELOCITY_NORTH])
        course = np.unwrap(np.arctan2(samples[:, VELOCITY_EAST], samples[:, VELOCITY_NORTH]))
        step = round(AHEAD_S / trip.dt_s)
        found = np.column_stack(
            [
                contexts.of(which)[:-step],
                course[step:] - course[:-step],
                AHEAD_S * samples[:-step, YAW_RATE],
                speed[:-step],
                speed[step:],
                samples[:-step, ACCELERATION],
            ]
        )
        rows.append(found[trip.t_s[step:] - trip.t_s[:-step] < 1.1 * AHEAD_S])
    table = np.concatenate(rows)
    turned, turning, now, then, own = table[:, -5:].T
    moves = (now > MOVES_MPS) & (then > MOVES_MPS)
    road = moves & (table[:, ROAD_KNOWN] > 0.0)
    leader = table[:, LEADER_KNOWN] > 0.0
    print(
        f"{len(trips)} trips, {len(table)} samples; road known in {table[:, ROAD_KNOWN].mean():.2f} of them,"
    )
    print(f"a leader in {leader.mean():.2f}")
    if road.any():
        told = table[road, ROAD_TURN + round(AHEAD_S) - 1]
        print(f"turn over {AHEAD_S:g} s, rms error [rad] (correlation):")
        print(f"  road      {rms(told - turned[road]):.4f} ({np.corrcoef(told, turned[road])[0, 1]:.2f})")
        yaw = turning[road]
        print(f"  yaw rate  {rms(yaw - turned[road]):.4f} ({np.corrcoef(yaw, turned[road])[0, 1]:.2f})")
        print(f"  none      {rms(turned[road]):.4f}")
    if leader.any():
        change = (then - now)[leader]
        ahead = np.column_stack([own[leader], table[leader, LEADER_GAP:LEADER_KNOWN]])
        print(f"change of speed over {AHEAD_S:g} s, rms error [m/s]:")
        print(f"  none      {rms(change):.3f}")
        print(f"  own       {residual(own[leader][:, None], change):.3f}")
        print(f"  leader    {residual(ahead, change):.3f}")


if __name__ == "__main__":
    main()

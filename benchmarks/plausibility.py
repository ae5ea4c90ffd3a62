"""Find out how many samples of recorded trips are found implausible, and what a check costs.

Every sample is a message. Trips without heading (OpenACC) state the causal velocity estimate that their
senders would use; the others their own columns.
"""

import os
import sys
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np

from modelcast.io.trips import read_trips
from modelcast.messages.mbc import ModelUpdate
from modelcast.models.bank import Bank
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.station.receiver.host import Host, HostState
from modelcast.station.receiver.plausibility import Finding, Plausibility, PlausibilityState
from modelcast.station.receiver.statements import Statements, statements_of
from modelcast.station.sensing.sensing import sample_matrix
from modelcast.station.sensing.velocity import velocity_estimator_for

ROUNDS = 9
VEHICLES, STEPS = 300, 50
EVERY = (1, 5, 20)


def main() -> int:
    """Measure and print."""
    folder = os.environ.get("MODELCAST_DATA", "")
    if not folder:
        print("MODELCAST_DATA is not set")
        return 2
    found: dict[tuple[str, int], Counter[str]] = {}
    trips: Counter[str] = Counter()
    for trip in read_trips(Path(folder)):
        trips[trip.source] += 1
        given = statements_of(trip)
        if given is None:
            velocity_mps = sample_matrix(trip, velocity_estimator_for(trip))[:, 2:4].copy()
            given = Statements(
                np.zeros(len(trip), dtype=np.int64),
                trip.t_s,
                position_m=trip.position_m,
                velocity_mps=velocity_mps,
                received_s=trip.t_s,
            )
        for every in EVERY:
            findings, _ = Plausibility().check(PlausibilityState(), thinned(given, every))
            names = (Finding(one).name for one in findings)
            found.setdefault((trip.source, every), Counter()).update(names)
    for (source, every), counts in sorted(found.items()):
        print(f"{source:10s} {trips[source]:3d} trips, every {every:2d}th: {dict(counts)}")
    timings()
    return 0


def thinned(given: Statements, every: int) -> Statements:
    """Return every so many-th report."""
    return Statements(
        given.vehicle[::every],
        given.t_s[::every],
        position_m=given.position_m[::every],
        velocity_mps=given.velocity_mps[::every],
        received_s=given.received_s[::every],
    )


def timings() -> None:
    """Print the cost of a check in batch, and of a message at the host with and without."""
    vehicle = np.tile(np.arange(VEHICLES), STEPS)
    t_s = np.repeat(np.arange(STEPS) * 0.1, VEHICLES)
    whole = Statements(
        vehicle,
        t_s,
        position_m=np.stack([20 * t_s, 5.0 * vehicle], axis=1),
        velocity_mps=np.tile([20.0, 0.0], (t_s.size, 1)),
        received_s=t_s,
    )
    checks = Plausibility()
    checks.check(PlausibilityState(), whole)
    print(f"{VEHICLES} vehicles, {STEPS} steps, one batch a step: {batch_us(checks, whole):.2f} µs a message")
    for name, host in (
        ("without", Host(Bank((ConstantVelocity(),)))),
        ("with", Host(Bank((ConstantVelocity(),)), plausibility=checks)),
    ):
        print(
            f"Host.receive {name} plausibility, {VEHICLES} remotes: {host_us(host, whole):.1f} µs a message"
        )


def batch_us(checks: Plausibility, whole: Statements) -> float:
    """Return the shortest time a message of all rounds [µs]."""

    def run() -> None:
        state = PlausibilityState()
        for step in range(STEPS):
            part = slice(step * VEHICLES, (step + 1) * VEHICLES)
            one = Statements(
                whole.vehicle[part],
                whole.t_s[part],
                position_m=whole.position_m[part],
                velocity_mps=whole.velocity_mps[part],
                received_s=whole.received_s[part],
            )
            _, state = checks.check(state, one)

    return least_us(run, whole.t_s.size)


def host_us(host: Host, whole: Statements) -> float:
    """Return the shortest time a message of all rounds [µs]."""
    messages = [
        ModelUpdate(
            int(whole.vehicle[i]),
            i // VEHICLES,
            float(whole.t_s[i]),
            position_m=whole.position_m[i],
            in_use=0,
            parameters=whole.velocity_mps[i],
            dt_s=0.1,
        )
        for i in range(3 * VEHICLES)
    ]

    def run() -> None:
        state = HostState()
        for message in messages:
            _, state = host.receive(state, message, received_s=message.t_s)

    return least_us(run, len(messages))


def least_us(run: Callable[[], None], messages: int) -> float:
    """Return the shortest over rounds, since other work may run [µs]."""
    times = []
    for _ in range(ROUNDS):
        begin = time.perf_counter_ns()
        run()
        times.append((time.perf_counter_ns() - begin) / messages / 1e3)
    return min(times)


if __name__ == "__main__":
    sys.exit(main())

"""Time the radios on one core: 200 nodes as in the ns-3 comparison, and fleets of 1,000 and 5,000 vehicles.

With MODELCAST_NS3_PYTHON set to an interpreter that has pip's ``ns3`` 3.44 (and g++ at hand), the same
200-node case is run there too. Times are processor times, so that other work on the machine does not count.
"""

import os
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from measured import record
from modelcast.channel.dsrc import Dsrc
from modelcast.channel.nr import Nr
from modelcast.channel.radio import AbstractRadio, Transmissions
from modelcast.channel.sidelink import Sidelink

VALIDATION = Path(__file__).parents[1] / "validation"
SECONDS = 3.0


def fleet_s(radio: AbstractRadio[Any], vehicles: int, rate_hz: float) -> tuple[float, float]:
    """Processor time a simulated second and mean channel busy ratio of a fleet with 200 vehicles a km."""
    rng = np.random.default_rng(0)
    length_m = 5.0 * vehicles
    position_m = np.stack([rng.uniform(0, length_m, vehicles), 4.0 * rng.integers(0, 8, vehicles)], axis=1)
    speed_mps = np.where(position_m[:, 1] < 16.0, 30.0, -30.0)
    phase_s = rng.uniform(0.0, 1.0 / rate_hz, vehicles)
    state: Any = radio.init(vehicles, rng)
    spent_s, ratio = 0.0, 0.0
    steps = round(10 * SECONDS)
    for k in range(-10, steps):  # the first second warms up
        t_s = 0.1 * (k + 10)
        turn = np.ceil((t_s - phase_s) * rate_hz - 1e-9)
        due_s = phase_s + turn / rate_hz
        sender = np.flatnonzero((due_s >= t_s) & (due_s < t_s + 0.1 - 1e-9))
        sender = sender[np.argsort(due_s[sender], kind="stable")]
        batch = Transmissions(
            sender,
            np.maximum(due_s[sender], state.t_s),
            size_bytes=np.full(sender.size, 300),
            power_dbm=np.full(sender.size, 20.0),
            message_id=sender + (k + 10) * vehicles,
        )
        start_s = time.process_time()
        carry = getattr(radio, "carry", radio.step)
        _, state = carry(state, batch, position_m, round(t_s + 0.1, 3))
        if k >= 0:
            spent_s += time.process_time() - start_s
            ratio += float(radio.channel_busy_ratio(state).mean()) / steps
        position_m[:, 0] = (position_m[:, 0] + 0.1 * speed_mps) % length_m
    return spent_s / SECONDS, ratio


def main() -> None:
    """Print the times."""
    sys.path.insert(0, str(VALIDATION))
    import ns3 as comparison  # noqa: PLC0415 - a script of the neighbouring folder

    where = comparison.places(200, 0)
    comparison.ours(*comparison.places(10, 0), 0)  # compiles
    own_s = comparison.ours(*where, 0).took.processor_s
    print(f"200 nodes, 10 Hz, {comparison.NIST.seconds:.0f} s simulated: {own_s:.3f} s")
    python = os.environ.get("MODELCAST_NS3_PYTHON", "")
    if python:
        with tempfile.TemporaryDirectory() as name:
            wheel = comparison.folder_of(python)
            program = comparison.build(VALIDATION / "ns3_broadcast.cc", wheel)
            took_s = comparison.theirs(program, wheel, where, 0, Path(name))[1].processor_s
        record("200 nodes at 10 Hz", own_s, "s", peer=("ns-3", took_s))
        print(f"  ns-3: {took_s:.2f} s, {took_s / own_s:.0f} times as long")
    for title, radio in (("802.11p", Dsrc()), ("mode 4", Sidelink()), ("NR mode 2", Nr())):
        fleet_s(radio, 20, 5.0)  # compiles
        for vehicles, rate_hz in ((1000, 2.0), (1000, 5.0), (1000, 10.0), (2500, 5.0), (5000, 5.0)):
            spent_s, ratio = fleet_s(radio, vehicles, rate_hz)
            name = f"{title}, {rate_hz:g} Hz"
            record(name, spent_s, "s a simulated second", sizes={"vehicles": vehicles})
            print(
                f"{title}, {vehicles} vehicles at {rate_hz:.0f} Hz: {spent_s:.3f} s a simulated second,"
                f" channel busy ratio {ratio:.2f}"
            )


if __name__ == "__main__":
    main()

"""Make the table of the abstract radio: chance of reception on 802.11p by distance and load.

Vehicles stand still on 3 km of road and send 10 messages of 168 bytes a second at 20 dBm, at more and more of
them a kilometre. The load is what `TabulatedRadio` takes it for: the airtime of all senders within 300 m.
"""

import numpy as np

from modelcast.channel.dsrc import Dsrc
from modelcast.channel.radio import Transmissions

LENGTH_M, LOAD_RANGE_M, BYTES = 3000.0, 300.0, 168
STEPS, WARM_UP = 30, 5


def row(density_per_km: float) -> tuple[float, list[float]]:
    """Load and chance of reception by bin at one density."""
    rng = np.random.default_rng(0)
    vehicles = round(density_per_km * LENGTH_M / 1000.0)
    place = np.column_stack([rng.uniform(0.0, LENGTH_M, vehicles), 4.0 * rng.integers(0, 6, vehicles)])
    radio = Dsrc()
    state = radio.init(vehicles, rng)
    phase = rng.uniform(0.0, 0.095, vehicles)
    outcomes = np.zeros((radio.parameters.bins, 5), dtype=np.int64)
    for k in range(STEPS):
        ready = 0.1 * k + phase + rng.uniform(0.0, 0.005, vehicles)
        order = np.argsort(ready)
        batch = Transmissions(
            order,
            ready[order],
            size_bytes=np.full(vehicles, BYTES),
            power_dbm=np.full(vehicles, 20.0),
            message_id=k * vehicles + order,
        )
        heard, state = radio.carry(state, batch, place, round(0.1 * (k + 1), 6))
        if k >= WARM_UP:
            outcomes += heard.outcomes
    middle = place[np.abs(place[:, 0] - 0.5 * LENGTH_M) < 0.5 * LENGTH_M - LOAD_RANGE_M]
    near = np.mean([(np.hypot(*(place - one).T) <= LOAD_RANGE_M).sum() for one in middle])
    airtime_s = 40e-6 + 8e-6 * BYTES / 6.0
    return float(near * airtime_s * 10.0), (outcomes[:, 0] / outcomes.sum(axis=1)).tolist()


def main() -> None:
    """Print the rows."""
    for density in (10.0, 50.0, 100.0, 200.0, 400.0, 600.0):
        load, ratios = row(density)
        print(f"{load:.3f}", [round(ratio, 3) for ratio in ratios])


if __name__ == "__main__":
    main()

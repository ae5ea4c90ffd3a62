"""Make the table of the abstract radio: reception on 802.11p by distance and load, and how busy it is found.

Vehicles stand still on 3 km of road and send 10 messages of 168 bytes a second at 20 dBm, at more and more of
them a kilometre. The load is what `TabulatedRadio` itself takes it for, of vehicles away from the ends; the
busy ratio of the same vehicles is that of `Dsrc`. Sums over `SEEDS` placements.
"""

import numpy as np

from modelcast.channel.dsrc import Dsrc
from modelcast.channel.radio import Transmissions
from modelcast.channel.tabulated import ReceptionTable, TabulatedRadio

LENGTH_M, END_M, BYTES = 3000.0, 400.0, 168
STEPS, WARM_UP, SEEDS = 30, 5, 3
DENSITIES_PER_KM = (10.0, 50.0, 100.0, 200.0, 400.0, 600.0, 900.0, 1200.0)


def placed(density_per_km: float, seed: int) -> tuple[float, float, np.ndarray]:
    """Load, busy ratio and outcomes at one density."""
    rng = np.random.default_rng(seed)
    vehicles = round(density_per_km * LENGTH_M / 1000.0)
    place = np.column_stack([rng.uniform(0.0, LENGTH_M, vehicles), 4.0 * rng.integers(0, 6, vehicles)])
    radio, meter = Dsrc(), TabulatedRadio(ReceptionTable(np.zeros(1), np.zeros((1, 1))))
    state, metered = radio.init(vehicles, rng), meter.init(vehicles, rng)
    phase = rng.uniform(0.0, 0.095, vehicles)
    outcomes = np.zeros((radio.parameters.bins, 5), dtype=np.int64)
    middle = np.abs(place[:, 0] - 0.5 * LENGTH_M) < 0.5 * LENGTH_M - END_M
    busy = []
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
        until_s = round(0.1 * (k + 1), 6)
        heard, state = radio.carry(state, batch, place, until_s)
        if k >= WARM_UP:
            outcomes += heard.outcomes
            busy.append(radio.channel_busy_ratio(state)[middle].mean())
    _, metered = meter.step(metered, batch, place, until_s)
    # Every vehicle sends once in each interval of 100 ms; the meter was asked for all of them in one.
    load = metered.load_ratio[middle].mean() * until_s / 0.1
    return float(load), float(np.mean(busy)), outcomes


def main() -> None:
    """Print the rows: load, busy ratio, chance of reception by 50 m."""
    for density in DENSITIES_PER_KM:
        made = [placed(density, seed) for seed in range(SEEDS)]
        load, busy = (np.mean([one[column] for one in made]) for column in (0, 1))
        outcomes = np.sum([one[2] for one in made], axis=0)
        ratios = outcomes[:, 0] / outcomes.sum(axis=1)
        print(f"{load:.3f} {busy:.3f}", ratios.round(3).tolist(), flush=True)


if __name__ == "__main__":
    main()

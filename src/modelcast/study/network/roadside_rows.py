"""What roadside units of a run held and repeated, as rows."""

from dataclasses import dataclass

__all__ = ["RoadsideDistanceRow", "RoadsideRow"]


@dataclass(frozen=True, slots=True, kw_only=True)
class RoadsideRow:
    """What the units of one run did, and what they held of vehicles 50 m to 150 m away.

    Parameters
    ----------
    density_per_km, radio, policy, bank, threshold_m, run
        As in `modelcast.study.network.rows.NetworkCase`.
    units
        How many there were.
    busy_ratio
        Channel busy ratio that they observed.
    delivery_ratio
        Share of the vehicles' frames that they heard from the vehicle itself.
    repeated_rate_hz, repeated_bytes_per_s
        What a unit handed to its radio again [1/s].
    unsent_ratio
        Share of these that the next took the place of before they were sent.
    by_another_rate_hz, replaced_rate_hz, too_old_rate_hz, too_far_rate_hz
        What a unit did not repeat, by `modelcast.station.relay.RelayState` [1/s].
    held_ratio, pte_p50_m, pte_p90_m, pte_p95_m, pte_p99_m, age_p50_s, age_p90_s, gap_p50_s, gap_p90_s
        As in `modelcast.study.network.rows.RunRow`, of vehicles at units.
    """

    density_per_km: float
    radio: str
    policy: str
    bank: str
    threshold_m: float
    run: int
    units: int
    busy_ratio: float
    delivery_ratio: float
    repeated_rate_hz: float
    repeated_bytes_per_s: float
    unsent_ratio: float
    by_another_rate_hz: float
    replaced_rate_hz: float
    too_old_rate_hz: float
    too_far_rate_hz: float
    held_ratio: float
    pte_p50_m: float
    pte_p90_m: float
    pte_p95_m: float
    pte_p99_m: float
    age_p50_s: float
    age_p90_s: float
    gap_p50_s: float
    gap_p90_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class RoadsideDistanceRow:
    """What the units of one run held of vehicles at one distance.

    Parameters
    ----------
    density_per_km, radio, policy, bank, threshold_m, run
        As in `modelcast.study.network.rows.NetworkCase`.
    low_m, high_m
        Bounds of the distance [m].
    frames, pairs
        Pairs of a frame and a unit; samples of pairs of a vehicle and a unit, whether tracked or not.
    delivery_ratio, held_ratio, pte_p50_m, pte_p90_m, pte_p95_m, pte_p99_m, age_p50_s, age_p90_s, gap_p50_s, \
gap_p90_s
        As in `RoadsideRow`, at this distance.
    """

    density_per_km: float
    radio: str
    policy: str
    bank: str
    threshold_m: float
    run: int
    low_m: float
    high_m: float
    frames: int
    pairs: int
    delivery_ratio: float
    held_ratio: float
    pte_p50_m: float
    pte_p90_m: float
    pte_p95_m: float
    pte_p99_m: float
    age_p50_s: float
    age_p90_s: float
    gap_p50_s: float
    gap_p90_s: float

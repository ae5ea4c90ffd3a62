"""The two-way loop: SUMO says where vehicles are, their maps say what to do, SUMO does it."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from modelcast import (
    CruiseControl,
    ErasureRadio,
    FleetFrame,
    IndependentErasure,
    PathCacc,
    Platoons,
    PlatoonTrace,
    Sinusoid,
    measure_drive,
    platoon_sender,
)
from sumo_cacc.traffic import STEP_S, sumo_platoon

SETTLE_S = 5.0
"""The leader swings from then on, and what came before is not counted."""


@dataclass(frozen=True, slots=True)
class Case:
    """What is sent, and what of it is lost.

    Parameters
    ----------
    sender
        As ``modelcast cruise --policy`` knows it: bsm-10hz, bsm-2hz, mbc.
    loss_ratio
        Share of the messages that are lost on each link, 0..1.
    threshold_m
        Error that calls for a message, where one does [m].
    """

    sender: str
    loss_ratio: float
    threshold_m: float | None = None


@dataclass(frozen=True, slots=True)
class Row:
    """Figures of a case, over all its seeds.

    Parameters
    ----------
    rate_hz
        Messages a vehicle and second [1/s].
    gap_min_m, time_gap_min_s
        Smallest gap, and smallest gap over speed [m], [s].
    growth
        Largest spacing error of the second follower and those behind, over the first's; mean over seeds. At
        most 1 is string stable.
    collisions, followers
        Followers that ran into the vehicle ahead, of how many.
    age_s
        Mean age of what was known of the vehicle ahead [s].
    """

    rate_hz: float
    gap_min_m: float
    time_gap_min_s: float
    growth: float
    collisions: int
    followers: int
    age_s: float


def drive(case: Case, *, vehicles: int, duration_s: float, seed: int) -> tuple[PlatoonTrace, int]:
    """Drive a platoon behind a leader whose speed swings; return what it drove, and how many messages.

    Parameters
    ----------
    case
        What is sent.
    vehicles
        With the leader.
    duration_s
        How long [s].
    seed
        Of senders and losses.
    """
    law, leader, platoons = PathCacc(), Sinusoid(), Platoons(1, vehicles)
    control = CruiseControl(
        platoons,
        law,
        platoon_sender(case.sender, threshold_m=case.threshold_m),
        ErasureRadio(IndependentErasure(case.loss_ratio)),
        seed=seed,
    )
    steps = round(duration_s / STEP_S)
    speeds = leader.speed_mps(np.arange(steps + 1, dtype=np.float64) * STEP_S)
    first_mps = float(speeds[0])
    frames = list[FleetFrame]()
    fell_back, ages_s = list[npt.NDArray[np.bool_]](), list[npt.NDArray[np.float64]]()
    with sumo_platoon(vehicles, float(law.gap_m(np.array(first_mps))), first_mps) as platoon:
        for step in range(steps):
            frame = platoon.frame()
            wanted = control.step(frame)
            # In the first seconds not everybody has spoken: who knows too little keeps its speed.
            unsettled = wanted.fell_back & (frame.t_s < SETTLE_S)
            platoon.drive(float(speeds[step + 1]), np.where(unsettled, 0.0, wanted.acceleration_mps2))
            frames.append(frame)
            fell_back.append(wanted.fell_back)
            ages_s.append(wanted.age_s)
    speed = np.array([frame.speed_mps for frame in frames])[:, None]
    along = np.array([frame.position_m[:, 0] for frame in frames])[:, None]
    gap = along[:, :, :-1] - along[:, :, 1:] - frames[0].length_m[1:]
    trace = PlatoonTrace(
        np.array([frame.t_s for frame in frames]),
        speed,
        np.array([frame.acceleration_mps2 for frame in frames])[:, None],
        gap_m=gap,
        too_near_m=law.gap_m(speed[:, :, 1:]) - gap,
        fell_back=np.array(fell_back)[:, None],
        age_s=np.array(ages_s)[:, None],
    )
    return trace, control.messages


def study(case: Case, *, vehicles: int, duration_s: float, seeds: int) -> tuple[Row, PlatoonTrace]:
    """Figures of a case, and what the platoon of its first seed drove.

    Parameters
    ----------
    case
        What is sent.
    vehicles, duration_s
        As for `drive`.
    seeds
        Runs.
    """
    driven = [drive(case, vehicles=vehicles, duration_s=duration_s, seed=seed) for seed in range(seeds)]
    figures = [measure_drive(trace, from_s=SETTLE_S) for trace, _ in driven]
    time_gaps = [
        (trace.gap_m / np.maximum(trace.speed_mps[:, :, 1:], 0.1))[trace.t_s >= SETTLE_S].min()
        for trace, _ in driven
    ]
    ages = [one.age_s for one in figures if one.age_s is not None]
    return Row(
        rate_hz=sum(count for _, count in driven) / (seeds * vehicles * duration_s),
        gap_min_m=min(one.gap_min_m for one in figures),
        time_gap_min_s=float(min(time_gaps)),
        growth=float(np.mean([one.spacing_amplification for one in figures])),
        collisions=sum(one.collisions for one in figures),
        followers=sum(one.followers for one in figures),
        age_s=float(np.mean(ages)) if ages else float("nan"),
    ), driven[0][0]

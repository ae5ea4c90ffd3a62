"""One pair with what is true of it, and what its host makes of a leader that it believes to move somehow."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from modelcast.apps.base import AbstractApplication
from modelcast.apps.motions import Motions
from modelcast.apps.warnings import Warnings
from modelcast.core.arrays import BoolArray, FloatArray, IntArray
from modelcast.models.point_kernels import ACCELERATION, VELOCITY_EAST, VELOCITY_NORTH, YAW_RATE
from modelcast.runtime.trip.together import placed
from modelcast.station.receiver.belief_kernels import (
    BELIEF_ACCELERATION,
    BELIEF_HEADING,
    BELIEF_SPEED,
    BELIEF_YAW_RATE,
)
from modelcast.station.sensing.sensing import sample_matrix
from modelcast.study.case import TripCase
from modelcast.study.safety.events import TrueWarnings, true_warnings
from modelcast.study.safety.pairs import FollowingPair
from modelcast.study.safety.settings import SafetySettings
from modelcast.trips.trajectory import GAP_STEPS
from modelcast.world.true_motion import true_motion

__all__ = ["SETTLE_S", "SMOOTH_S", "Scene", "assess_believed", "make_scene"]

SMOOTH_S = 0.3
"""Accelerations that are true are slopes over this long to either side [s]: brakes take as long to bite."""

SETTLE_S = 1.0
"""Instants so soon after a gap of the recording do not count [s]: in a gap a sender said nothing."""


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """A pair at the N instants at which both are recorded.

    Parameters
    ----------
    pair
        Who follows whom.
    t_s
        On the leader's clock, (N,) [s].
    host
        How the host sees itself move.
    right_host, right_remote
        What is held to be right.
    margin_m
        The application's margin by that, (N,) [m].
    counted, warned
        Which instants count, and at which a warning is right, (N,).
    true
        The warnings that are right, as events.
    """

    pair: FollowingPair
    t_s: FloatArray
    host: Motions
    right_host: Motions
    right_remote: Motions
    margin_m: FloatArray
    counted: BoolArray
    warned: BoolArray
    true: TrueWarnings


def make_scene(pair: FollowingPair, cases: Mapping[int, TripCase], settings: SafetySettings) -> Scene:
    """Set a pair out: what is right by the settings, and what the host sees of itself.

    Parameters
    ----------
    pair
        Who follows whom.
    cases
        The trips of both, made ready, by their places.
    settings
        Application, and what is held to be right.
    """
    leader, follower = cases[pair.leader], cases[pair.follower]
    seen = placed(pair.at_follower(_seen_motion(follower)), follower.truth, leader.truth)
    host, remote = _columns(seen), _seen_motion(leader)[pair.samples]
    right = host
    if settings.truth == "knowledge":
        motion = pair.at_follower(true_motion(follower.truth, smooth_s=SMOOTH_S))
        right = _columns(placed(motion, follower.truth, leader.truth))
        remote = true_motion(leader.truth, smooth_s=SMOOTH_S)[pair.samples]
    found = settings.application.assess(right, _columns(remote))
    t_s = leader.truth.t_s[pair.samples]
    settled = _since_gap_s(t_s, leader.truth.dt_s) >= SETTLE_S
    near, warned = settled & (np.abs(found.margin_m) < settings.near_m), found.warned
    true = true_warnings(warned, near, t_s, merge_s=settings.merge_s)
    return Scene(pair, t_s, host, right, _columns(remote), found.margin_m, near, warned, true)


def assess_believed(
    application: AbstractApplication, scene: Scene, motions: FloatArray, at: IntArray
) -> Warnings:
    """What the host says that believes the leader to move like this, in R runs at K instants, R times K rows.

    Parameters
    ----------
    application
        What warns.
    scene
        The pair.
    motions
        At the leader's samples, (R, T, BELIEF_COLUMNS).
    at
        Which of the scene's instants, (K,).
    """
    rows = motions[:, scene.pair.samples[at]].reshape(-1, motions.shape[2])
    own, host = np.tile(at, motions.shape[0]), scene.host
    return application.assess(
        Motions.of(
            host.position_m[own], speed_mps=host.speed_mps[own], heading_rad=host.heading_rad[own],
            acceleration_mps2=host.acceleration_mps2[own], yaw_rate_radps=host.yaw_rate_radps[own],
        ),
        Motions.of(
            rows[:, :2], speed_mps=rows[:, BELIEF_SPEED], heading_rad=rows[:, BELIEF_HEADING],
            acceleration_mps2=rows[:, BELIEF_ACCELERATION], yaw_rate_radps=rows[:, BELIEF_YAW_RATE],
        ),
    )  # fmt: skip


def _since_gap_s(t_s: FloatArray, dt_s: float) -> FloatArray:
    """Time since the last gap, infinite before the first, (N,) [s]."""
    begins = np.concatenate([[False], np.diff(t_s) > GAP_STEPS * dt_s])
    return t_s - np.maximum.accumulate(np.where(begins, t_s, -np.inf))


def _columns(motion: FloatArray) -> Motions:
    """Motions from columns of `true_motion`."""
    return Motions.of(
        motion[:, :2], speed_mps=motion[:, 2], heading_rad=motion[:, 3],
        acceleration_mps2=motion[:, 4], yaw_rate_radps=motion[:, 5],
    )  # fmt: skip


def _seen_motion(case: TripCase) -> FloatArray:
    """How a vehicle sees itself move, columns as those of `true_motion`, (T, 6)."""
    samples = sample_matrix(case.seen, case.estimator)
    east, north = samples[:, VELOCITY_EAST], samples[:, VELOCITY_NORTH]
    course = np.unwrap(np.arctan2(east, north))
    return np.column_stack(
        (samples[:, :2], np.hypot(east, north), course, samples[:, ACCELERATION], samples[:, YAW_RATE])
    )

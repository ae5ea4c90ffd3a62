"""Find out what all safety applications cost a step of 1,000 hosts with 50 remotes each, in processor time.

Peer: the forward collision warning alone as plain NumPy over the same rows (arrays of all cases, chosen by
masks); its margins must be the same. Traffic: a straight road of six lanes in two directions, crossed by
another every 400 m.
"""

import sys
import time
from collections.abc import Callable

import numpy as np

from measured import record
from modelcast.apps.forward_collision import ForwardCollisionWarning
from modelcast.apps.motions import Motions
from modelcast.apps.registry import APPLICATIONS
from modelcast.apps.warning_ranges import CampLinear
from modelcast.apps.warnings import Level
from modelcast.core.arrays import BoolArray, FloatArray

HOSTS, REMOTES = 1000, 50
ROUNDS = 25
TARGET_MS = 30.0


def main() -> int:
    """Measure and print; 1 where the target is missed or the peer differs."""
    host, remote = pairs()
    each: dict[str, float] = {}
    applications = {name: APPLICATIONS.made(name) for name in APPLICATIONS.own}
    for name, application in applications.items():
        found = application.assess(host, remote)
        each[name] = least_ms(lambda: application.assess(host, remote))  # noqa: B023 - run at once
        cautions, warnings = (int((found.level == one).sum()) for one in (Level.CAUTION, Level.WARNING))
        print(f"{name}: {each[name]:.2f} ms, {cautions} cautions, {warnings} warnings")
    every = least_ms(lambda: [one.assess(host, remote) for one in applications.values()])
    peer = least_ms(lambda: forward_collision_margins(host, remote))
    margins, own = (
        forward_collision_margins(host, remote),
        ForwardCollisionWarning().assess(host, remote).margin_m,
    )
    near = np.isfinite(margins) | np.isfinite(own)
    apart = np.abs(margins[near] - own[near]).max()
    record("all applications", every, "ms a step", sizes={"hosts": HOSTS, "remotes": REMOTES})
    record("forward collision warning alone", each["fcw"], "ms a step", peer=("plain NumPy", peer))
    print(f"all, {HOSTS} hosts x {REMOTES} remotes: {every:.2f} ms a step (target {TARGET_MS:.0f} ms)")
    print(
        f"fcw as plain NumPy: {peer:.2f} ms, {peer / each['fcw']:.1f} times the kernel's; "
        f"greatest difference of a margin {apart:.1e} m"
    )
    return int(every > TARGET_MS or not apart < 1e-9)


def pairs() -> tuple[Motions, Motions]:
    """Hosts of the road and their 50 nearest remotes, row by row, with covariances."""
    rng = np.random.default_rng(0)
    along = rng.uniform(0.0, 4000.0, HOSTS)
    crossing = rng.random(HOSTS) < 0.2
    lane = rng.integers(-3, 3, HOSTS)
    aside = 3.6 * (lane + 0.5) + rng.normal(0.0, 0.3, HOSTS)
    cross = 400.0 * rng.integers(0, 10, HOSTS)
    place = np.where(
        crossing[:, None],
        np.stack([cross + aside, rng.uniform(-150.0, 150.0, HOSTS)], axis=1),
        np.stack([along, -aside], axis=1),
    )
    heading = np.where(crossing, 0.0, np.pi / 2) + np.where(lane < 0, np.pi, 0.0)
    apart = np.linalg.norm(place[:, None] - place[None], axis=2)
    nearest = np.argsort(apart, axis=1)[:, 1 : REMOTES + 1].ravel()
    speed, gain = rng.uniform(0.0, 30.0, HOSTS), rng.normal(-0.5, 1.5, HOSTS)
    yaw_rate, covariance = rng.normal(0.0, 0.01, HOSTS), np.tile(np.diag([0.5, 0.5]), (HOSTS, 1, 1))

    def rows(which: np.ndarray) -> Motions:
        return Motions.of(
            place[which], speed_mps=speed[which], heading_rad=heading[which], acceleration_mps2=gain[which],
            yaw_rate_radps=yaw_rate[which], covariance_m2=covariance[which],
        )  # fmt: skip

    return rows(np.repeat(np.arange(HOSTS), REMOTES)), rows(nearest)


def forward_collision_margins(host: Motions, remote: Motions) -> FloatArray:
    """The margins of the forward collision warning, CAMP-Linear, as array expressions."""
    settings, algorithm = ForwardCollisionWarning(), CampLinear()
    away = remote.position_m - host.position_m
    forth = np.stack([np.sin(host.heading_rad), np.cos(host.heading_rad)], axis=1)
    ahead = (away * forth).sum(axis=1)
    right = away[:, 0] * forth[:, 1] - away[:, 1] * forth[:, 0]
    with np.errstate(all="ignore"):
        curvature = host.yaw_rate_radps / host.speed_mps
        curvature = np.where(host.speed_mps >= settings.straight_below_mps, curvature, 0.0)
        across, onward = curvature * ahead, 1.0 - curvature * right
        offset = (2.0 * right - curvature * (ahead**2 + right**2)) / (1.0 + np.hypot(across, onward))
        way = np.where(np.abs(curvature) < 1e-9, ahead, np.arctan2(across, onward) / curvature)
        turn = remote.heading_rad - host.heading_rad - curvature * way
        gap = way - (host.length_m + remote.length_m) / 2
        in_path: BoolArray = (way > 0.0) & (np.cos(turn) >= np.cos(settings.heading_tolerance_rad))
        in_path &= (gap <= settings.longest_gap_m) & (np.abs(offset) <= settings.lane_half_width_m)
        leader, delay, of = remote.speed_mps, algorithm.delay_s, algorithm.coefficients
        leader_gain = np.where(leader > 0.0, remote.acceleration_mps2, 0.0)
        late = np.maximum(host.speed_mps + host.acceleration_mps2 * delay, 0.0)
        leader_late = np.maximum(leader + leader_gain * delay, 0.0)
        faster = late - leader_late
        required = of.constant_mps2 + of.by_leader * leader_gain + of.by_moving_mps2 * (leader > 0.0)
        required += of.by_closing_per_s * np.maximum(faster, 0.0)
        pull = np.where(leader_late > 0.0, leader_gain, 0.0)
        equal_s = faster / (pull - required)
        leader_stop_s = np.where(leader_late > 0.0, np.where(pull < 0.0, leader_late / -pull, np.inf), 0.0)
        moving = (faster > 0.0) & (required < pull) & (equal_s <= leader_stop_s)
        stopped = late**2 / (-2.0 * required) - np.where(pull < 0.0, leader_late**2 / (-2.0 * pull), 0.0)
        stop_s = np.where(required < 0.0, late / -required, np.inf)
        stops = (leader_stop_s < np.inf) & (leader_stop_s <= stop_s)
        braked = np.where(moving, faster**2 / (-2.0 * (required - pull)), 0.0)
        closed = np.where(stops & ~moving, stopped, braked)
        lost = (host.speed_mps - leader) * delay
        lost += 0.5 * (host.acceleration_mps2 - leader_gain) * delay**2
        return np.where(in_path, gap - np.maximum(np.maximum(closed, 0.0) + lost, 0.0), np.inf)


def least_ms(run: Callable[[], object]) -> float:
    """Return the least processor time over rounds, since other work may run [ms]."""
    times = []
    for _ in range(ROUNDS):
        begin = time.process_time()
        run()
        times.append((time.process_time() - begin) * 1e3)
    return min(times)


if __name__ == "__main__":
    sys.exit(main())

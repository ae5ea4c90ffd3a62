"""Compiled car following: an intelligent-driver model with a constant-acceleration heuristic, and its driver.

The acceleration is the improved intelligent-driver model blended with the constant-acceleration heuristic, as
in Treiber and Kesting, Traffic Flow Dynamics (2013), chapters 11 and 12, and Kesting, Treiber and Helbing,
Phil. Trans. R. Soc. A 368 (2010) 4585, DOI 10.1098/rsta.2010.0084. The extended model EIDM of SUMO builds on
the same two. Around it a driver errs in gap and approach rate by slow random factors (the human driver model,
Treiber, Kesting and Helbing, Physica A 360 (2006) 71, DOI 10.1016/j.physa.2005.05.001), the pedal is not
quite steady, and the acceleration follows its target with a lag and a bounded jerk.
"""

from math import exp, sqrt, tanh

from modelcast.core.kernel import kernel
from modelcast.core.kernel_types import FloatMatrix

__all__ = [
    "ACCEL",
    "BRAKE",
    "DESIRED_SPEED",
    "FREE_M",
    "GAP",
    "HARDEST_MPS2",
    "HEADWAY",
    "JERK_HARD_MPS3",
    "LENGTH",
    "POLITENESS",
    "TRAITS",
    "follow",
    "follow_freely",
    "move",
    "respond",
    "wander",
    "wanted",
]

DESIRED_SPEED, HEADWAY, ACCEL, BRAKE, GAP, LENGTH, POLITENESS = range(7)
TRAITS = 7
"""Rows of the drivers' table, (TRAITS, V): v0 [m/s], T [s], a, b [m/s²], s0, length [m], politeness."""

FREE_M = 1e6
"""The gap where nobody is ahead."""

COOLNESS = 0.99  # after Kesting et al. (2010), their default
EXPONENT = 4.0
LEAST_GAP_M = 0.05
HARDEST_MPS2 = 9.0  # dry asphalt

GAP_ERROR = 0.05  # Treiber et al. (2006) take 0.05-0.1
APPROACH_ERROR_HZ = 0.01  # the same
LAG_S = 0.3
JERK_UP_MPS3 = 2.5
JERK_DOWN_MPS3 = 4.0
JERK_HARD_MPS3 = 20.0
HARD_MPS2 = 3.0
SOFT_STOP_S = 0.8


@kernel
def follow_freely(v: float, v0: float, a: float, b: float) -> float:
    """Acceleration on an empty road."""
    if v <= v0:
        x = v / v0
        x *= x
        return a * (1.0 - x * x)
    return -b * (1.0 - (v0 / v) ** (a * EXPONENT / b))


@kernel
def follow(
    v: float,
    gap: float,
    leader_v: float,
    leader_a: float,
    v0: float,
    headway: float,
    a: float,
    b: float,
    least: float,
) -> float:
    """Acceleration behind a leader; the equilibrium gap below the desired speed is s0 + v T exactly."""
    free = follow_freely(v, v0, a, b)
    if gap >= FREE_M:
        return free
    s = max(gap, LEAST_GAP_M)
    dv = v - leader_v
    z = (least + max(0.0, v * headway + v * dv / (2.0 * sqrt(a * b)))) / s
    if v <= v0:
        if z >= 1.0:
            idm = a * (1.0 - z * z)
        elif free > 1e-6:
            idm = free * (1.0 - z ** (2.0 * a / free))
        else:
            idm = 0.0
    else:
        idm = free if z < 1.0 else free + a * (1.0 - z * z)
    la = min(leader_a, a)
    below = leader_v * leader_v - 2.0 * s * la
    if leader_v * dv <= -2.0 * s * la and below > 1e-9:
        heuristic = v * v * la / below
    else:  # also behind a leader that stands, where the other form is 0 / 0
        heuristic = la - (dv * dv / (2.0 * s) if dv > 0.0 else 0.0)
    if idm >= heuristic:
        return idm
    return (1.0 - COOLNESS) * idm + COOLNESS * (heuristic + b * tanh((idm - heuristic) / b))


@kernel
def wanted(
    drivers: FloatMatrix, i: int, v: float, gap: float, leader_v: float, leader_a: float, v0: float
) -> float:
    """Acceleration of driver i behind a leader, with a desired speed of the moment."""
    return follow(
        v,
        gap,
        leader_v,
        leader_a,
        v0,
        drivers[HEADWAY, i],
        drivers[ACCEL, i],
        drivers[BRAKE, i],
        drivers[GAP, i],
    )


@kernel
def respond(v: float, a: float, target: float, gap: float, dt: float) -> float:
    """Acceleration after a step: towards the target with a lag, with bounded jerk, eased off into a stop."""
    if v < 4.0 and gap > 0.5:
        target = max(target, -v / SOFT_STOP_S - 0.05)
    target = max(target, -HARDEST_MPS2)
    change = (target - a) * (1.0 - exp(-dt / LAG_S))
    down = JERK_HARD_MPS3 if target < -HARD_MPS2 else JERK_DOWN_MPS3
    up = JERK_UP_MPS3 if a > -HARD_MPS2 else JERK_DOWN_MPS3
    if v < 4.0 and a < 0.0:
        up = JERK_HARD_MPS3  # the pedal is let go faster than it is pressed
    return a + min(max(change, -down * dt), up * dt)


@kernel
def move(v: float, a: float, a_next: float, dt: float) -> tuple[float, float, float]:
    """Distance, speed and acceleration after a step in which the acceleration changes linearly."""
    v_next = v + 0.5 * (a + a_next) * dt
    if v_next <= 0.0 or (v_next < 0.02 and a_next < 0.0):
        return 0.5 * v * dt, 0.0, 0.0
    return max(0.0, v * dt + (2.0 * a + a_next) * dt * dt / 6.0), v_next, a_next


@kernel
def wander(
    columns: FloatMatrix, row: int, i: int, clock_s: float, std_m: float, rate: float, normal: float
) -> None:
    """Advance a lane-keeping error and its two derivatives, rows `row` to `row + 2`, by a step.

    A third-order Gauss-Markov process (a Matérn process of order 5/2 with lambda = `rate`): the acceleration
    is continuous, and position and velocity are its exact integrals.
    """
    if clock_s <= 0.0:
        return
    w, w1, w2 = columns[row, i], columns[row + 1, i], columns[row + 2, i]
    drift = -(rate**3) * w - 3.0 * rate * rate * w1 - 3.0 * rate * w2
    jerk = drift + sqrt(16.0 / 3.0 * std_m * std_m * rate**5 / clock_s) * normal
    columns[row, i] = w + clock_s * (w1 + clock_s * (0.5 * w2 + clock_s * jerk / 6.0))
    columns[row + 1, i] = w1 + clock_s * (w2 + clock_s * 0.5 * jerk)
    columns[row + 2, i] = w2 + clock_s * jerk

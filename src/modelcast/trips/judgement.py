"""What a user must know of a recording before any figure made from it.

A figure computed from a bad recording looks like any other. `judge` puts in words what `inspect` measured:
one sentence a trait, each with its number. Nothing is judged that cannot be measured from the values.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from modelcast.trips.inspection import TripInspection
from modelcast.trips.trajectory import JUMPED, OFF_EARTH

__all__ = ["IMPLAUSIBLE", "LONGEST_NOISE_SPAN_S", "NOMINAL_RATE_HZ", "RATE_TOLERANCE_RATIO", "judge"]

NOMINAL_RATE_HZ = 10.0
"""The rate of basic safety messages, and of the trips that the shipped sub-models learned from."""

RATE_TOLERANCE_RATIO = 0.05
"""A rate this near to the nominal one is that: cameras and lidars run at 9.6 to 10.4 Hz."""

LONGEST_NOISE_SPAN_S = 1.25
"""Over a longer window a quadratic no longer follows a turn, and its residual is no noise [s]."""

IMPLAUSIBLE = " implausible"
"""How the reasons end that readers give for values no vehicle has."""


def judge(
    found: TripInspection, thresholds_m: Sequence[float], *, smoothed: bool = False
) -> Mapping[str, str]:
    """Warnings of one trip, by kind, gravest first; empty for an honest recording at 10 Hz.

    Parameters
    ----------
    found
        Its inspection.
    thresholds_m
        The tracking-error thresholds asked for [m].
    smoothed
        Whether truth is the smoothed recording, so that its noise is not counted as the models'.

    Returns
    -------
    Mapping[str, str]
        Of the kinds ``straight-lines``, ``extrapolated``, ``repeated``, ``jump``, ``glitch``,
        ``implausible``, ``stuck-speed``, ``noise`` and ``rate``, those that hold, each with a sentence.

    Examples
    --------
    >>> import numpy as np
    >>> from modelcast.trips.inspection import inspect
    >>> from modelcast.trips.trajectory import build_trajectory
    >>> t = np.arange(0.0, 60.0, 0.2)
    >>> list(judge(inspect(build_trajectory("made/1", t, np.stack([9.0 * t, 0.1 * t**2], axis=1))), (0.5,)))
    ['rate']
    """
    texts = {
        "straight-lines": _straight_lines(found),
        "extrapolated": _extrapolated(found),
        "repeated": _repeated(found),
        "jump": _jump(found),
        "glitch": _glitch(found),
        "implausible": _implausible(found),
        "stuck-speed": _stuck_speed(found),
        "noise": "" if smoothed else _noise(found, thresholds_m),
        "rate": _rate(found),
    }
    return {kind: text for kind, text in texts.items() if text}


def _straight_lines(found: TripInspection) -> str:
    if not found.is_joined or found.is_coasted:
        return ""
    return (
        f"positions are straight lines between fixes about {found.fix_period_s:.2g} s apart, not measured at "
        f"{found.rate_hz:.3g} Hz: between the fixes nothing is true, and figures say little of a road"
    )


def _extrapolated(found: TripInspection) -> str:
    if not found.is_coasted:
        return ""
    return (
        f"positions are the recorder's own extrapolation of fixes {found.held_s:.2g} s apart, "
        f"not measured at {found.rate_hz:.3g} Hz"
    )


def _repeated(found: TripInspection) -> str:
    if not found.position_rate_hz < 0.5 * found.rate_hz:
        return ""
    return (
        f"positions are repeated: {found.rate_hz:.3g} rows a second hold {found.position_rate_hz:.2g} new "
        "positions a second while the vehicle moves"
    )


def _jump(found: TripInspection) -> str:
    if not found.jumps:
        return ""
    times = "once" if found.jumps == 1 else f"{found.jumps} times"
    return (
        f"the position jumps {times} as no vehicle can, by up to {found.largest_jump_m:.4g} m; the trip is "
        "split there, and no window reaches across"
    )


def _glitch(found: TripInspection) -> str:
    skipped = found.reading.skipped
    counts = [f"{skipped[reason]} rows ({reason})" for reason in (OFF_EARTH, JUMPED) if skipped.get(reason)]
    if not counts:
        return ""
    return f"{' and '.join(counts)} of {found.reading.rows} lie where no vehicle could have been: left out"


def _implausible(found: TripInspection) -> str:
    counts = found.reading.repaired.items()
    named = [f"{reason} in {count} rows" for reason, count in counts if reason.endswith(IMPLAUSIBLE)]
    return f"values that no vehicle has, taken as missing: {', '.join(named)}" if named else ""


def _stuck_speed(found: TripInspection) -> str:
    if not found.speed_is_stuck:
        return ""
    return (
        f"the speed column contradicts the positions (ratio {found.speed_ratio:.3g}, rms difference "
        f"{found.speed_difference_mps:.3g} m/s) and is not used"
    )


def _noise(found: TripInspection, thresholds_m: Sequence[float]) -> str:
    """Noise over a threshold in most windows, or in some; not where the window holds a manoeuvre."""
    if found.noise_span_s > LONGEST_NOISE_SPAN_S or not np.isfinite(found.noise_p50_m):
        return ""
    for size_m, where in ((found.noise_p50_m, "most of the time"), (found.noise_p95_m, "in places (p95)")):
        below = [f"{100.0 * one:g}" for one in sorted(thresholds_m) if one < size_m]
        if below:
            return (
                f"the recording's noise is {size_m:.2g} m {where}, above the threshold of {', '.join(below)} "
                "cm: there messages are sent for the noise, and figures show it, not the motion"
            )
    return ""


def _rate(found: TripInspection) -> str:
    if abs(found.rate_hz / NOMINAL_RATE_HZ - 1.0) <= RATE_TOLERANCE_RATIO:
        return ""
    ten, usual = 9.0 / found.rate_hz, 9.0 / NOMINAL_RATE_HZ
    text = (
        f"sampled at {found.rate_hz:.3g} Hz, not {NOMINAL_RATE_HZ:g}: nothing is resampled to another rate, "
        f"windows are counted in samples (ten span {ten:.2g} s, not {usual:g} s), and at most "
        f"{found.rate_hz:.3g} messages/s can be sent"
    )
    if found.rate_hz < NOMINAL_RATE_HZ:
        text += "; errors between samples are not seen"
    return text

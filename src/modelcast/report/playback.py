"""A played trip as plain values for the page: whole numbers, thinned where the trip is long.

Every message stays. Of a long trip all samples about the manoeuvre stay; elsewhere, of every stretch, the
first sample and the one with the largest error of each run, so that no peak is cut, and as many more as keep
the vehicle within `PATH_WITHIN_M` of its true place at every instant. Between samples that were left out the
page tells no error: none was kept.
"""

from itertools import pairwise
from typing import Any

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.printable import printable
from modelcast.report.headline import sender_label
from modelcast.report.style import POLICY_COLOURS
from modelcast.station.policy.base import MessageKind
from modelcast.study.playback import Playback, PlayedRun
from modelcast.study.result import EvaluationResult
from modelcast.study.rules import FREE_RECEIVER, MODEL_SENDER
from modelcast.study.wording import centimetres

__all__ = [
    "MOST_SAMPLES",
    "PATH_WITHIN_M",
    "playback_caption",
    "playback_document",
    "playback_opening",
    "played_samples",
]

MOST_SAMPLES = 12_000
"""Trips of more samples are thinned: twenty minutes at 10 Hz."""

PATH_WITHIN_M = 0.25
"""Of a thinned trip, how far the vehicle played may be from its true place at any sample [m]."""

_ABOUT_S = 60.0
_STRETCHES = 300
_COLOURS = {
    MODEL_SENDER: POLICY_COLOURS["mbc"],
    FREE_RECEIVER: POLICY_COLOURS["free"],
    "baseline": POLICY_COLOURS["baseline"],
}
_KINDS = {MessageKind.UPDATE: "u", MessageKind.IDENTIFICATION: "i", MessageKind.KEEP_ALIVE: "k"}


def playback_document(result: EvaluationResult) -> dict[str, Any]:
    """Return what the page plays as plain values; times in ms, places in cm, errors in mm.

    Rows of numbers are differences from the number before (the first from 0), which are short; None stands
    where nothing was held. ``what`` has a letter a message, ``u`` for a model update, ``i`` for an
    identification and ``k`` for a keep-alive, ``member`` the place of its sub-model, and ``lost`` a 1 where
    it was lost. ``after_left_out`` has the samples right before which others were left out.

    Parameters
    ----------
    result
        An evaluation with a playback.

    Raises
    ------
    ValueError
        Where it has none.
    """
    playback = result.playback
    if playback is None:
        raise ValueError("the evaluation holds no playback: no trip has a manoeuvre")
    kept = played_samples(playback)
    origin_m = playback.truth_m[0]
    truth_cm = 100.0 * (playback.truth_m[kept] - origin_m)
    ratios = list(dict.fromkeys(run.packet_error_ratio for run in playback.runs))
    names = {MODEL_SENDER: sender_label(result), FREE_RECEIVER: "Free receiver", "baseline": "Baseline"}
    first = [run for run in playback.runs if run.packet_error_ratio == ratios[0]]
    return {
        "trip": printable(playback.trip),
        "threshold_m": playback.threshold_m,
        "at_s": playback.at_s,
        "t_ms": _steps(1000.0 * playback.t_s[kept]),
        "east_cm": _steps(truth_cm[:, 0]),
        "north_cm": _steps(truth_cm[:, 1]),
        "parts": np.searchsorted(kept, playback.parts).tolist(),
        "step_ms": round(1000.0 * float(np.median(np.diff(playback.t_s)))) if playback.t_s.size > 1 else 0,
        "after_left_out": (1 + np.flatnonzero(np.diff(kept) > 1)).tolist(),
        "senders": [
            {
                "name": printable(names[run.sender]),
                "colour": _COLOURS[run.sender],
                "members": [printable(name) for name in run.members],
            }
            for run in first
        ],
        "channels": [
            {
                "packet_error_ratio": ratio,
                "runs": [
                    _run(playback, run, kept) for run in playback.runs if run.packet_error_ratio == ratio
                ],
            }
            for ratio in ratios
        ],
    }


def playback_opening(result: EvaluationResult) -> str:
    """Return what to look at first, in two sentences: it opens on the channel that loses most.

    Parameters
    ----------
    result
        An evaluation with a playback.
    """
    lossy = result.playback is not None and any(run.lost.any() for run in result.playback.runs)
    after = "after a lost message" if lossy else "between two messages"
    return (
        "Grey is the vehicle; a coloured outline is where a receiver believes it to be. "
        f"Press Play and watch them drift apart {after}."
    )


def playback_caption(result: EvaluationResult) -> str:
    """Return what the playback shows, and what was left out of it.

    Parameters
    ----------
    result
        An evaluation with a playback.

    Raises
    ------
    ValueError
        Where it has none.
    """
    playback = result.playback
    if playback is None:
        raise ValueError("the evaluation holds no playback: no trip has a manoeuvre")
    ratios = sorted({run.packet_error_ratio for run in playback.runs})
    channels = "without loss" + "".join(f" and with {100 * one:.4g} % lost" for one in ratios if one > 0.0)
    kept, count = played_samples(playback).size, playback.t_s.size
    left_out = (
        "Every sample and every message is shown."
        if kept == count
        else (
            f"Every message is shown, and {kept} of {count} samples: all within {_ABOUT_S:g} s of the "
            "manoeuvre, elsewhere those with the largest errors and those that keep the path within "
            f"{centimetres(PATH_WITHIN_M)}, dots among the errors; between them no error is told."
        )
    )
    several = len({run.sender for run in playback.runs}) > 1
    return (
        f"Trip {printable(playback.trip)}, {channels}, all senders at a threshold of "
        f"{centimetres(playback.threshold_m)} and with the keep-alive of the loss runs. Grey: the true path "
        "and the vehicle; in colour: where each receiver believes it to be"
        + (", with the same losses for all" if several else "")
        + ". The axis of the errors is straight up to two thresholds and logarithmic beyond. "
        "Marks beside the path, a metre away at most, and below the errors are messages, hollow where lost. "
        f"{_beyond(playback)}{left_out} Space plays; drag to zoom the errors, click to go to a time."
    )


def _beyond(playback: Playback) -> str:
    """Say why errors pass the threshold where they do without loss."""
    lossless = [playback.error_m(run) for run in playback.runs if run.packet_error_ratio == 0.0]
    if not any((error_m > playback.threshold_m).any() for error_m in lossless):
        return ""
    return (
        "Errors are against the truth; a sender compares with what its own sensors see, so they may pass the "
        "threshold without loss too. "
    )


def played_samples(playback: Playback) -> IntArray:
    """Return which samples the page gets, rising, (K,): all of a short trip.

    Parameters
    ----------
    playback
        The trip and its runs.
    """
    count = playback.t_s.size
    if count <= MOST_SAMPLES:
        return np.arange(count)
    starts = np.linspace(0, count, _STRETCHES, endpoint=False).astype(np.int64)
    ends = np.append(starts[1:], count)
    about = np.flatnonzero(np.abs(playback.t_s - playback.at_s) <= _ABOUT_S)
    edges = np.concatenate([playback.parts, playback.parts - 1, [0, count - 1]])
    peaks = [_peaks(playback.error_m(run), starts, ends) for run in playback.runs]
    return _on_the_path(playback, np.unique(np.concatenate([starts, about, edges, *peaks])))


def _on_the_path(playback: Playback, kept: IntArray) -> IntArray:
    """Add samples until straight lines in time between neighbours stay within `PATH_WITHIN_M` of the truth.

    The sample farthest from its line is added, then both halves are looked at: D. H. Douglas, T. K. Peucker,
    Cartographica 10(2), 1973, with the distance at the same instant.
    """
    added: list[int] = []
    begins = set(playback.parts.tolist())
    open_ = [(start, end) for start, end in pairwise(kept.tolist()) if end - start > 1 and end not in begins]
    while open_:
        start, end = open_.pop()
        t_s, truth_m = playback.t_s[start : end + 1], playback.truth_m[start : end + 1]
        share = ((t_s - t_s[0]) / (t_s[-1] - t_s[0]))[:, None]
        off_m = np.hypot(*(truth_m - truth_m[0] - share * (truth_m[-1] - truth_m[0])).T)
        farthest = int(np.argmax(off_m))
        if off_m[farthest] > PATH_WITHIN_M:
            added.append(start + farthest)
            open_ += [(start, start + farthest), (start + farthest, end)]
    return np.union1d(kept, np.array(added, dtype=np.int64))


def _peaks(error_m: FloatArray, starts: IntArray, ends: IntArray) -> IntArray:
    """The sample with the largest error of each stretch."""
    known_m = np.nan_to_num(error_m, nan=-1.0)
    return np.array(
        [start + int(np.argmax(known_m[start:end])) for start, end in zip(starts, ends, strict=True)]
    )


def _run(playback: Playback, run: PlayedRun, kept: IntArray) -> dict[str, Any]:
    off_mm = 1000.0 * (run.believed_m - playback.truth_m)[kept]
    return {
        "off_east_mm": _steps(off_mm[:, 0]),
        "off_north_mm": _steps(off_mm[:, 1]),
        "sent_ms": _steps(1000.0 * playback.t_s[run.sent]),
        "what": "".join(_KINDS[MessageKind(kind)] for kind in run.kind),
        "member": run.in_use.tolist(),
        "lost": "".join("1" if lost else "0" for lost in run.lost),
    }


def _steps(values: FloatArray) -> list[int | None]:
    """Return numbers, rounded, as differences from the one before; None for NaN, which is passed over."""
    found: list[int | None] = []
    before = 0
    for value in values.tolist():
        if value != value:  # noqa: PLR0124 - NaN
            found.append(None)
            continue
        whole = round(value)
        found.append(whole - before)
        before = whole
    return found

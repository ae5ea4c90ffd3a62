"""Columns of single messages and single tracking-error samples, gathered trip by trip."""

from typing import TypeVar

import numpy as np
import numpy.typing as npt

from modelcast.runtime.trip.runtime import TripMessages
from modelcast.station.banks import BASELINE_BANK
from modelcast.station.policy.base import MessageKind
from modelcast.study.case import TripCase
from modelcast.study.rate import RateCount
from modelcast.study.result import Coded, Columns, SampleBlock
from modelcast.study.sent import sent_load
from modelcast.study.settings import EvaluationSettings
from modelcast.study.tracking import TrackingRun

__all__ = ["EventRecorder", "sample_block"]


class _Names:
    """Small integers for names, in order of first use."""

    def __init__(self) -> None:
        self._codes: dict[str, int] = {}

    def code(self, name: str) -> int:
        """The name's number."""
        return self._codes.setdefault(name, len(self._codes))

    def coded(self, parts: list[npt.NDArray[np.int32]]) -> Coded:
        """All parts as one column."""
        return Coded(_joined(parts, np.int32), tuple(self._codes))


Scalar = TypeVar("Scalar", bound=np.generic)


def _joined(parts: list[npt.NDArray[Scalar]], kind: type[Scalar]) -> npt.NDArray[Scalar]:
    return np.concatenate(parts) if parts else np.empty(0, dtype=kind)


class EventRecorder:
    """Messages of the rate runs: trip, policy, bank, threshold, time, kind, sub-model, size and airtime.

    Parameters
    ----------
    settings
        Sizes and bank.
    """

    def __init__(self, settings: EvaluationSettings) -> None:
        self._settings = settings
        self._coded = {name: _Names() for name in ("trip", "policy", "bank", "kind", "sub_model")}
        self._codes: dict[str, list[npt.NDArray[np.int32]]] = {name: [] for name in self._coded}
        self._numbers: dict[str, list[npt.NDArray[np.float64]]] = {
            "threshold_m": [],
            "t_s": [],
            "airtime_s": [],
        }
        self._bytes: list[npt.NDArray[np.int32]] = []

    def add(self, case: TripCase, count: RateCount, walk: TripMessages) -> None:
        """Record the messages of one walk.

        Parameters
        ----------
        case
            The trip.
        count
            Names the policy, bank and threshold.
        walk
            What was sent.
        """
        given = BASELINE_BANK if count.policy == "baseline" else self._settings.bank
        bank = given.complete()
        sent = sent_load(walk, bank, case.truth.t_s, self._settings)
        at = sent.at
        members = tuple(member.name for member in bank.members)
        for name, value in (
            ("trip", case.truth.trip_id),
            ("policy", count.policy),
            ("bank", count.bank),
        ):
            self._codes[name].append(np.full(at.size, self._coded[name].code(value), dtype=np.int32))
        kinds = np.array([self._coded["kind"].code(kind.label) for kind in MessageKind], dtype=np.int32)
        used = np.array([self._coded["sub_model"].code(name) for name in members], dtype=np.int32)
        self._codes["kind"].append(kinds[walk.kind[at]])
        self._codes["sub_model"].append(used[walk.in_use[at]])
        self._numbers["threshold_m"].append(np.full(at.size, count.threshold_m))
        self._numbers["t_s"].append(case.truth.t_s[at])
        self._numbers["airtime_s"].append(sent.airtime_s)
        self._bytes.append(sent.size_bytes.astype(np.int32))

    def columns(self) -> Columns:
        """Everything recorded so far."""
        coded = {name: names.coded(self._codes[name]) for name, names in self._coded.items()}
        numbers = {name: _joined(parts, np.float64) for name, parts in self._numbers.items()}
        return {**coded, **numbers, "size_bytes": _joined(self._bytes, np.int32)}


_ERRORS = {
    "tracking_error_m": "after_m",
    "tracking_error_before_m": "before_m",
    "along_track_m": "along_m",
    "cross_track_m": "cross_m",
    "information_age_s": "age_s",
}


def sample_block(case: TripCase, run: TrackingRun, settings: EvaluationSettings) -> SampleBlock | None:
    """The tracking-error samples to keep of one run: of the first seed, all seeds, or none.

    Parameters
    ----------
    case
        The trip.
    run
        One contender's errors over it.
    settings
        Whose samples are kept.
    """
    kept = {"first": 1, "all": settings.seeds, "none": 0}[settings.keep_samples]
    if kept == 0:
        return None
    return SampleBlock(
        case.truth.trip_id,
        run.contender.policy,
        run.contender.bank,
        run.contender.rate_basis,
        run.contender.threshold_m,
        settings.packet_error_ratios,
        case.truth.t_s,
        {name: getattr(run, field)[:, :kept].copy() for name, field in _ERRORS.items()},
    )

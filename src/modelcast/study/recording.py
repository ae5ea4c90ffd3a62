"""Columns of single messages and single tracking-error samples of one trip, and who takes them.

They grow with the driving, by far the most of what an evaluation finds. So each trip's go to an
`AbstractRecordSink` as soon as they are there: kept in memory (`HeldRecords`), or written to files.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from modelcast.runtime.trip.runtime import TripMessages
from modelcast.station.banks import BASELINE_BANK
from modelcast.station.policy.base import MessageKind
from modelcast.study.case import TripCase
from modelcast.study.rate import RateCount
from modelcast.study.result import Coded, Columns, SampleBlock
from modelcast.study.rules import FREE_RECEIVER
from modelcast.study.sent import sent_load
from modelcast.study.settings import EvaluationSettings
from modelcast.study.tracking import TrackingRun

__all__ = ["AbstractRecordSink", "HeldRecords", "event_columns", "joined_columns", "sample_block"]


class AbstractRecordSink(ABC):
    """Takes the messages and the tracking-error samples of an evaluation, trip after trip."""

    @abstractmethod
    def add_events(self, columns: Columns) -> None:
        """Take the messages of one walk.

        Parameters
        ----------
        columns
            The columns of `EvaluationResult.events` by name, all of one length.
        """

    @abstractmethod
    def add_samples(self, block: SampleBlock) -> None:
        """Take the samples of one contender over one trip.

        Parameters
        ----------
        block
            Its samples, a row each.
        """


class HeldRecords(AbstractRecordSink):
    """Keeps everything in memory: about 240 MB an hour of driving at the defaults."""

    def __init__(self) -> None:
        self._events: list[Columns] = []
        self._samples: list[SampleBlock] = []

    def add_events(self, columns: Columns) -> None:
        """Keep them."""
        self._events.append(columns)

    def add_samples(self, block: SampleBlock) -> None:
        """Keep it."""
        self._samples.append(block)

    @property
    def events(self) -> Columns:
        """All messages so far."""
        return joined_columns(self._events)

    @property
    def samples(self) -> tuple[SampleBlock, ...]:
        """All blocks so far."""
        return tuple(self._samples)


_TEXT = ("trip", "policy", "bank", "kind", "sub_model")
_NUMBERS: dict[str, npt.DTypeLike] = {
    "threshold_m": np.float64,
    "t_s": np.float64,
    "airtime_s": np.float64,
    "size_bytes": np.int32,
}


def joined_columns(parts: Sequence[Columns]) -> Columns:
    """The columns of messages of several walks as one.

    Parameters
    ----------
    parts
        As `event_columns` gives them; none gives columns without rows.
    """
    joined: dict[str, Any] = {name: _joined_names([part[name] for part in parts]) for name in _TEXT}
    for name, kind in _NUMBERS.items():
        columns: list[Any] = [np.empty(0, kind), *(part[name] for part in parts)]
        joined[name] = np.concatenate(columns, dtype=kind)
    return joined


def _joined_names(parts: Sequence[Any]) -> Coded:
    codes: dict[str, int] = {}
    found: list[npt.NDArray[np.int32]] = [np.empty(0, np.int32)]
    for part in parts:
        own = np.array([codes.setdefault(name, len(codes)) for name in part.names], dtype=np.int32)
        found.append(own[part.codes])
    return Coded(np.concatenate(found), tuple(codes))


def event_columns(
    case: TripCase, count: RateCount, walk: TripMessages, settings: EvaluationSettings
) -> Columns:
    """The messages of one walk: trip, policy, bank, kind, sub-model, threshold, time, airtime and size.

    Parameters
    ----------
    case
        The trip.
    count
        Names the policy, bank and threshold.
    walk
        What was sent.
    settings
        Sizes and bank.
    """
    rivals = {"baseline": BASELINE_BANK, FREE_RECEIVER: settings.rival}
    bank = (rivals.get(count.policy) or settings.bank).complete()
    sent = sent_load(walk, bank, case.truth.t_s, settings)
    at = sent.at
    same = np.zeros(at.size, dtype=np.int32)
    return {
        "trip": Coded(same, (case.truth.trip_id,)),
        "policy": Coded(same, (count.policy,)),
        "bank": Coded(same, (count.bank,)),
        "kind": Coded(walk.kind[at].astype(np.int32), tuple(kind.label for kind in MessageKind)),
        "sub_model": Coded(walk.in_use[at].astype(np.int32), tuple(member.name for member in bank.members)),
        "threshold_m": np.full(at.size, count.threshold_m),
        "t_s": case.truth.t_s[at],
        "airtime_s": sent.airtime_s,
        "size_bytes": sent.size_bytes.astype(np.int32),
    }


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

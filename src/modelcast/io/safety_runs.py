"""Scores of single recordings on disk, so that a later call of ``modelcast safety`` takes them up again.

``<recording>_<sensor>_<losses>-<key>.json`` holds one: ``schema``, ``modelcast`` (version), ``options`` and
the scores. The key is a hash of version, options, the recording's trips, the banks, and the log whose losses
are replayed: of anything else the file has another name. What is read back is checked before it is used, for
the folder may come from anywhere.
"""

import hashlib
import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf, isinf
from pathlib import Path
from typing import Any, cast

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.core.exceptions import ConfigError
from modelcast.core.json_text import parse_json, schema_of
from modelcast.core.rules import Anything, Each, Fixed, Keys, Maybe, Number, Text, Whole, check
from modelcast.io.regular import read_document
from modelcast.io.run_store import AbstractRunFiles, write_run_file, written_inputs
from modelcast.study.safety.result import ConditionScores, PairNames, RecordingScores, SenderSpend
from modelcast.study.safety.rules import BASES

__all__ = ["SAFETY_RUN_SCHEMA", "SafetyCase", "SafetyRunFiles", "scores_document"]

SAFETY_RUN_SCHEMA = 2
"""Version of the layout of a recording's file; since 2 it names the log whose losses were replayed."""

_MOST = 1_000_000
_COUNT = Whole(0, 2**53)
_TIME = Number(0.0, 1e12)
_RUNS = Each(Each(_COUNT, 1, _MOST), 0, _MOST)
_CONDITION = Keys(
    {
        "candidate": Text(200),
        "basis": Text(20, choices=BASES),
        "packet_error_ratio": Number(0.0, 1.0),
        "messages": _COUNT,
        "airtime_s": _TIME,
        "thresholds_m": Each(Number(0.0, 1e6), 1, _MOST),
        "missed": _RUNS,
        "delay_s": Each(Each(Maybe(_TIME), 1, _MOST), 0, _MOST),
        "false": _RUNS,
        "false_warnings": _RUNS,
    }
)
_RECORDING = Keys(
    {
        "name": Text(400),
        "sensor": Text(100, empty=True),
        "mean_burst_s": Maybe(_TIME),
        "loss_log": Text(400, empty=True),
        "pairs": Each(Fixed((Text(1000), Text(1000), _TIME)), 1, _MOST),
        "counted": Each(_COUNT, 1, _MOST),
        "negatives": Each(_COUNT, 1, _MOST),
        "duration_s": Each(_TIME, 1, _MOST),
        "leaders_s": _TIME,
        "event_pair": Each(_COUNT, 0, _MOST),
        "event_s": Each(Number(-1e12, 1e12), 0, _MOST),
        "positives": Each(_COUNT, 0, _MOST),
        "conditions": Each(_CONDITION, 1, _MOST),
    }
)
_DOCUMENT = Keys({"schema": Anything(), "modelcast": Text(100), "options": Anything(), "scores": _RECORDING})


@dataclass(frozen=True, slots=True)
class SafetyCase:
    """One recording with one sensor and kind of loss.

    Parameters
    ----------
    recording
        Name of the recording.
    sensor, mean_burst_s
        As in `RecordingScores`.
    trips
        Fingerprints of its trips.
    loss_log, loss_sha256
        The log whose losses are replayed, and the SHA-256 of its content; empty where they are drawn.
    """

    recording: str
    sensor: str
    mean_burst_s: float | None
    trips: tuple[str, ...]
    loss_log: str = ""
    loss_sha256: str = ""


@dataclass(frozen=True, slots=True)
class SafetyRunFiles(AbstractRunFiles[SafetyCase, RecordingScores]):
    """Recordings of ``modelcast safety``.

    Parameters
    ----------
    version
        Of modelcast.
    options
        What all are scored with, as plain values; banks by a hash of what they are.
    """

    version: str
    options: Mapping[str, Any]

    def path(self, case: SafetyCase, folder: Path) -> Path:
        """Where a recording's scores are."""
        burst = "single" if case.mean_burst_s is None else f"{case.mean_burst_s:g}s"
        depends = [SAFETY_RUN_SCHEMA, self.version, self.options, case.trips, case.loss_sha256]
        words = json.dumps(depends, sort_keys=True)
        key = hashlib.sha256(words.encode()).hexdigest()[:12]
        name = f"{case.recording}_{case.sensor}_{case.loss_log or burst}"
        name = re.sub(r"[^A-Za-z0-9._-]+", "_", name)[:120]
        return folder / f"{name}-{key}.json"

    def read(self, case: SafetyCase, folder: Path) -> RecordingScores | None:
        """Return the scores of a recording, None where there are none."""
        path = self.path(case, folder)
        if not path.is_file():
            return None
        document = _document(path)
        try:
            found = _scores(document["scores"])
        except ValueError as error:
            raise _refused(path, error) from error
        wanted = (case.recording, case.sensor, case.mean_burst_s, case.loss_log)
        if (found.name, *found.kind) != wanted:
            raise ConfigError(f"{path} is of another recording, sensor or kind of loss: remove it")
        return found

    def inputs(self, case: SafetyCase) -> Mapping[str, str]:  # noqa: ARG002 - the same for all
        """The version of modelcast, the files' hashes, and what other packages bring."""
        return {"modelcast": self.version, **self.options["files"]}

    def inputs_in(self, path: Path) -> Mapping[str, str]:
        """As `inputs`."""
        document = _document(path)
        options: Any = document["options"]
        files = cast("dict[str, Any]", options).get("files") if isinstance(options, dict) else None
        return written_inputs(path, document["modelcast"], files)

    def write(self, case: SafetyCase, result: RecordingScores, folder: Path) -> None:
        """Write the scores of a recording; the file appears whole or not at all."""
        document = {
            "schema": SAFETY_RUN_SCHEMA,
            "modelcast": self.version,
            "options": dict(self.options),
            "scores": scores_document(result),
        }
        write_run_file(document, self.path(case, folder))


def _document(path: Path) -> Mapping[str, Any]:
    """The checked content of a recording's file."""
    try:
        document: Any = parse_json(read_document(path))
        check(document, _DOCUMENT)
        _ = schema_of(document, SAFETY_RUN_SCHEMA)
    except ValueError as error:
        raise _refused(path, error) from error
    return document


def _refused(path: Path, error: Exception) -> ConfigError:
    return ConfigError(f"{path} is not a run of modelcast safety: {error}: remove it")


def scores_document(scores: RecordingScores) -> dict[str, Any]:
    """Scores as plain values; a warning that never came has no delay.

    Parameters
    ----------
    scores
        Of one recording.
    """
    return {
        "name": scores.name,
        "sensor": scores.sensor,
        "mean_burst_s": scores.mean_burst_s,
        "loss_log": scores.loss_log,
        "pairs": [[pair.leader, pair.follower, pair.headway_s] for pair in scores.pairs],
        **{
            name: getattr(scores, name).tolist()
            for name in ("counted", "negatives", "duration_s", "event_pair", "event_s", "positives")
        },
        "leaders_s": scores.leaders_s,
        "conditions": [
            {
                "candidate": one.candidate,
                "basis": one.basis,
                "packet_error_ratio": one.packet_error_ratio,
                "messages": one.spend.messages,
                "airtime_s": one.spend.airtime_s,
                "thresholds_m": list(one.spend.thresholds_m),
                "missed": one.missed.tolist(),
                "delay_s": [[None if isinf(late) else late for late in row] for row in one.delay_s.tolist()],
                "false": one.false.tolist(),
                "false_warnings": one.false_warnings.tolist(),
            }
            for one in scores.conditions
        ],
    }


def _scores(given: Mapping[str, Any]) -> RecordingScores:
    """Scores from a checked document.

    Raises
    ------
    ValueError
        Where lengths do not agree.
    """
    pairs = [PairNames(*pair) for pair in given["pairs"]]
    count, events = len(pairs), len(given["positives"])
    for name, wanted in (
        ("counted", count), ("negatives", count), ("duration_s", count),
        ("event_pair", events), ("event_s", events),
    ):  # fmt: skip
        if len(given[name]) != wanted:
            raise ValueError(f"{name} has {len(given[name])} values, expected {wanted}")
    runs = {len(row) for one in given["conditions"] for row in one["false"]}
    if len(runs) != 1:
        raise ValueError(f"false has rows of {sorted(runs)} runs, expected one length")
    (k,) = runs
    return RecordingScores(
        given["name"],
        given["sensor"],
        given["mean_burst_s"],
        pairs=pairs,
        counted=_whole(given["counted"]),
        negatives=_whole(given["negatives"]),
        duration_s=np.array(given["duration_s"], dtype=np.float64),
        leaders_s=given["leaders_s"],
        event_pair=_whole(given["event_pair"]),
        event_s=np.array(given["event_s"], dtype=np.float64),
        positives=_whole(given["positives"]),
        conditions=[_condition(one, count, events, k) for one in given["conditions"]],
        loss_log=given["loss_log"],
    )


def _condition(given: Mapping[str, Any], pairs: int, events: int, runs: int) -> ConditionScores:
    late = [[inf if value is None else value for value in row] for row in given["delay_s"]]
    for name in ("missed", "delay_s", "false_warnings"):
        if any(len(row) != runs for row in given[name]):
            raise ValueError(f"{name} must have rows of {runs} runs")
    missed, delay_s = _whole(given["missed"]).reshape(-1, runs), _table(late, runs)
    false, false_warnings = _whole(given["false"]), _whole(given["false_warnings"])
    for name, shape, wanted in (
        ("missed", missed.shape, events),
        ("delay_s", delay_s.shape, events),
        ("false", false.shape, pairs),
        ("false_warnings", false_warnings.shape, pairs),
    ):
        if shape != (wanted, runs):
            raise ValueError(f"{name} must have shape {(wanted, runs)}, got {shape}")
    return ConditionScores(
        given["candidate"],
        given["basis"],
        given["packet_error_ratio"],
        spend=SenderSpend(given["messages"], given["airtime_s"], tuple(given["thresholds_m"])),
        missed=missed,
        delay_s=delay_s,
        false=false,
        false_warnings=false_warnings,
    )


def _whole(values: Sequence[Any]) -> IntArray:
    return np.array(values, dtype=np.int64)


def _table(rows: Sequence[Sequence[float]], columns: int) -> FloatArray:
    return np.array(rows, dtype=np.float64).reshape(-1, columns)

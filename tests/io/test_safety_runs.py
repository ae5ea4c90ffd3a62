"""Scores of recordings on disk: what is written is read again, and nothing else is."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from modelcast.core.exceptions import ConfigError
from modelcast.io.run_store import run_store
from modelcast.io.safety_runs import SafetyCase, SafetyRunFiles, scores_document
from modelcast.study.safety.result import ConditionScores, PairNames, RecordingScores, SenderSpend

CASE = SafetyCase("made/b", "default", 0.5, ("ab", "cd"))
LOGGED = SafetyCase("made/b", "default", 0.5, ("ab", "cd"), "rx.csv", "ef01")
FILES = SafetyRunFiles("1.0", {"threshold": 0.2})


def scores() -> RecordingScores:
    """Two warnings of one pair in three runs, one of which never came."""
    return RecordingScores(
        "made/b", "default", 0.5,
        pairs=[PairNames("made/b", "made/c", 1.5)], counted=np.array([90]), negatives=np.array([70]),
        duration_s=np.array([60.0]), leaders_s=60.0, event_pair=np.array([0, 0]),
        event_s=np.array([10.0, 30.5]), positives=np.array([12, 8]),
        conditions=[
            ConditionScores(
                "cv", "airtime", 0.4, spend=SenderSpend(55, 0.02, (0.31,)),
                missed=np.array([[1, 2, 3], [0, 8, 1]]),
                delay_s=np.array([[0.1, 0.2, 0.3], [0.0, np.inf, 0.1]]),
                false=np.array([[4, 0, 1]]), false_warnings=np.array([[1, 0, 1]]),
            )
        ],
    )  # fmt: skip


def test_what_is_written_is_read_again(tmp_path: Path) -> None:
    FILES.write(CASE, scores(), tmp_path)
    found = FILES.read(CASE, tmp_path)
    assert found is not None
    assert scores_document(found) == scores_document(scores())
    assert np.isinf(found.conditions[0].delay_s[1, 1])


@pytest.mark.parametrize(
    ("files", "case"),
    [
        (SafetyRunFiles("1.1", FILES.options), CASE),
        (SafetyRunFiles("1.0", {"threshold": 0.5}), CASE),
        (FILES, SafetyCase("made/b", "default", 0.5, ("ab", "ef"))),
        (FILES, SafetyCase("made/b", "gnss", 0.5, ("ab", "cd"))),
        (FILES, SafetyCase("made/b", "default", None, ("ab", "cd"))),
        (FILES, LOGGED),
    ],
)
def test_scores_of_anything_else_are_not_taken(
    tmp_path: Path, files: SafetyRunFiles, case: SafetyCase
) -> None:
    FILES.write(CASE, scores(), tmp_path)
    assert files.read(case, tmp_path) is None


def test_scores_under_replayed_losses_are_those_of_the_log_s_content(tmp_path: Path) -> None:
    logged = replace(scores(), loss_log="rx.csv")
    FILES.write(LOGGED, logged, tmp_path)
    found = FILES.read(LOGGED, tmp_path)
    assert found is not None
    assert found.kind == logged.kind == ("default", 0.5, "rx.csv")
    assert FILES.read(CASE, tmp_path) is None
    assert FILES.read(replace(LOGGED, loss_sha256="ef02"), tmp_path) is None


@pytest.mark.parametrize(
    ("place", "value", "told"),
    [
        (("positives",), [12], "positives|event_pair"),
        (("counted",), [1, 2], "counted"),
        (("conditions", 0, "missed"), [[1, 2], [0, 8]], "missed"),
        (("conditions", 0, "packet_error_ratio"), 1.5, "packet_error_ratio"),
        (("conditions", 0, "basis"), "bytes", "basis"),
        (("conditions", 0, "delay_s"), [[-1.0, 0.2, 0.3], [0.0, 0.1, 0.1]], "delay_s"),
        (("name",), "other", "another recording"),
        (("loss_log",), "rx.csv", "another recording"),
        (("loss_log",), None, "loss_log"),
    ],
)
def test_damaged_files_are_named(
    tmp_path: Path, place: tuple[str | int, ...], value: object, told: str
) -> None:
    FILES.write(CASE, scores(), tmp_path)
    path = FILES.path(CASE, tmp_path)
    document = json.loads(path.read_text())
    at = document["scores"]
    for step in place[:-1]:
        at = at[step]
    at[place[-1]] = value
    path.write_text(json.dumps(document))
    with pytest.raises(ConfigError, match=told) as raised:
        FILES.read(CASE, tmp_path)
    assert str(path) in str(raised.value)


def test_why_scores_are_not_taken_up_is_told(tmp_path: Path) -> None:
    old, new = (
        SafetyRunFiles("1.0", {"files": {"mine.json": one * 64, "policy slow": f"slow {one}"}})
        for one in "12"
    )
    (tmp_path / "out").mkdir()
    with run_store(tmp_path / "out", old, command="safety") as store:
        store.publish({CASE: scores()}, tmp_path / "out")
        assert store.outdated([CASE, LOGGED]) == []
    with run_store(tmp_path / "out", new, command="safety") as store:
        assert store.outdated([CASE, LOGGED]) == [
            "1 run is not taken up again: mine.json has changed; policy slow was slow 1, is slow 2"
        ]

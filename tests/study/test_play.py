"""Claims: what is played of a trip is what was evaluated of it, message by message and sample by sample."""

from dataclasses import replace

import numpy as np
import pytest

from modelcast.station.banks import bank_from_text, free_bank
from modelcast.study.case import SensedTrip
from modelcast.study.evaluate import evaluate
from modelcast.study.playback import Playback
from modelcast.study.result import EvaluationResult
from modelcast.study.settings import EvaluationSettings
from modelcast.world.drive import generate_drive

SETTINGS = EvaluationSettings(
    (0.3, 0.5), (0.0, 0.2, 0.4), seeds=2, bank=bank_from_text("ctra+cv"), references=False
)
SINGLE_M = 1e-5
"""Samples are kept in single precision: errors to some metres differ by less."""


def _result(settings: EvaluationSettings) -> EvaluationResult:
    drive = generate_drive(seed=3, duration_s=90.0)
    return evaluate([SensedTrip(drive.truth, drive.input)], settings)


def _played(result: EvaluationResult) -> Playback:
    assert result.playback is not None
    return result.playback


@pytest.fixture(scope="module")
def result() -> EvaluationResult:
    """A generated drive as its sender sees it."""
    return _result(SETTINGS)


def test_errors_played_are_those_of_the_first_seed(result: EvaluationResult) -> None:
    playback = _played(result)
    compared = 0
    for run in playback.runs:
        for block in result.samples:
            if (block.policy, block.threshold_m) != (run.sender, playback.threshold_m):
                continue
            row = block.packet_error_ratios.index(run.packet_error_ratio)
            np.testing.assert_allclose(
                playback.error_m(run), block.errors["tracking_error_m"][row, 0], atol=SINGLE_M
            )
            compared += 1
    assert compared == 6  # mbc, free and baseline, on two channels


def test_three_senders_meet_a_channel_without_loss_and_one_with(result: EvaluationResult) -> None:
    playback = _played(result)
    assert [(run.sender, run.packet_error_ratio) for run in playback.runs] == [
        (sender, ratio) for ratio in (0.0, 0.4) for sender in ("mbc", "free", "baseline")
    ]
    for run in playback.runs:
        assert run.lost.any() == (run.packet_error_ratio > 0.0)
        assert run.sent[0] == 0
        assert not run.lost[0]
        silent_s = np.diff(playback.t_s[run.sent])
        assert silent_s.max() <= 2.0 + 0.1 + 1e-9  # the keep-alive of the loss runs, and a sample


def test_where_messages_are_the_belief_jumps(result: EvaluationResult) -> None:
    """Between messages that arrive, a belief moves smoothly: what is played as a message is one."""
    run = next(one for one in _played(result).runs if one.sender == "baseline")
    step_m = np.diff(run.believed_m, axis=0)
    bend_m = np.hypot(*np.diff(step_m, axis=0).T)
    heard = set(run.sent[~run.lost].tolist())
    # A coasted place goes on by the same step; the two bends about a message are its own.
    quiet = [at for at in range(bend_m.size) if not heard & {at + 1, at + 2}]
    assert len(quiet) > 100
    assert bend_m[quiet].max() < 1e-6


def test_a_free_sender_is_not_played_twice() -> None:
    own = replace(SETTINGS, bank=free_bank(), packet_error_ratios=())
    assert [run.sender for run in _played(_result(own)).runs] == ["mbc", "baseline"]

"""Claims about the free receiver that an evaluation holds MBC against."""

from dataclasses import replace

import pytest

from modelcast.models.profile import people_profile
from modelcast.station.banks import BASELINE_BANK, PAPER_BANK, free_bank, free_receiver
from modelcast.study.evaluate import evaluate
from modelcast.study.result import EvaluationResult
from modelcast.study.settings import EvaluationSettings
from modelcast.study.table import Row
from modelcast.trips.fingerprint import fingerprint
from modelcast.trips.trajectory import Trajectory
from modelcast.world.drive import generate_drive

SETTINGS = EvaluationSettings((0.3,), (0.0, 0.4), seeds=2, references=False, keep_samples="none")
RATE_GRAIN = 0.02
"""A message more or less of a hundred, and as much for the steps of the bisection."""


@pytest.fixture(scope="module", name="drive")
def _drive() -> Trajectory:
    return generate_drive(seed=3, duration_s=150.0).input


@pytest.fixture(scope="module", name="found")
def _found(drive: Trajectory) -> EvaluationResult:
    return evaluate([drive], SETTINGS)


def figures(row: Row) -> dict[str, object]:
    """A row without who it is."""
    return {name: value for name, value in row.items() if name not in {"policy", "bank", "own_threshold_m"}}


def test_its_rows_are_those_of_its_bank_run_alone(drive: Trajectory, found: EvaluationResult) -> None:
    """By the same rules, so that what is left between it and MBC is the sub-models."""
    alone = evaluate([drive], replace(SETTINGS, bank=free_bank(), believe=SETTINGS.belief))
    assert not [row for row in (*alone.rates, *alone.tracking) if row.policy.startswith("free")]
    for ours, theirs in ((found.rates, alone.rates), (found.tracking, alone.tracking)):
        beside = [figures(row) for row in ours if row.policy == "free"]
        assert beside
        assert beside == [figures(row) for row in theirs if row.policy == "mbc"]


def test_it_is_a_plain_message(found: EvaluationResult) -> None:
    for row in found.rates:
        if row.policy in {"free", "baseline"}:
            assert row.bytes_per_s == pytest.approx(40.0 * row.total_rate_hz)


def test_at_equal_rate_it_sends_as_many_messages_at_every_loss_ratio(found: EvaluationResult) -> None:
    rates_hz = {
        (row.trip, row.packet_error_ratio): row.message_rate_hz
        for row in found.tracking
        if row.policy == "mbc"
    }
    matched = [row for row in found.tracking if row.policy == "free-matched"]
    assert {row.rate_basis for row in matched} == {"update", "total"}
    for row in matched:
        wanted_hz = rates_hz[row.trip, row.packet_error_ratio]
        assert row.message_rate_hz == pytest.approx(wanted_hz, rel=RATE_GRAIN)


def test_a_loss_ratio_alone_gives_the_same_errors(drive: Trajectory, found: EvaluationResult) -> None:
    """The sender expects the losses of its own run, whatever others are run."""
    alone = evaluate([drive], replace(SETTINGS, packet_error_ratios=(0.4,)))
    rows, others = (
        [row for row in one.tracking if row.policy == "free-matched" and row.packet_error_ratio == 0.4]
        for one in (alone, found)
    )
    assert rows
    assert rows == others


def test_a_basis_that_counts_other_messages_is_run_apart(drive: Trajectory) -> None:
    settings = replace(SETTINGS, bank=PAPER_BANK, packet_error_ratios=(0.4,))
    rows = {
        row.rate_basis: row
        for row in evaluate([drive], settings).tracking
        if row.policy == "free-matched" and row.trip == drive.trip_id
    }
    assert rows["update"].message_rate_hz < rows["total"].message_rate_hz
    assert rows["update"].own_threshold_m > rows["total"].own_threshold_m


@pytest.mark.parametrize("free", [None, BASELINE_BANK])
def test_it_is_not_run_where_it_is_not_asked_for_nor_beside_itself(drive: Trajectory, free: object) -> None:
    settings = replace(SETTINGS, bank=BASELINE_BANK, free=free, packet_error_ratios=())
    assert {row.policy for row in evaluate([drive], settings).rates} == {"mbc", "baseline"}
    assert settings.as_plain()["free"] is None


def test_people_are_held_against_what_coasts_people() -> None:
    bank = free_receiver(people_profile()).bank
    assert (bank.name, [member.name for member in bank.members]) == ("free", ["stop-and-go"])


def test_a_trip_that_it_was_trained_on_is_told(drive: Trajectory) -> None:
    """Whoever's bank is judged: its figures flatter the rival."""
    learnt = replace(
        SETTINGS,
        bank=BASELINE_BANK,
        packet_error_ratios=(),
        free_trained_on=frozenset({fingerprint(drive)}),
    )
    assert evaluate([drive], learnt).trips[0].in_training
    assert not evaluate([drive], replace(learnt, free=None)).trips[0].in_training

"""A study of platoons: figures of drives made by hand, and what a run compares."""

from dataclasses import replace

import numpy as np
import pytest

from modelcast.channel.erasure import GilbertElliott, Ideal, IndependentErasure
from modelcast.runtime.platoon.drive import DriveSettings, PlatoonTrace
from modelcast.station.policy.periodic import Periodic
from modelcast.study.cruise.measure import measure_drive, speed_change_ratio
from modelcast.study.cruise.run import PERFECT, run_cruise
from modelcast.study.cruise.senders import platoon_sender
from modelcast.study.cruise.settings import CruiseSettings, Loss

SMALL = CruiseSettings(
    senders=("bsm-10hz", "free"),
    thresholds_m=(0.05, 0.5),
    losses=(Loss(0.0), Loss(0.5)),
    platoons=2,
    vehicles=3,
    drive=DriveSettings(duration_s=15.0),
)

PEAKS_RATIO = 1e-3
"""Frames need not fall on the top of a swing."""


def trace(swings: np.ndarray, errors: np.ndarray) -> PlatoonTrace:
    """Return platoons whose speeds and spacing errors swing by (B, N) and (B, N - 1), -2 s to 20 s."""
    t_s = np.arange(-20, 200) * 0.1
    wave = np.sin(2.0 * np.pi * 0.5 * t_s)[:, None, None]
    too_near = wave * errors
    age_s = np.full(too_near.shape, 0.2)
    age_s[t_s < 10.0] = np.nan
    return PlatoonTrace(
        t_s,
        20.0 + wave * swings,
        np.gradient(wave, t_s, axis=0) * swings,
        gap_m=5.0 - too_near,
        too_near_m=too_near,
        fell_back=np.isnan(age_s),
        age_s=age_s,
    )


def test_figures_are_those_of_a_drive_made_by_hand() -> None:
    """Peaks along two platoons: speeds grow by 1.5 and by half, errors by 3 and by half; one collides."""
    swings = np.array([[1.0, 1.5, 1.2], [2.0, 1.0, 1.0]])
    errors = np.array([[2.0, 6.0], [2.0, 1.0]])
    found = measure_drive(trace(swings, errors), from_s=0.0)
    assert found.speed_amplification == pytest.approx((1.5 + 0.5) / 2.0, rel=PEAKS_RATIO)
    assert found.spacing_amplification == pytest.approx((3.0 + 0.5) / 2.0)
    assert found.stable_ratio == 0.5
    assert found.spacing_peak_m == pytest.approx((6.0 + 2.0) / 2.0, rel=0.06)
    assert found.gap_min_m == pytest.approx(5.0 - 6.0, rel=0.3)
    assert (found.collisions, found.followers) == (1, 4)
    assert found.spacing_rms_m == pytest.approx(np.sqrt(np.mean(errors**2) / 2.0), rel=PEAKS_RATIO)
    rates = np.pi * np.sqrt(np.mean(swings[:, 1:] ** 2) / 2.0)
    assert found.acceleration_rms_mps2 == pytest.approx(rates, rel=0.03)
    assert found.jerk_rms_mps3 == pytest.approx(np.pi * rates, rel=0.05)
    assert found.fell_back_ratio == 0.5
    assert found.age_s == pytest.approx(0.2)


def test_where_nothing_swings_nothing_grows() -> None:
    found = measure_drive(trace(np.zeros((1, 3)), np.zeros((1, 2))), from_s=0.0)
    assert (found.speed_amplification, found.spacing_amplification, found.stable_ratio) == (1.0, 1.0, 1.0)


def test_what_comes_before_is_left_out() -> None:
    calm = trace(np.ones((1, 3)), np.ones((1, 2)))
    early = calm.t_s < 0.0
    wild = replace(calm, too_near_m=np.where(early[:, None, None], 9.0, calm.too_near_m))
    assert measure_drive(wild, from_s=0.0) == measure_drive(calm, from_s=0.0)
    with pytest.raises(ValueError, match="two frames"):
        measure_drive(calm, from_s=99.0)


def test_change_of_speed_is_the_mean_difference_of_the_followers_over_their_mean() -> None:
    calm = trace(np.zeros((2, 3)), np.zeros((2, 2)))
    off = replace(calm, speed_mps=calm.speed_mps + np.array([5.0, 0.2, -0.4]))
    assert speed_change_ratio(off, calm, from_s=0.0) == pytest.approx(0.3 / 20.0)
    one = trace(np.zeros((1, 3)), np.zeros((1, 2)))
    assert speed_change_ratio(off, one, from_s=0.0) == pytest.approx(0.3 / 20.0)
    with pytest.raises(ValueError, match="alike"):
        speed_change_ratio(off, trace(np.zeros((2, 4)), np.zeros((2, 3))), from_s=0.0)


@pytest.mark.slow
def test_a_run_has_perfect_knowledge_first_and_then_every_sender_threshold_and_loss() -> None:
    steps = list[tuple[int, int]]()
    result = run_cruise(SMALL, progress=lambda done, most: steps.append((done, most)))
    found = [(row.sender, row.threshold_m, row.loss_ratio) for row in result.rows]
    assert found == [
        (PERFECT, None, 0.0),
        ("bsm-10hz", None, 0.0),
        ("bsm-10hz", None, 0.5),
        ("free", 0.05, 0.0),
        ("free", 0.05, 0.5),
        ("free", 0.5, 0.0),
        ("free", 0.5, 0.5),
    ]
    assert steps == [(at, 6) for at in range(7)]
    first, reference, lossy, *saving = result.rows
    assert (first.rate_hz, first.fewer_messages_ratio) == (0.0, 1.0)
    assert reference.rate_hz == pytest.approx(10.0)
    assert (reference.fewer_messages_ratio, reference.speed_change_ratio) == (0.0, 0.0)
    assert lossy.fewer_messages_ratio == 0.0
    assert lossy.speed_change_ratio > 0.0
    for row in saving:
        assert row.fewer_messages_ratio == pytest.approx(1.0 - row.rate_hz / 10.0)
        assert row.bytes_per_s == pytest.approx(40.0 * row.rate_hz)
    assert saving[0].rate_hz > saving[2].rate_hz


@pytest.mark.slow
def test_a_run_repeats_itself() -> None:
    few = replace(SMALL, senders=("mbc",), losses=(Loss(0.3, 0.5),), thresholds_m=(0.1,))
    assert run_cruise(few) == run_cruise(few)


def test_losses_are_channels() -> None:
    assert Loss(0.0, 2.0).channel == Ideal()
    assert Loss(0.3).channel == IndependentErasure(0.3)
    assert Loss(0.3, 2.0).channel == GilbertElliott(0.3, 2.0)


def test_senders_by_the_clock_speak_as_often_as_their_name_says() -> None:
    sender = platoon_sender("free-2.5hz")
    assert sender.policy == Periodic(2.5)
    assert sender.bank == platoon_sender("free", threshold_m=0.2).bank
    assert platoon_sender("bsm-4hz").bank == platoon_sender("bsm-10hz").bank


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"senders": ("bsm",)}, "bsm-Nhz"),
        ({"senders": ("bsm-0hz",)}, "bsm-Nhz"),
        ({"senders": ()}, "senders must name"),
        ({"senders": ("mbc", "mbc")}, "none twice"),
        ({"thresholds_m": (0.0,)}, "thresholds_m must be positive"),
        ({"losses": (Loss(1.5),)}, "0..1"),
        ({"losses": (Loss(0.5, -1.0),)}, "mean_burst_s"),
        ({"vehicles": 2}, "3 vehicles"),
        ({"platoons": 0}, "3 vehicles"),
        ({"keep_alive_s": 0.0}, "keep_alive_s"),
        ({"most_age_s": -1.0}, "most_age_s"),
        ({"drive": DriveSettings(duration_s=6.0)}, "duration_s must be at least"),
        ({"seed": -1}, "seed"),
    ],
)
def test_impossible_studies_are_refused(change: dict[str, object], match: str) -> None:
    with pytest.raises(ValueError, match=match):
        replace(SMALL, **change)  # pyright: ignore[reportArgumentType]

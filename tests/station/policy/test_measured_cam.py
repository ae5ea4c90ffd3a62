"""Claims about intervals and sizes as cars had them: chains that keep their chances."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from modelcast.core.markov import MarkovChain
from modelcast.core.markov_kernels import next_state
from modelcast.messages.cam_sizes import FrameSizes, measured_cam_sizes
from modelcast.station.policy.base import Air, MessageKind, TransmitInputs
from modelcast.station.policy.dcc import AdaptiveDcc, ReactiveDcc
from modelcast.station.policy.measured_cam import MeasuredCam, measured_cam_intervals

VEHICLES = 200


@cache
def sent(policy: MeasuredCam, *, busy_ratio: float = 0.0, steps: int = 900) -> np.ndarray:
    """Which of the vehicles send at each tenth of a second, (steps, V)."""
    rng, state = np.random.default_rng(2), policy.init(VEHICLES, 1)
    found = np.empty((steps, VEHICLES), dtype=np.bool_)
    for step in range(steps):
        inputs = TransmitInputs(
            np.full(VEHICLES, 0.1 * step),
            np.zeros(VEHICLES),
            silence_s=np.zeros(VEHICLES),
            tracking_error_m=np.zeros((VEHICLES, 1)),
            available=np.ones((VEHICLES, 1), dtype=np.bool_),
            air=Air(
                np.full(VEHICLES, busy_ratio),
                np.zeros(VEHICLES),
                packet_error_ratio=np.zeros(VEHICLES),
                airtime_s=np.full(VEHICLES, 4e-4),
            ),
        )
        said, state = policy.decide(state, inputs, rng)
        said.check(inputs)
        found[step] = said.kind == MessageKind.UPDATE
    return found


def intervals(found: np.ndarray) -> np.ndarray:
    """Tenths of a second between messages of the same vehicle, of all."""
    return np.concatenate([np.diff(np.flatnonzero(one)) for one in found.T])


def test_intervals_come_as_often_as_the_chain_says() -> None:
    """90 s of 200 vehicles; 0.008 is three standard deviations with the chain's memory."""
    gaps = intervals(sent(MeasuredCam(control=None)))
    shares = np.bincount(gaps, minlength=11)[1:] / gaps.size
    chain = measured_cam_intervals()
    # A time as short as this holds fewer of the long intervals: 2 % of the mean.
    assert gaps.mean() * 0.1 == pytest.approx(MeasuredCam().mean_interval_s, rel=0.02)
    assert shares == pytest.approx(chain.stationary, abs=0.008)


def test_the_next_interval_depends_on_the_last() -> None:
    found = sent(MeasuredCam(control=None))
    gaps = [np.diff(np.flatnonzero(one)) for one in found.T]
    after_two = np.concatenate([one[1:][one[:-1] == 2] for one in gaps])
    assert np.mean(after_two == 2) == pytest.approx(0.62475, abs=0.01)


def test_mean_intervals_are_within_those_of_the_survey() -> None:
    """TR 2052 has 0.33 s to 0.47 s."""
    mean_s = MeasuredCam().mean_interval_s
    assert 0.33 <= mean_s <= 0.47
    chain = np.array(MeasuredCam().chain.steps)
    later = np.linalg.matrix_power(chain / chain.sum(axis=1, keepdims=True), 400)[0]
    assert mean_s == pytest.approx(0.1 * float(later @ np.arange(1, 11)), abs=1e-4)


def test_congestion_control_makes_intervals_longer_and_none_shorter() -> None:
    free = intervals(sent(MeasuredCam(control=None), steps=300))
    idle = intervals(sent(MeasuredCam(control=ReactiveDcc()), steps=300))
    half = intervals(sent(MeasuredCam(control=ReactiveDcc()), busy_ratio=0.45, steps=300))
    jammed = intervals(sent(MeasuredCam(control=ReactiveDcc()), busy_ratio=0.9, steps=300))
    assert idle.tolist() == free.tolist()
    assert half.min() == 4
    assert set(jammed.tolist()) == {10}
    slow = intervals(sent(MeasuredCam(control=AdaptiveDcc(max_share=0.002)), busy_ratio=1.0, steps=300))
    assert slow.min() >= 2


def test_a_chain_steps_by_its_cumulative_chances() -> None:
    chain = MarkovChain(((0.25, 0.75), (1.0, 0.0)))
    up_to = chain.up_to()
    assert [next_state(0, u, up_to) for u in (0.0, 0.2499, 0.25, 0.9999)] == [0, 0, 1, 1]
    assert [next_state(1, u, up_to) for u in (0.0, 0.9999)] == [0, 0]
    assert chain.stationary == pytest.approx([4.0 / 7.0, 3.0 / 7.0])
    assert [next_state(-1, u, up_to) for u in (0.5, 0.6)] == [0, 1]


def test_sizes_are_those_measured() -> None:
    """The published share of each size, rounded chances of the chain aside."""
    sizes = measured_cam_sizes()
    assert sizes.chain.stationary == pytest.approx([0.33171, 0.289, 0.14212, 0.23717], abs=2e-3)
    assert sizes.mean_bytes == pytest.approx(312.0, abs=1.5)
    assert (sizes.numbers.mean_bytes, sizes.numbers.size_bytes.tolist()) == (312, [200, 300, 360, 455])


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: MarkovChain(()),
        lambda: MarkovChain(((1.0, 0.0),)),
        lambda: MarkovChain(((0.5, 0.4), (0.0, 1.0))),
        lambda: MarkovChain(((1.5, -0.5), (0.0, 1.0))),
        lambda: FrameSizes((100,), MarkovChain(((0.5, 0.5), (0.5, 0.5)))),
        lambda: FrameSizes((0,), MarkovChain(((1.0,),))),
        lambda: MeasuredCam(step_s=0.0),
        lambda: replace(MeasuredCam(), step_s=np.nan),
    ],
)
def test_impossible_chains_are_refused(wrong: object) -> None:
    with pytest.raises(ValueError, match="must"):
        wrong()  # type: ignore[operator]

"""A radio with an erasure channel on every link: ratio, bursts, and losses that no policy changes."""

import numpy as np
import pytest

from modelcast.channel.erasure import GilbertElliott, Ideal, IndependentErasure
from modelcast.channel.erasure_radio import ErasureRadio
from modelcast.channel.radio import Transmissions

STEP_S = 0.1

RATIO_TOLERANCE = 0.02
"""Five standard deviations of a ratio over 12,000 draws at least; of bursts of 0.5 s, over 1,200."""


def everybody(vehicles: int, t_s: float, who: np.ndarray | None = None) -> Transmissions:
    sender = np.arange(vehicles) if who is None else who
    return Transmissions(
        sender,
        np.full(sender.size, t_s),
        size_bytes=np.full(sender.size, 300),
        power_dbm=np.full(sender.size, 20.0),
        message_id=sender,
    )


def heard_links(radio: ErasureRadio, steps: int, who: np.ndarray | None = None) -> np.ndarray:
    """Which of 6 x 6 links were heard in each step, (steps, 6, 6)."""
    place_m = np.zeros((6, 2))
    place_m[:, 0] = 9.0 * np.arange(6)
    state = radio.init(6, np.random.default_rng(3))
    heard = np.zeros((steps, 6, 6), dtype=bool)
    for k in range(steps):
        received, state = radio.step(state, everybody(6, STEP_S * k, who), place_m, STEP_S * (k + 1))
        heard[k, received.sender, received.receiver] = True
    return heard


def across(heard: np.ndarray) -> np.ndarray:
    """Links between two vehicles, (steps, 30)."""
    return heard[:, ~np.eye(6, dtype=bool)]


@pytest.mark.parametrize("channel", [IndependentErasure(0.4), GilbertElliott(0.4, 0.5)])
def test_a_link_loses_the_stated_ratio_at_any_distance(channel: IndependentErasure | GilbertElliott) -> None:
    lost = ~across(heard_links(ErasureRadio(channel), 2000))
    assert lost.mean() == pytest.approx(0.4, abs=RATIO_TOLERANCE)
    assert np.ptp(lost.mean(axis=0)) < 0.2


@pytest.mark.parametrize(
    ("channel", "lost"), [(Ideal(), 0), (IndependentErasure(1.0), 1), (GilbertElliott(1.0), 1)]
)
def test_nothing_and_everything_are_lost_to_the_last(
    channel: Ideal | IndependentErasure | GilbertElliott, lost: int
) -> None:
    assert np.all(across(heard_links(ErasureRadio(channel), 20)) == (not lost))


def test_bursts_last_as_stated_and_independent_losses_do_not() -> None:
    """The share of losses that follow a loss is that of the chain over one step; 0.4 where there is none."""
    for channel, memory in (
        (IndependentErasure(0.4), 0.0),
        (GilbertElliott(0.4, 0.5), np.exp(-STEP_S / 0.3)),
    ):
        lost = ~across(heard_links(ErasureRadio(channel), 2000))
        again = lost[1:][lost[:-1]].mean()
        assert again == pytest.approx(0.4 + 0.6 * memory, abs=RATIO_TOLERANCE)


def test_what_is_lost_does_not_depend_on_who_sends() -> None:
    radio = ErasureRadio(GilbertElliott(0.5, 0.5))
    all_send, few = heard_links(radio, 50), heard_links(radio, 50, np.array([1, 4]))
    assert np.array_equal(all_send[:, [1, 4]], few[:, [1, 4]])
    assert not few[:, [0, 2, 3, 5]].any()


def test_links_both_ways_and_beside_each_other_lose_by_themselves() -> None:
    heard = heard_links(ErasureRadio(IndependentErasure(0.5)), 2000)
    both = (
        np.corrcoef(heard[:, 0, 1], heard[:, 1, 0])[0, 1],
        np.corrcoef(heard[:, 0, 1], heard[:, 0, 2])[0, 1],
    )
    assert np.abs(both).max() < 0.1


def test_beyond_the_range_nothing_is_heard() -> None:
    radio = ErasureRadio(range_m=20.0)
    heard = heard_links(radio, 1)[0]
    apart = np.abs(np.subtract.outer(np.arange(6), np.arange(6)))
    assert np.array_equal(heard, (apart > 0) & (apart <= 2))
    with pytest.raises(ValueError, match="range_m must be positive"):
        ErasureRadio(range_m=0.0)

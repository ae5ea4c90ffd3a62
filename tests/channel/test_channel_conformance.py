"""The contract of a channel, over every channel: every instant is answered, and chance is the generator's."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from modelcast.channel.base import AbstractChannel
from modelcast.channel.erasure import GilbertElliott, Ideal, IndependentErasure
from modelcast.channel.link_record import LinkRecord
from modelcast.channel.recorded import RecordedLosses

T_S = np.arange(2000) * 0.1

LOSSY: dict[str, Callable[[float], AbstractChannel]] = {
    "independent": IndependentErasure,
    "bursts": GilbertElliott,
    "long-bursts": lambda ratio: GilbertElliott(ratio, 3.0),
}
"""Channels by their packet error ratio."""

_LINKS = tuple(
    LinkRecord(f"link {number}", lost, period_s=0.1)
    for number, messages in enumerate((120, 800))
    for lost in [np.pad(np.random.default_rng(number).random(messages) < 0.25, 1)]
)
"""Links of other lengths, that lose a quarter each."""

CHANNELS: dict[str, AbstractChannel] = {
    "ideal": Ideal(),
    **{name: made(0.4) for name, made in LOSSY.items()},
    "recorded": RecordedLosses(_LINKS),
}

every_channel = pytest.mark.parametrize("channel", CHANNELS.values(), ids=CHANNELS.keys())
every_lossy_channel = pytest.mark.parametrize("made", LOSSY.values(), ids=LOSSY.keys())


def test_every_channel_of_the_package_has_a_case(
    concrete_classes: Callable[[type[Any]], set[type[Any]]],
) -> None:
    assert concrete_classes(AbstractChannel) == {type(channel) for channel in CHANNELS.values()}


@every_channel
@pytest.mark.parametrize("instants", [0, 1, 2000])
def test_every_instant_is_answered(channel: AbstractChannel, instants: int) -> None:
    lost = channel.losses(T_S[:instants], np.random.default_rng(3))
    assert lost.shape == (instants,)
    assert lost.dtype == np.bool_


@every_channel
def test_the_same_generator_gives_the_same_losses(channel: AbstractChannel) -> None:
    first, second, other = (channel.losses(T_S, np.random.default_rng(k)) for k in (1, 1, 2))
    assert np.array_equal(first, second)
    assert np.array_equal(first, other) == (channel.packet_error_ratio == 0.0)


@every_lossy_channel
def test_as_many_numbers_are_drawn_whatever_the_ratio(made: Callable[[float], AbstractChannel]) -> None:
    """So that policies compared under several ratios meet comparable chance."""
    left: list[float] = []
    for ratio in (0.1, 0.4, 0.9):
        rng = np.random.default_rng(5)
        made(ratio).losses(T_S, rng)
        left.append(rng.random())
    assert len(set(left)) == 1


@every_channel
def test_losses_match_the_ratio_that_a_channel_states(channel: AbstractChannel) -> None:
    """Over 3,000 runs at one instant: binomial, four standard errors."""
    ratio = channel.packet_error_ratio
    lost = [bool(channel.losses(T_S[:8], np.random.default_rng(k))[-1]) for k in range(3000)]
    assert np.mean(lost) == pytest.approx(ratio, abs=4 * np.sqrt(ratio * (1.0 - ratio) / 3000))


@every_lossy_channel
def test_ratios_of_zero_and_one_lose_nothing_and_all(made: Callable[[float], AbstractChannel]) -> None:
    assert not made(0.0).losses(T_S, np.random.default_rng(0)).any()
    assert made(1.0).losses(T_S, np.random.default_rng(0)).all()
    assert made(0.4).packet_error_ratio == 0.4


@every_lossy_channel
@pytest.mark.parametrize("ratio", [-0.1, 1.1, np.nan])
def test_a_ratio_outside_zero_to_one_is_refused(
    made: Callable[[float], AbstractChannel], ratio: float
) -> None:
    with pytest.raises(ValueError, match=r"0\.\.1"):
        made(ratio)

"""Claims about the medium in memory."""

from random import Random
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.channel.base import AbstractChannel
from modelcast.channel.erasure import GilbertElliott, Ideal, IndependentErasure
from modelcast.core.arrays import BoolArray, FloatArray
from modelcast.runtime.transport.base import MOST_OCTETS, Arrival
from modelcast.runtime.transport.virtual import VirtualMedium


class Alternating(AbstractChannel):
    """Loses every second instant."""

    @property
    def packet_error_ratio(self) -> float:
        """A half."""
        return 0.5

    def losses(self, t_s: FloatArray, rng: np.random.Generator) -> BoolArray:
        """The odd instants."""
        del rng
        return np.rint(t_s / 0.1).astype(np.int64) % 2 == 1


def test_a_frame_reaches_everybody_but_its_sender_once() -> None:
    medium = VirtualMedium(delay_s=0.25)
    first, second, third = (medium.join() for _ in range(3))
    first.send(b"\x01", sent_s=1.0)
    assert first.receive(9.0) == []
    assert second.receive(1.24) == []
    assert second.receive(1.25) == [Arrival(b"\x01", 1.25)]
    assert second.receive(9.0) == []
    assert third.receive(9.0) == [Arrival(b"\x01", 1.25)]
    assert (medium.sent, medium.delivered, medium.lost) == (1, 2, 0)


def test_who_joins_later_hears_what_is_sent_later() -> None:
    medium = VirtualMedium()
    first, second = medium.join(), medium.join()
    first.send(b"early", sent_s=0.0)
    third = medium.join()
    first.send(b"late", sent_s=0.1)
    assert [one.octets for one in third.receive(1.0)] == [b"late"]
    assert [one.octets for one in second.receive(1.0)] == [b"early", b"late"]


def test_the_channel_says_what_is_lost() -> None:
    medium = VirtualMedium(Alternating())
    first, second = medium.join(), medium.join()
    for step in range(3000):  # over several blocks of instants, also before zero
        first.send(step.to_bytes(2, "big"), sent_s=0.1 * (step - 1000))
    heard = [int.from_bytes(one.octets, "big") for one in second.receive(np.inf)]
    assert heard == list(range(0, 3000, 2))
    assert medium.lost == 1500


@pytest.mark.parametrize("channel", [IndependentErasure(0.4), GilbertElliott(0.4, 0.5)])
def test_the_mean_loss_is_the_channels_and_links_differ(channel: AbstractChannel) -> None:
    medium = VirtualMedium(channel, seed=5)
    first, second, third = (medium.join() for _ in range(3))
    for step in range(20_000):
        first.send(step.to_bytes(2, "big"), sent_s=0.1 * step)
    heard = [{one.octets for one in host.receive(np.inf)} for host in (second, third)]
    assert medium.lost / (2 * medium.sent) == pytest.approx(0.4, abs=0.02)
    # Independent links lose the same frame with the square of the ratio.
    assert 1.0 - len(heard[0] | heard[1]) / 20_000 == pytest.approx(0.16, abs=0.02)


@given(st.lists(st.integers(0, 3000), min_size=1, max_size=30, unique=True), st.randoms())
def test_losses_do_not_depend_on_what_else_is_sent(steps: list[int], rng: Random) -> None:
    def fate(sent: list[int]) -> set[int]:
        medium = VirtualMedium(IndependentErasure(0.5), jitter_s=0.3, seed=3)
        first, second = medium.join(), medium.join()
        for step in sent:
            first.send(step.to_bytes(2, "big"), sent_s=0.1 * step)
        return {int.from_bytes(one.octets, "big") for one in second.receive(np.inf)}

    shuffled = list(steps)
    rng.shuffle(shuffled)
    whole = fate(sorted({*steps, *range(0, 3000, 7)}))
    assert fate(shuffled) == whole & set(steps)


def test_jitter_lets_frames_overtake_within_its_bounds() -> None:
    medium = VirtualMedium(delay_s=0.1, jitter_s=1.0, seed=1)
    first, second = medium.join(), medium.join()
    for step in range(200):
        first.send(step.to_bytes(1, "big"), sent_s=0.1 * step)
    heard = second.receive(np.inf)
    order = [one.octets[0] for one in heard]
    assert order != sorted(order)
    assert [one.received_s for one in heard] == sorted(one.received_s for one in heard)
    late_s = np.array([one.received_s - 0.1 * one.octets[0] for one in heard])
    assert 0.1 <= late_s.min() < 0.15
    assert 1.05 < late_s.max() <= 1.1


@pytest.mark.parametrize("octets", [b"", bytes(MOST_OCTETS + 1)])
def test_frames_that_no_radio_carries_are_refused(octets: bytes) -> None:
    with pytest.raises(ValueError, match=f"1 to 2304 octets, got {len(octets)}"):
        VirtualMedium().join().send(octets, sent_s=0.0)


@pytest.mark.parametrize("name", ["delay_s", "jitter_s", "instant_s"])
@pytest.mark.parametrize("value", [-1.0, float("nan"), float("inf")])
def test_times_out_of_range_are_refused(name: str, value: float) -> None:
    with pytest.raises(ValueError, match=f"{name} must be finite"):
        VirtualMedium(Ideal(), **cast("dict[str, Any]", {name: value}))


def test_a_frame_of_no_time_is_refused() -> None:
    with pytest.raises(ValueError, match="sent_s must be finite, got nan"):
        VirtualMedium().join().send(b"\x00", sent_s=float("nan"))

"""Claims about what messages cost on the air."""

from dataclasses import dataclass
from typing import get_args

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.core.arrays import FloatArray
from modelcast.messages import stack_kernels as kernels
from modelcast.messages.airtime import Stack
from modelcast.messages.mbc_codec import UpdateCodec
from modelcast.messages.mbc_profile import WireProfile
from modelcast.messages.mbc_update import update_octets
from modelcast.messages.rules import CertificateRule
from modelcast.messages.sizes import SizeModel
from modelcast.models.bank import Bank
from modelcast.models.base import PointFunctions
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.gp import GaussianProcess, vehicle_process
from modelcast.models.kinematic import ConstantAcceleration, ConstantTurnRateAcceleration
from modelcast.models.predicted_path import PredictedPath
from modelcast.models.trusted import Trusted
from modelcast.models.wrapped import AbstractWrapped
from modelcast.station.banks import bank_from_text

times = st.lists(st.integers(1, 30), min_size=1, max_size=40).map(lambda gaps: np.cumsum(gaps) * 0.05)


@given(times)
def test_a_certificate_follows_every_gap_and_the_first_message_has_one(t_s: np.ndarray) -> None:
    gap = Stack("gap").carries_certificate(t_s)
    assert gap[0]
    assert gap[1:].tolist() == [bool(late) for late in np.diff(t_s) > 0.45 + 1e-9]


@given(times)
def test_by_the_timer_no_certificate_is_more_than_one_message_late(t_s: np.ndarray) -> None:
    carried = Stack("timer").carries_certificate(t_s)
    with_one = t_s[carried]
    assert carried[0]
    assert (np.diff(with_one) >= 0.45 - 1e-6).all()
    for now, has in zip(t_s, carried, strict=True):
        if not has:
            assert now - with_one[with_one <= now][-1] < 0.45


def test_ten_messages_a_second_carry_one_certificate_in_five_by_the_timer() -> None:
    assert Stack("timer").carries_certificate(np.arange(100) * 0.1).sum() == 20
    assert Stack("gap").carries_certificate(np.arange(100) * 0.1).sum() == 1


@given(times, st.sampled_from(get_args(CertificateRule)))
def test_the_vectors_are_the_rule_for_one_message_in_a_row(t_s: np.ndarray, rule: CertificateRule) -> None:
    stack = Stack(rule)
    numbers, last_s, certified_s = stack.numbers, -np.inf, -np.inf
    carried = stack.carries_certificate(t_s)
    lasts_s = stack.sent_airtime_s(t_s, np.arange(t_s.size) + 40)
    for i, now_s in enumerate(t_s.tolist()):
        has = kernels.carries_certificate(numbers.rule, numbers.interval_s, now_s, last_s, certified_s)
        assert has == carried[i]
        size = kernels.frame_bytes(40 + i, has, numbers)
        assert size == stack.frame_bytes(np.array([40 + i]), np.array([has]))[0]
        assert kernels.airtime(size, numbers) == lasts_s[i]
        last_s, certified_s = now_s, now_s if has else certified_s


def test_every_rule_has_its_number() -> None:
    assert get_args(CertificateRule) == kernels.RULES


def test_the_layers_of_a_message_add_up() -> None:
    one, no, yes = np.array([40]), np.array([False]), np.array([True])
    assert Stack("unsigned").frame_bytes(one, yes).tolist() == [40 + 24 + 4 + 2 + 5]
    assert Stack().frame_bytes(one, no).tolist() == [75 + 93]
    assert Stack().frame_bytes(one, yes).tolist() == [75 + 164]
    # 22 + 8 · 239 bits are 1,934: 41 symbols.
    assert Stack().airtime_s(one, yes).tolist() == pytest.approx([40e-6 + 41 * 8e-6])


def test_impossible_stacks_are_refused() -> None:
    with pytest.raises(ValueError, match="certificates"):
        Stack("sometimes")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="certificate_bytes"):
        Stack(certificate_bytes=10)
    with pytest.raises(ValueError, match="mac_bytes"):
        Stack(mac_bytes=-1)
    with pytest.raises(ValueError, match="bits_per_symbol"):
        Stack(bits_per_symbol=0)


@dataclass(frozen=True, slots=True)
class Renamed(AbstractWrapped):
    """The same sub-model under another name."""

    @property
    def name(self) -> str:
        """Another."""
        return f"{self.model.name}-again"

    def point_functions(self, dt_s: float) -> PointFunctions:
        """Those of the sub-model inside."""
        return self.model.point_functions(dt_s)

    def covariance(self, parameters: FloatArray, horizons_s: FloatArray, *, dt_s: float) -> FloatArray:
        """That of the sub-model inside."""
        return self.model.covariance(parameters, horizons_s, dt_s=dt_s)


@pytest.mark.parametrize("identify", ["never", "on-failure"])
def test_sizes_are_those_of_the_codec(identify: str) -> None:
    bank = Bank((*bank_from_text("learned+ctra").members, vehicle_process()))
    wire = WireProfile.of(bank, 1)
    columns = 26 + sum(len(layout.fields) for layout in wire.layouts)
    parameters = np.zeros((len(bank.members), columns))
    parameters[:, 25] = np.arange(len(bank.members))
    sizes = UpdateCodec(wire, carries_all=identify != "never").sizes(parameters)
    plain = [identify == "never" and member.name == "ctra" for member in bank.members]
    expected = np.where(plain, SizeModel().baseline_bytes(), sizes)
    assert SizeModel().each_update_bytes(bank, identify).tolist() == expected.tolist()


def test_what_a_plain_message_is_coasted_by_costs_a_plain_message() -> None:
    """The first free member of a bank, or the one it names; another free one must name the profile."""
    sizes, pair = SizeModel(), (ConstantTurnRateAcceleration(), ConstantVelocity())
    for alone in pair:
        assert sizes.each_update_bytes(Bank((alone,)), "on-failure").tolist() == [sizes.baseline_bytes()]
    assert sizes.each_update_bytes(Bank(pair), "never").tolist() == [40, 47]
    assert sizes.each_update_bytes(Bank(pair[::-1]), "never").tolist() == [40, 47]
    assert sizes.each_update_bytes(Bank(pair, plain="cv"), "never").tolist() == [47, 40]
    assert SizeModel(more_bytes=30).each_update_bytes(Bank(pair), "never").tolist() == [70, 77]


def test_where_another_member_may_be_named_no_update_is_plain() -> None:
    pair = Bank((ConstantTurnRateAcceleration(), ConstantVelocity()))
    assert SizeModel().each_update_bytes(pair, "on-failure").tolist() == [47, 47]


def test_a_member_that_receivers_coast_alike_is_plain_beside_the_one_named() -> None:
    """The spreads of a covariance are no message's; a trusted horizon changes what is predicted."""
    plain, trusted = ConstantTurnRateAcceleration(), Trusted(ConstantTurnRateAcceleration(), 2.0)
    other = Renamed(ConstantTurnRateAcceleration(jerk_spread_mps3=3.0))
    assert Bank((plain, other)).sent_plain == (True, True)
    assert Bank((trusted, other)).sent_plain == (True, False)
    assert Bank((Trusted(ConstantTurnRateAcceleration(), 2.0), Renamed(trusted))).sent_plain == (True, True)
    assert Bank((ConstantAcceleration(), other, ConstantVelocity())).sent_plain == (True, False, False)


def test_a_process_is_counted_as_its_predicted_path_however_it_is_given() -> None:
    gp = GaussianProcess()
    pair = Bank((ConstantVelocity(), gp))
    (size, again) = SizeModel().each_update_bytes(pair, "on-failure")
    assert size == again == update_octets(PredictedPath(gp).payload_layout.bits)
    assert SizeModel().each_update_bytes(pair.carried(), "on-failure").tolist() == [size, size]
    with pytest.raises(ValueError, match="more_bytes"):
        SizeModel(more_bytes=-1)

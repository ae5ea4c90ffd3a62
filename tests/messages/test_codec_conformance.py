"""The contract of `AbstractCodec`, over every codec: add yours to `CODECS`."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from modelcast.core.arrays import FloatArray
from modelcast.core.exceptions import CodecError
from modelcast.messages.bsm import BasicSafetyMessage, BsmCore
from modelcast.messages.bsm_codec import BsmCodec
from modelcast.messages.bsm_fields import CORE_FIELDS
from modelcast.messages.codec import AbstractCodec
from modelcast.messages.fields import Outside
from modelcast.messages.mbc_codec import IdentificationCodec, UpdateCodec
from modelcast.messages.mbc_profile import WireProfile
from modelcast.messages.mbc_update import UpdateMessage
from modelcast.messages.mbc_wire import IdentificationMessage
from modelcast.messages.psm import PersonalSafetyMessage, person_codes
from modelcast.messages.psm_codec import PsmCodec
from modelcast.messages.psm_fields import PERSON_FIELDS
from modelcast.models.payload import PayloadField, PayloadLayout

BENT = 300
"""Random changes of octets that are tried on each message."""


@dataclass(frozen=True)
class Case:
    """A codec, messages that use all it has, and rows of parameters with the messages they stand for."""

    codec: AbstractCodec[Any]
    messages: Sequence[Any]
    parameters: FloatArray
    message_of: Callable[[list[float]], Any]
    parameters_of: Callable[[Any], list[float]]


def bsm_case() -> Case:
    rng = np.random.default_rng(3)
    codes = np.stack([rng.integers(field.low, field.high + 1, 5) for field in CORE_FIELDS], axis=1)
    cores = [BsmCore(tuple(row)) for row in codes.tolist()]
    messages = [
        BasicSafetyMessage(cores[0]),
        BasicSafetyMessage(cores[1], part_ii=((0, bytes(130)),)),
        BasicSafetyMessage(cores[2], regional=((128, b"model"), (1, b"x"))),
        BasicSafetyMessage(cores[3], additions=(None, b"later"), frame_additions=(b"frame",)),
    ]
    columns = [
        rng.integers(*field.known_codes, 50, endpoint=True).astype(float)
        if field.outside is Outside.REFUSE
        else rng.uniform(1.2 * field.low * field.resolution, 1.2 * field.high * field.resolution, 50)
        for field in CORE_FIELDS
    ]

    def message_of(row: list[float]) -> BasicSafetyMessage:
        values = zip((field.name for field in CORE_FIELDS), row, strict=True)
        return BasicSafetyMessage(BsmCore.from_values(dict(values)))

    def parameters_of(message: BasicSafetyMessage) -> list[float]:
        return [np.nan if value is None else value for value in message.core.values().values()]

    return Case(BsmCodec(), messages, np.stack(columns, axis=1), message_of, parameters_of)


def psm_case() -> Case:
    rng = np.random.default_rng(32)
    codes = np.stack([rng.integers(field.low, field.high + 1, 5) for field in PERSON_FIELDS], axis=1)
    rows = [tuple(row) for row in codes.tolist()]
    messages = [
        PersonalSafetyMessage(rows[0]),
        PersonalSafetyMessage((*rows[1][:6], -4096, *rows[1][7:]), has_elevation=False),
        PersonalSafetyMessage(rows[2], acceleration=(1, 2, 3, 4), parts=(("cross_state", 1), ("sizing", 4))),
        PersonalSafetyMessage(rows[3], regional=((128, b"model"),), additions=(None, b"later")),
        PersonalSafetyMessage(
            rows[4], parts=(("path_history", (None, 3, ((1, 2, 3, 4, None, None, 5),) * 23)),)
        ),
    ]
    columns = [
        rng.integers(*field.known_codes, 50, endpoint=True).astype(float)
        if field.outside is Outside.REFUSE
        else rng.uniform(1.2 * field.low * field.resolution, 1.2 * field.high * field.resolution, 50)
        for field in PERSON_FIELDS
    ]

    def message_of(row: list[float]) -> PersonalSafetyMessage:
        values = zip((field.name for field in PERSON_FIELDS), row, strict=True)
        return PersonalSafetyMessage(person_codes(dict(values)))

    def parameters_of(message: PersonalSafetyMessage) -> list[float]:
        values = [message.value(field.name) for field in PERSON_FIELDS]
        return [np.nan if value is None else value for value in values]

    return Case(PsmCodec(), messages, np.stack(columns, axis=1), message_of, parameters_of)


PROFILE = WireProfile(
    0x44136F,
    (
        PayloadLayout((PayloadField("along_0_m", 0.05, bits=6), PayloadField("along_1_m", 0.4, bits=9))),
        PayloadLayout(),
        PayloadLayout((PayloadField("end_s", 0.1, bits=7, signed=False),)),
    ),
)


def update_case(*, carries_all: bool) -> Case:
    rng = np.random.default_rng(7)
    plain = bsm_case()
    codec = UpdateCodec(PROFILE, carries_all)
    extra = np.stack(
        [rng.integers(0, 3, 50), *(rng.normal(0.0, spread, 50) for spread in (1.0, 60.0, 8.0))], axis=1
    )
    parameters = np.concatenate([plain.parameters, extra], axis=1)
    cores = [message.core for message in plain.messages]
    messages = [
        UpdateMessage(cores[0], 0, carries_all=False, codes=((-32, 255),)),
        UpdateMessage(cores[1], 1, carries_all=False, codes=((),)),
        UpdateMessage(cores[2], 2, carries_all=False, codes=((127,),)),
        UpdateMessage(cores[3], 2, carries_all=True, codes=((31, -256), (), (0,))),
    ]

    def parameters_of(message: UpdateMessage) -> list[float]:
        values = [np.nan if value is None else value for value in message.core.values().values()]
        carried = PROFILE.carried(message.sub_model, carries_all=message.carries_all)
        held = dict(zip(carried, message.codes, strict=True))
        for member, layout in enumerate(PROFILE.layouts):
            codes = held.get(member, (np.nan,) * len(layout.fields))
            values += [code * field.step for code, field in zip(codes, layout.fields, strict=True)]
            if member == 0:
                values.insert(len(CORE_FIELDS), float(message.sub_model))
        return values

    return Case(codec, messages, parameters, codec.message_of, parameters_of)


def identification_case() -> Case:
    rng = np.random.default_rng(9)
    codec = IdentificationCodec()
    columns = [rng.integers(0, 2**32, 50), rng.integers(0, 128, 50), rng.integers(0, 8, 50)]
    parameters = np.stack([*columns, rng.uniform(-1.0, 200.0, 50)], axis=1)
    messages = [
        IdentificationMessage(0, 0, sub_model=0, age=0),
        IdentificationMessage(2**32 - 1, 127, sub_model=7, age=16383),
    ]

    def parameters_of(message: IdentificationMessage) -> list[float]:
        return [message.temporary_id, message.sequence, message.sub_model, message.age_s]

    return Case(codec, messages, parameters, codec.message_of, parameters_of)


CODECS = {
    "bsm": bsm_case,
    "psm": psm_case,
    "update": lambda: update_case(carries_all=False),
    "update-of-all": lambda: update_case(carries_all=True),
    "identification": identification_case,
}


@pytest.fixture(params=CODECS, scope="module")
def case(request: pytest.FixtureRequest) -> Case:
    return CODECS[request.param]()


def test_decoding_inverts_encoding(case: Case) -> None:
    for message in case.messages:
        octets = case.codec.encode(message)
        assert case.codec.decode(octets) == message
        assert case.codec.encode(case.codec.decode(octets)) == octets


def test_octets_are_a_message_or_a_codec_error(case: Case) -> None:
    rng = np.random.default_rng(5)
    for message in case.messages:
        octets = case.codec.encode(message)
        for _ in range(BENT):
            bent = bytearray(octets)
            bent[rng.integers(len(bent))] ^= rng.integers(1, 256)
            bent = bent[: rng.integers(len(bent) + 1)] if rng.random() < 0.3 else bent
            try:
                again = case.codec.encode(case.codec.decode(bytes(bent)))
            except CodecError as refusal:
                inside = 0 <= refusal.offset_bits <= 8 * len(bent)
                assert inside, refusal  # noqa: PT017 - any message may be refused, and none need be
            else:
                assert again == bytes(bent)


def test_quantised_parameters_are_what_the_receiver_decodes(case: Case) -> None:
    held = case.codec.quantise(case.parameters)
    assert held.shape == case.parameters.shape
    for sent, one in zip(case.parameters.tolist(), held, strict=True):
        received = case.codec.decode(case.codec.encode(case.message_of(sent)))
        assert np.array_equal(case.parameters_of(received), one, equal_nan=True)


def test_a_row_is_quantised_alike_alone_and_in_a_batch(case: Case) -> None:
    together = case.codec.quantise(case.parameters)
    for index in range(len(case.parameters)):
        alone = case.codec.quantise(case.parameters[index : index + 1])
        assert np.array_equal(alone[0], together[index], equal_nan=True)


def test_quantising_leaves_its_argument_alone(case: Case) -> None:
    before = case.parameters.copy()
    case.codec.quantise(case.parameters)
    assert np.array_equal(before, case.parameters, equal_nan=True)


def test_sizes_are_those_of_the_octets(case: Case) -> None:
    sizes = case.codec.sizes(case.parameters)
    assert sizes.tolist() == [
        len(case.codec.encode(case.message_of(row))) for row in case.parameters.tolist()
    ]


def test_every_codec_is_held_to_the_contract(
    concrete_classes: Callable[[type[Any]], set[type[Any]]],
) -> None:
    assert concrete_classes(AbstractCodec) == {type(make().codec) for make in CODECS.values()}

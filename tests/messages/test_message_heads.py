"""Models in personal safety messages: the octets, their sizes, and that every reader reads the same."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from modelcast.core.exceptions import CodecError
from modelcast.core.kinds import PEOPLE, Kind
from modelcast.messages.bsm_fields import CORE_INDEX, LOCAL_REGION
from modelcast.messages.mbc_codec import UpdateCodec
from modelcast.messages.mbc_update import UpdateReading, read_update
from modelcast.messages.message_heads import HEADS, KINDS_OF_TYPES, heads_of_members, part_one_of
from modelcast.messages.psm import PersonalSafetyMessage, decode_psm, encode_psm, person_codes
from modelcast.messages.sizes import SizeModel
from modelcast.messages.station_codec import HeardUpdates, StationCodec, UpdateRows
from modelcast.models.bank import Bank
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.kinematic import ConstantTurnRateAcceleration

BANK = Bank((ConstantTurnRateAcceleration(), ConstantVelocity()))
NUMBER = 0x44136F
RULES = ("never", "on-failure")
GOLDEN = "0020274000249c40b00000001c4ead9a0039d1067fffffffff0641c20802fa100823c20015104dbc4000"


def rows_of(in_use: list[int], speed_mps: float = 4.0) -> UpdateRows:
    count = len(in_use)
    one = [speed_mps, 0.0, 0.5, 0.1, speed_mps, 0.0]
    return UpdateRows(
        np.arange(count) + 7,
        np.arange(count) + 300,
        np.full(count, 20.0),
        place=np.tile([420_000_000, -830_000_000], (count, 1)),
        in_use=np.array(in_use),
        parameters=np.tile(one, (count, 1)),
    )


def written(codec: StationCodec, rows: UpdateRows) -> list[bytes]:
    frames, lengths = codec.encode(rows)
    return [frame[:length].tobytes() for frame, length in zip(frames, lengths.tolist(), strict=True)]


def heard(codec: StationCodec, octets: list[bytes]) -> HeardUpdates:
    lengths = np.array([len(one) for one in octets])
    frames = np.zeros((len(octets), int(lengths.max())), np.uint8)
    for frame, one in zip(frames, octets, strict=True):
        frame[: len(one)] = np.frombuffer(one, np.uint8)
    return codec.decode(frames, lengths, received_s=np.full(len(octets), 20.1))


@pytest.mark.parametrize(("kind", "identify", "in_use"), list(product(PEOPLE, RULES, (0, 1))))
def test_a_model_rides_in_a_personal_safety_message_and_every_reader_reads_it(
    kind: Kind, identify: str, in_use: int
) -> None:
    """The compiled reader, the message's own codec and the update's; the size is that of the one rule."""
    codec = StationCodec.of(BANK, NUMBER, identify, kind=kind)
    rows = rows_of([in_use])
    (octets,) = written(codec, rows)
    assert len(octets) == SizeModel(kind=kind).each_update_bytes(BANK, identify)[in_use]
    message = decode_psm(octets)
    assert encode_psm(message) == octets
    assert (message.codes[0], message.has_elevation) == (int(kind), False)
    accelerates = identify == "on-failure" or in_use == 0
    assert bool(message.acceleration) is accelerates
    plain = identify == "never" and in_use == 1
    assert [region for region, _ in message.regional] == ([] if plain else [LOCAL_REGION])
    found = read_update(octets, {NUMBER: codec.profile})
    compiled = heard(codec, [octets])
    assert found.kind == compiled.kind[0] == kind
    assert found.core.codes == tuple(compiled.core[0].tolist()) == part_one_of(message).codes
    assert (found.reading, int(compiled.reading[0])) == (
        (UpdateReading.PLAIN, UpdateReading.PLAIN) if plain else (UpdateReading.MODEL, UpdateReading.MODEL)
    )
    if not plain:
        assert compiled.rows.in_use.tolist() == [in_use]
        _, held = codec.table.quantise(rows.parameters)
        sent = slice(None) if identify == "on-failure" else slice(0, 4)
        assert compiled.rows.parameters[0, sent].tobytes() == held[0, sent].tobytes()


def test_kinds_are_told_apart_in_one_batch() -> None:
    """Of one batch each message keeps its sender's kind, whichever codec reads it."""
    kinds = (Kind.VEHICLE, *PEOPLE)
    octets = [written(StationCodec.of(BANK, NUMBER, "never", kind=kind), rows_of([0]))[0] for kind in kinds]
    for reader in (
        StationCodec.of(BANK, NUMBER, "never"),
        StationCodec.of(BANK, 5, "never", kind=Kind.CYCLIST),
    ):
        assert heard(reader, octets * 2).kind.tolist() == [*kinds, *kinds]


@given(st.integers(0, 4), st.booleans(), st.booleans(), st.integers(0, 2))
def test_what_others_write_into_personal_safety_messages_is_read(
    basic_type: int, has_elevation: bool, accelerates: bool, more: int
) -> None:
    """Parts that modelcast does not write go the slow way, and come to the same."""
    values = {
        "basic_type": basic_type, "message_count": 3, "temporary_id": 9, "second_of_minute_s": 1.0,
        "latitude_deg": 42.0, "longitude_deg": -83.0, "speed_mps": 1.4, "heading_rad": 1.0,
    }  # fmt: skip
    if has_elevation:
        values["elevation_m"] = 200.0
    message = PersonalSafetyMessage(
        person_codes(values),
        has_elevation=has_elevation,
        acceleration=(50, 2001, -127, 100) if accelerates else (),
        parts=(("cross_state", 1), ("cluster_radius_m", 3))[:more],
    )
    found = heard(StationCodec.of(BANK, NUMBER, "never"), [encode_psm(message)])
    assert found.kind.tolist() == [KINDS_OF_TYPES[basic_type]]
    assert found.reading.tolist() == [UpdateReading.PLAIN]
    assert tuple(found.core[0].tolist()) == part_one_of(message).codes
    assert found.core[0, CORE_INDEX["yaw_rate_radps"]] == (100 if accelerates else 0)
    assert found.core[0, CORE_INDEX["elevation_m"]] == (2000 if has_elevation else -4096)


def test_golden_octets_of_a_cyclist_with_a_model() -> None:
    """CTRA of a cyclist: 29 octets with the acceleration set 35, the extension's 7, the count's two bits."""
    codec = StationCodec.of(BANK, NUMBER, "on-failure", kind=Kind.CYCLIST)
    (octets,) = written(codec, rows_of([0]))
    assert octets.hex() == GOLDEN
    assert len(octets) == 42


def test_every_bent_bit_is_refused_or_read_alike() -> None:
    """The compiled reader never disagrees with the one that explains: the same is read, or both refuse."""
    codec = StationCodec.of(BANK, NUMBER, "on-failure", kind=Kind.PEDESTRIAN)
    (octets,) = written(codec, rows_of([0]))
    whole, width = int.from_bytes(octets, "big"), 8 * len(octets)
    bent = [(whole ^ 1 << bit).to_bytes(len(octets), "big") for bit in range(width)]
    found = heard(codec, bent)
    read = 0
    for row, one in enumerate(bent):
        if found.reading[row] == UpdateReading.FAULTY:
            with pytest.raises(CodecError):
                read_update(one, {NUMBER: codec.profile})
            continue
        told = read_update(one, {NUMBER: codec.profile})
        read += 1
        assert (told.kind, told.core.codes) == (found.kind[row], tuple(found.core[row].tolist()))
    assert 0 < read < width


def test_a_fault_in_a_model_is_told_at_its_bit() -> None:
    """A sub-model that the profile has not: behind region, length and profile number."""
    codec = StationCodec.of(BANK, NUMBER, "on-failure", kind=Kind.PEDESTRIAN)
    message = decode_psm(written(codec, rows_of([0]))[0])
    ((region, model),) = message.regional
    begin = 8 * 3 + HEADS[2].bits + 2 + 8 + 8
    strange = bytes([*model[:3], model[3] | 0xE0, *model[4:]])
    bad = PersonalSafetyMessage(
        message.codes, has_elevation=False, acceleration=message.acceleration, regional=((region, strange),)
    )
    with pytest.raises(CodecError, match="sub-model 7 of 2") as refused:
        read_update(encode_psm(bad), {NUMBER: codec.profile})
    assert refused.value.offset_bits == begin + 24


def test_kinds_that_state_no_motion_have_no_message() -> None:
    for refused in (
        lambda: heads_of_members(BANK, Kind.ROADSIDE, carries_all=False),
        lambda: SizeModel(kind=Kind.ROADSIDE),
        lambda: StationCodec.of(BANK, NUMBER, "never", kind=Kind.ROADSIDE),
    ):
        with pytest.raises(ValueError, match="states its motion"):
            refused()


def test_an_update_codec_takes_basic_safety_messages_only() -> None:
    codec = StationCodec.of(BANK, NUMBER, "on-failure", kind=Kind.CYCLIST)
    with pytest.raises(CodecError, match="personal safety message"):
        UpdateCodec(codec.profile, carries_all=True).decode(written(codec, rows_of([0]))[0])

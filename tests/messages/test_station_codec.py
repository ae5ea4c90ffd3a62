"""Claims about the messages of stations between content and octets."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from modelcast.core.arrays import FloatArray
from modelcast.core.exceptions import CodecError
from modelcast.messages.bsm import BasicSafetyMessage, BsmCore, decode_bsm, encode_bsm, encode_message
from modelcast.messages.bsm_fields import CORE_INDEX
from modelcast.messages.mbc_codec import UpdateCodec
from modelcast.messages.mbc_update import UpdateReading, read_update
from modelcast.messages.sizes import SizeModel
from modelcast.messages.station_codec import (
    IdentificationRows,
    StationCodec,
    UpdateRows,
    further_values,
)
from modelcast.models.bank import Bank
from modelcast.models.payload import CORE_PARAMETERS
from modelcast.station.banks import bank_from_text

BANKS = {
    "learned": bank_from_text("learned+ctra+gp-vehicle+cv"),
    "paper": bank_from_text("paper"),
    "ctra": bank_from_text("ctra"),
    "cv": bank_from_text("cv"),
    "gp-intercept+cv": bank_from_text("gp-intercept+cv"),
    "gp-regime-1+learned+ctra": bank_from_text("gp-regime-1+learned+ctra"),
}
CODECS = {
    (name, identify): StationCodec.of(bank, 0x44136F, identify)
    for name, bank in BANKS.items()
    for identify in ("never", "on-failure")
}
cases = pytest.mark.parametrize("case", CODECS, ids="-".join)

motions = st.tuples(st.floats(-60, 60), st.floats(-60, 60), st.floats(-25, 25), st.floats(-7, 7))
seeds = st.integers(0, 10_000)


def some_parameters(codec: StationCodec, motion: tuple[float, ...], seed: int) -> FloatArray:
    """Coefficients of every size, and one motion for all sub-models: what a fit returns."""
    rng = np.random.default_rng(seed)
    spread = 10.0 ** rng.uniform(-2.0, 3.0, len(codec.table.names))
    parameters = rng.normal(0.0, spread)
    for i, name in enumerate(codec.table.names):
        own = name.split(".")[1]
        if own in CORE_PARAMETERS:
            parameters[i] = motion[CORE_PARAMETERS.index(own)]
    return parameters


def some_rows(codec: StationCodec, motion: tuple[float, ...], seed: int) -> UpdateRows:
    count = len(codec.plain)
    return UpdateRows(
        np.arange(count) + 4_000_000_000,
        np.arange(count) + 126,
        np.arange(count) * 59.9 + 1000.25,
        place=np.array([[423_000_000 + i, -1_800_000_000 + 1 + i] for i in range(count)]),
        in_use=np.arange(count),
        parameters=np.stack([some_parameters(codec, motion, seed + i) for i in range(count)]),
    )


def motion_of(motion: tuple[float, ...]) -> FloatArray:
    east, north, acceleration, yaw_rate = motion
    return further_values(
        {
            "speed_mps": float(np.hypot(east, north)),
            "heading_rad": float(np.arctan2(east, north)),
            "acceleration_forward_mps2": acceleration,
            "yaw_rate_radps": yaw_rate,
            "length_m": 4.5,
        }
    )


@cases
@settings(max_examples=30)
@given(motion=motions, seed=seeds)
def test_the_receiver_holds_what_the_sender_holds_bit_for_bit(
    case: tuple[str, str], motion: tuple[float, ...], seed: int
) -> None:
    codec = CODECS[case]
    rows = some_rows(codec, motion, seed)
    further = motion_of(motion)
    frames, lengths = codec.encode(rows, further=further)
    heard = codec.decode(frames, lengths, received_s=rows.t_s + 0.3)
    _, held = codec.table.quantise(rows.parameters)
    for row, in_use in enumerate(rows.in_use.tolist()):
        carried = range(len(codec.plain)) if codec.carries_all else [in_use]
        for m in carried:
            own = slice(codec.table.offsets[m], codec.table.offsets[m + 1])
            assert heard.rows.parameters[row, own].tobytes() == held[row, own].tobytes()
        assert heard.reading[row] == (UpdateReading.PLAIN if codec.plain[in_use] else UpdateReading.MODEL)
    assert heard.rows.in_use.tolist() == rows.in_use.tolist()
    assert heard.rows.vehicle.tolist() == rows.vehicle.tolist()
    assert heard.rows.message_count.tolist() == (rows.message_count % 128).tolist()
    assert heard.rows.place.tolist() == rows.place.tolist()
    assert np.abs(heard.rows.t_s - rows.t_s).max() <= 0.0005 + 1e-9
    assert (heard.core[:, CORE_INDEX["length_m"]] == 450).all()
    again = replace(rows, parameters=heard.rows.parameters, t_s=heard.rows.t_s)
    if codec.carries_all:
        assert codec.encode(again, further=further)[0].tobytes() == frames.tobytes()


@cases
@settings(max_examples=10)
@given(motion=motions, seed=seeds)
def test_the_octets_are_those_of_one_message_at_a_time(
    case: tuple[str, str], motion: tuple[float, ...], seed: int
) -> None:
    codec = CODECS[case]
    rows = some_rows(codec, motion, seed)
    further = motion_of(motion)
    frames, lengths = codec.encode(rows, further=further)
    codes = codec.codes(rows, further=further)
    for row, in_use in enumerate(rows.in_use.tolist()):
        octets = frames[row, : lengths[row]].tobytes()
        assert not frames[row, lengths[row] :].any()
        message = codec.message(codes[row], in_use)
        if codec.plain[in_use]:
            assert octets == encode_bsm(message.core)
        else:
            assert octets == UpdateCodec(codec.profile).encode(message)
            assert read_update(octets, {codec.profile.number: codec.profile}).update == message
    wanted = SizeModel().each_update_bytes(BANKS[case[0]], case[1])
    assert lengths.tolist() == wanted.tolist()


def test_odd_messages_are_read_as_one_at_a_time() -> None:
    """Part II, other regions, additions, other profiles, damage: the compiled reading leaves them alone."""
    codec, motion = CODECS["learned", "never"], (9.0, 3.0, 1.0, 0.1)
    frames, lengths = codec.encode(some_rows(codec, motion, 3), further=motion_of(motion))
    octets = frames[0, : lengths[0]].tobytes()
    plain = decode_bsm(octets)
    ((_, model),) = plain.regional
    other = StationCodec.of(BANKS["learned"], 9, "never")
    foreign, _ = other.encode(some_rows(other, motion, 3), further=motion_of(motion))
    nowhere = BsmCore((*plain.core.codes[:3], 900_000_001, *plain.core.codes[4:]))
    messages: list[tuple[bytes, UpdateReading]] = [
        (octets, UpdateReading.MODEL),
        (encode_bsm(plain.core, part_ii=((0, bytes(130)),), regional=((128, model),)), UpdateReading.MODEL),
        (encode_bsm(plain.core, regional=((1, b"x"), (128, model))), UpdateReading.MODEL),
        (encode_bsm(plain.core, regional=((1, b"x"),)), UpdateReading.PLAIN),
        (encode_bsm(plain.core, part_ii=((2, b"more"),)), UpdateReading.PLAIN),
        (encode_message(BasicSafetyMessage(plain.core, frame_additions=(b"later",))), UpdateReading.PLAIN),
        (foreign[0, : lengths[0]].tobytes(), UpdateReading.UNKNOWN_PROFILE),
        (encode_bsm(nowhere, regional=((128, model),)), UpdateReading.INCOMPLETE),
        (encode_bsm(plain.core, regional=((128, model[:-1]),)), UpdateReading.FAULTY),
        (octets[:-1], UpdateReading.FAULTY),
        (b"", UpdateReading.FAULTY),
        (octets + b"\0", UpdateReading.FAULTY),
    ]
    batch = np.zeros((len(messages), 260), np.uint8)
    for row, (data, _) in enumerate(messages):
        batch[row, : len(data)] = np.frombuffer(data, np.uint8)
    sizes = np.array([len(data) for data, _ in messages])
    heard = codec.decode(batch, sizes, received_s=np.full(len(messages), 1000.3))
    assert heard.reading.tolist() == [reading for _, reading in messages]
    assert [row for row, _ in heard.faults] == [8, 9, 10, 11]
    held = heard.rows.parameters
    assert all(held[row].tobytes() == held[0].tobytes() for row in (1, 2))
    coasting = [member.name for member in BANKS["learned"].members].index("ctra")
    assert heard.rows.in_use[:7].tolist() == [0, 0, 0, *[coasting] * 4]


@settings(max_examples=300)
@given(seed=seeds, case=st.sampled_from(sorted(CODECS)))
def test_damaged_octets_are_read_in_a_batch_as_alone(seed: int, case: tuple[str, str]) -> None:
    codec, rng = CODECS[case], np.random.default_rng(seed)
    motion = (9.0, 3.0, 1.0, 0.1)
    frames, lengths = codec.encode(some_rows(codec, motion, seed), further=motion_of(motion))
    at = rng.integers(lengths[0])
    frames[0, at] ^= rng.integers(1, 256)
    lengths[0] = lengths[0] if rng.random() < 0.7 else rng.integers(lengths[0] + 1)
    data = frames[0, : lengths[0]].tobytes()
    heard = codec.decode(frames[:1], lengths[:1], received_s=np.array([1000.3]))
    try:
        read = read_update(data, {codec.profile.number: codec.profile})
    except CodecError as fault:
        assert heard.reading[0] == UpdateReading.FAULTY
        assert str(heard.faults[0][1]) == str(fault)  # noqa: PT017 - most octets are refused
        return
    assert heard.core[0].tolist() == list(read.message.core.codes)
    assert (heard.reading[0] == UpdateReading.MODEL) <= (read.update is not None)
    if read.update is not None:
        assert heard.rows.in_use[0] == read.update.sub_model
    if heard.reading[0] == UpdateReading.MODEL:
        assert read.update is not None
        whole = replace(codec, carries_all=read.update.carries_all, plain=(False,) * len(codec.plain))
        codes, _ = codec.table.quantise(heard.rows.parameters)
        found = whole.message(np.concatenate([heard.core[0], codes[0]]), read.update.sub_model)
        assert found.codes == read.update.codes


def test_a_sub_model_without_a_velocity_takes_that_of_another_or_what_is_given_beside() -> None:
    codec = CODECS["gp-regime-1+learned+ctra", "never"]
    rows = some_rows(codec, (9.0, 3.0, 1.0, 0.1), 3)
    first = replace(rows, **{name: getattr(rows, name)[:1] for name in rows.__slots__ if name != "_"})
    bounds = codec.table.offsets
    parameters = first.parameters.copy()
    parameters[0, bounds[1] :] = 0.0  # neither has a full window
    alone = replace(first, parameters=parameters)
    speed, heading = CORE_INDEX["speed_mps"], CORE_INDEX["heading_rad"]
    assert codec.codes(alone)[0, [speed, heading]].tolist() == [0, 0]
    given_beside = codec.codes(alone, further=motion_of((0.0, 5.0, 1.0, 0.1)))
    assert given_beside[0, [speed, heading]].tolist() == [250, 0]
    parameters[0, bounds[2] : bounds[2] + 2] = 5.0, 0.0
    of_another = codec.codes(replace(first, parameters=parameters), further=motion_of((0.0, 7.0, 1.0, 0.1)))
    assert of_another[0, [speed, heading]].tolist() == [250, 7200]


def test_a_bank_without_a_velocity_needs_one_beside() -> None:
    codec = StationCodec.of(bank_from_text("gp-regime-1"), 5, "never")
    rows = some_rows(codec, (9.0, 3.0, 1.0, 0.1), 3)
    with pytest.raises(ValueError, match="row 0: no velocity is known, and Part I needs one"):
        codec.encode(rows)
    frames, lengths = codec.encode(rows, further=motion_of((9.0, 3.0, 1.0, 0.1)))
    heard = codec.decode(frames, lengths, received_s=rows.t_s)
    assert heard.rows.parameters.tobytes() == codec.table.quantise(rows.parameters)[1].tobytes()


def test_sub_models_sent_together_that_disagree_about_part_i_are_refused() -> None:
    bank = bank_from_text("ctra+cv")
    parameters = np.array([[9.0, 3.0, 1.0, 0.1, 9.0, 3.1]])
    rows = UpdateRows(
        np.array([7]),
        np.array([1]),
        np.array([5.0]),
        place=np.array([[1, 2]]),
        in_use=np.array([0]),
        parameters=parameters,
    )
    with pytest.raises(ValueError, match=r"row 0: cv.velocity_(east|north)_mps is not that of Part I"):
        StationCodec.of(bank, 5, "on-failure").encode(rows)
    assert StationCodec.of(bank, 5, "never").encode(rows)[1].tolist() == [40]
    waiting = replace(rows, parameters=np.array([[9.0, 3.0, 1.0, 0.1, 0.0, 0.0]]))
    assert StationCodec.of(bank, 5, "on-failure").encode(waiting)[1].tolist() == [47]


def test_a_vehicle_that_stands_says_the_heading_it_is_given() -> None:
    codec = StationCodec.of(Bank(BANKS["cv"].members), 5, "never")
    rows = replace(some_rows(codec, (0.0, 0.001, 0, 0), 1), t_s=np.array([5.0]))
    heading = CORE_INDEX["heading_rad"]
    assert codec.codes(rows)[0, heading] == 0
    told = codec.codes(rows, further=further_values({"heading_rad": np.pi}))
    assert told[0, heading] == 14_400
    frames, lengths = codec.encode(rows, further=further_values({"heading_rad": np.pi}))
    heard = codec.decode(frames, lengths, received_s=np.array([5.0]))
    assert heard.rows.parameters.tobytes() == np.zeros((1, 2)).tobytes()
    assert heard.core[0, heading] == 14_400


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"place": np.array([[900_000_001, 0]])}, "row 0: no position"),
        ({"place": np.array([[0, -1_800_000_000]])}, "row 0: no position"),
        ({"vehicle": np.array([-1])}, "temporary_id"),
        ({"in_use": np.array([1])}, "in_use"),
        ({"parameters": np.array([[np.nan, 0.0]])}, "row 0: cv.velocity_east_mps is not a number"),
    ],
)
def test_content_that_no_message_can_say_is_refused(change: dict[str, object], match: str) -> None:
    codec = CODECS["cv", "never"]
    with pytest.raises(ValueError, match=match):
        codec.encode(replace(some_rows(codec, (1.0, 2.0, 0, 0), 1), **change))  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="no field is called"):
        further_values({"speed": 1.0})


def test_identifications_come_back() -> None:
    rows = IdentificationRows(
        np.array([1, 2**32 - 1]), np.array([7, 300]), in_use=np.array([2, 0]), age_s=np.array([1.3, 0.0])
    )
    found = IdentificationRows.decode(rows.encode())
    assert found.vehicle.tolist() == [1, 2**32 - 1]
    assert found.message_count.tolist() == [7, 300 % 128]
    assert (found.in_use.tolist(), found.age_s.tolist()) == ([2, 0], [1.3, 0.0])
    with pytest.raises(ValueError, match="row 1: an identification is no older"):
        replace(rows, age_s=np.array([1.0, -0.1])).encode()

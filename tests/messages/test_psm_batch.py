"""Claims about messages of people in batch: they are the single messages, fault for fault."""

import numpy as np
import pytest

from modelcast.core.exceptions import CodecError
from modelcast.messages.psm import PersonalSafetyMessage, decode_psm, encode_psm
from modelcast.messages.psm_batch import (
    decode_people,
    encode_people,
    person_codes_of_values,
    person_values_of_codes,
)
from modelcast.messages.psm_codec import PsmCodec
from modelcast.messages.psm_fields import PERSON_FIELDS, PERSON_INDEX

ROWS = 2000
ELEVATION = PERSON_INDEX["elevation_m"]
UNKNOWN_ELEVATION = -4096


@pytest.fixture(scope="module")
def people() -> tuple[np.ndarray, np.ndarray]:
    """Random codes of the whole range, and whether the elevation is there."""
    rng = np.random.default_rng(27)
    codes = np.stack([rng.integers(field.low, field.high + 1, ROWS) for field in PERSON_FIELDS], axis=1)
    has_elevation = rng.random(ROWS) < 0.5
    codes[~has_elevation, ELEVATION] = UNKNOWN_ELEVATION
    return codes, has_elevation


def test_a_row_of_a_batch_is_the_single_message(people: tuple[np.ndarray, np.ndarray]) -> None:
    codes, has_elevation = people
    frames, lengths = encode_people(codes, has_elevation)
    assert lengths.tolist() == np.where(has_elevation, 31, 29).tolist()
    rows = zip(codes.tolist(), has_elevation.tolist(), frames, lengths.tolist(), strict=True)
    for row, there, frame, length in rows:
        message = PersonalSafetyMessage(tuple(row), has_elevation=there)
        assert frame[:length].tobytes() == encode_psm(message)
        assert not frame[length:].any()
    found = decode_people(frames, lengths)
    assert np.array_equal(found.codes, codes)
    assert np.array_equal(found.has_elevation, has_elevation)
    assert (found.fault_bits == -1).all()
    assert not found.more.any()


def test_the_elevation_is_written_where_nothing_else_is_said(people: tuple[np.ndarray, np.ndarray]) -> None:
    codes, _ = people
    frames, lengths = encode_people(codes[:5])
    assert lengths.tolist() == [31] * 5
    assert decode_people(frames, lengths).has_elevation.all()


def test_faults_are_those_of_the_single_message_at_the_same_bits(
    people: tuple[np.ndarray, np.ndarray],
) -> None:
    """Random octets in the header, anywhere, rows cut short and rows too long."""
    rng = np.random.default_rng(9)
    written, lengths = encode_people(*people)
    frames = np.zeros((ROWS, 36), np.uint8)
    frames[:, : written.shape[1]] = written
    for row in range(ROWS):
        for _ in range(rng.integers(0, 3)):
            frames[row, rng.integers(0, 36 if row % 2 else 6)] = rng.integers(0, 256)
        if row % 4 == 0:
            lengths[row] = rng.integers(0, 37)
        if row % 8 == 0:  # cut short inside, too
            frames[row, 2] = max(int(lengths[row]) - 3, 0)
    found = decode_people(frames, lengths)
    faulty = more = 0
    for row in range(ROWS):
        octets = frames[row, : lengths[row]].tobytes()
        try:
            message, fault = decode_psm(octets), -1
        except CodecError as refusal:
            message, fault = None, refusal.offset_bits
        faulty += fault >= 0
        if found.more[row]:
            more += 1
            # What follows is for the single decoder; up to there no fault was found.
            assert found.fault_bits[row] == -1
            assert message is None or message.codes == tuple(found.codes[row].tolist())
            continue
        assert found.fault_bits[row] == fault
        assert tuple(found.codes[row].tolist()) == (message.codes if message else (0,) * len(PERSON_FIELDS))
        assert found.has_elevation[row] == (message is not None and message.has_elevation)
    assert 0.3 < faulty / ROWS < 0.95
    assert more > ROWS / 100


def test_every_bit_of_a_message_bent_alone_is_judged_as_by_the_single_decoder() -> None:
    codes = np.array([[field.high for field in PERSON_FIELDS], [field.low for field in PERSON_FIELDS]])
    frames, lengths = encode_people(codes, np.array([True, False]))
    for frame, length in zip(frames, lengths.tolist(), strict=True):
        bent = np.repeat(frame[None, :length], 8 * length, axis=0)
        for bit in range(8 * length):
            bent[bit, bit // 8] ^= 0x80 >> bit % 8
        found = decode_people(bent, np.full(len(bent), length))
        for row, octets in enumerate(bent):
            if found.more[row]:
                continue
            try:
                fault = decode_psm(octets.tobytes()) and -1
            except CodecError as refusal:
                fault = refusal.offset_bits
            assert found.fault_bits[row] == fault


def test_what_follows_is_told_and_not_looked_at(people: tuple[np.ndarray, np.ndarray]) -> None:
    codes, has_elevation = people
    extras = (
        {"acceleration": (1, 2, 3, 4)},
        {"parts": (("animal_type", 3),)},
        {"regional": ((128, b"model"),)},
        {"additions": (b"later",)},
        {"frame_additions": (b"later",)},
    )
    octets = [
        encode_psm(PersonalSafetyMessage(tuple(row), has_elevation=there, **extra))
        for row, there, extra in zip(codes.tolist(), has_elevation.tolist(), extras, strict=False)
    ]
    frames = np.zeros((len(extras), 60), np.uint8)
    for row, one in enumerate(octets):
        frames[row, : len(one)] = np.frombuffer(one, np.uint8)
    found = decode_people(frames, np.array([len(one) for one in octets]))
    assert found.fault_bits.tolist() == [-1] * len(extras)
    assert found.more.all()
    assert np.array_equal(found.codes, codes[: len(extras)])


def test_codes_and_values_of_a_batch_are_those_of_each_field(people: tuple[np.ndarray, np.ndarray]) -> None:
    values = person_values_of_codes(people[0])
    for column, field in enumerate(PERSON_FIELDS):
        told = [field.value_of(code) for code in people[0][:, column].tolist()]
        assert np.array_equal(values[:, column], np.array(told, dtype=float), equal_nan=True)
    again = person_codes_of_values(values)
    assert np.array_equal(person_values_of_codes(again), values, equal_nan=True)
    assert np.array_equal(PsmCodec().quantise(values), values, equal_nan=True)


def test_an_empty_batch_is_a_batch() -> None:
    frames, lengths = encode_people(person_codes_of_values(np.empty((0, len(PERSON_FIELDS)))))
    assert frames.shape == (0, 31)
    assert decode_people(frames, lengths).codes.shape == (0, len(PERSON_FIELDS))


def test_what_cannot_be_written_is_refused_with_its_row(people: tuple[np.ndarray, np.ndarray]) -> None:
    wrong = people[0].copy()
    wrong[5, PERSON_INDEX["speed_mps"]] = 8192
    with pytest.raises(ValueError, match="row 5: speed_mps: code 8192"):
        encode_people(wrong)
    wrong = people[0].copy()
    wrong[3, ELEVATION] = 0
    with pytest.raises(
        ValueError, match="row 3: elevation_m: code must be -4096 where it is left out, got 0"
    ):
        encode_people(wrong, np.arange(ROWS) != 3)
    with pytest.raises(ValueError, match="row 0: message_count"):
        person_codes_of_values(np.full((1, len(PERSON_FIELDS)), np.nan))


def test_arrays_that_do_not_fit_are_refused(people: tuple[np.ndarray, np.ndarray]) -> None:
    with pytest.raises(ValueError, match="one column a field"):
        encode_people(np.zeros((2, 11), np.int64))
    with pytest.raises(ValueError, match="has_elevation must be"):
        encode_people(people[0], np.ones(3, np.bool_))
    with pytest.raises(ValueError, match="do not fit"):
        decode_people(np.zeros((2, 31), np.uint8), np.array([31]))
    with pytest.raises(ValueError, match=r"0\.\.31"):
        decode_people(np.zeros((1, 31), np.uint8), np.array([32]))

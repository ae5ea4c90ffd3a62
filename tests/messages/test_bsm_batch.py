"""Claims about messages in batch: they are the single messages, fault for fault."""

import numpy as np
import pytest

from modelcast.core.exceptions import CodecError
from modelcast.messages.bsm import BasicSafetyMessage, BsmCore, decode_bsm, encode_bsm, encode_message
from modelcast.messages.bsm_batch import codes_of_values, decode_cores, encode_cores, values_of_codes
from modelcast.messages.bsm_codec import BsmCodec
from modelcast.messages.bsm_fields import CORE_FIELDS, CORE_INDEX
from modelcast.messages.fields import Outside

ROWS = 2000


@pytest.fixture(scope="module")
def codes() -> np.ndarray:
    """Random codes of the whole range."""
    rng = np.random.default_rng(7)
    return np.stack([rng.integers(field.low, field.high + 1, ROWS) for field in CORE_FIELDS], axis=1)


@pytest.fixture(scope="module")
def values() -> np.ndarray:
    """Values within the range, beyond it, at halves of steps, endless and unknown."""
    rng = np.random.default_rng(8)
    columns = []
    for field in CORE_FIELDS:
        if field.outside is Outside.REFUSE:
            columns.append(rng.integers(*field.known_codes, ROWS, endpoint=True).astype(float))
            continue
        reach = 1.5 * max(abs(field.low), abs(field.high))
        column = rng.integers(-2 * reach, 2 * reach, ROWS) / 2 * field.resolution
        column[:6] = -np.inf, np.inf, 1e300, -1e300, 1e308, 0.0
        if field.unavailable is not None:
            column[rng.random(ROWS) < 0.1] = np.nan
        columns.append(column)
    return np.stack(columns, axis=1)


def test_a_row_of_a_batch_is_the_single_message(codes: np.ndarray) -> None:
    frames, lengths = encode_cores(codes)
    assert set(lengths.tolist()) == {40}
    for row, frame in zip(codes.tolist(), frames, strict=True):
        assert frame.tobytes() == encode_bsm(BsmCore(tuple(row)))
    found = decode_cores(frames, lengths)
    assert np.array_equal(found.codes, codes)
    assert (found.fault_bits == -1).all()
    assert not found.more.any()


def test_codes_and_values_of_a_batch_are_those_of_each_field(values: np.ndarray) -> None:
    codes = codes_of_values(values)
    back = values_of_codes(codes)
    for index, field in enumerate(CORE_FIELDS):
        assert codes[:, index].tolist() == [field.code_of(value) for value in values[:, index].tolist()]
        told = [field.value_of(code) for code in codes[:, index].tolist()]
        assert np.array_equal(back[:, index], np.array(told, dtype=float), equal_nan=True)


def test_quantised_values_are_what_a_receiver_decodes_and_stay_as_they_are(values: np.ndarray) -> None:
    codec = BsmCodec()
    held = codec.quantise(values)
    for sent, one in zip(values[:200].tolist(), held, strict=False):
        core = BsmCore(tuple(f.code_of(value) for f, value in zip(CORE_FIELDS, sent, strict=True)))
        told = list(codec.decode(codec.encode(BasicSafetyMessage(core))).core.values().values())
        assert np.array_equal(one, np.array(told, dtype=float), equal_nan=True)
    assert np.array_equal(codec.quantise(held), held, equal_nan=True)
    assert codec.sizes(values).tolist() == [40] * ROWS


def test_faults_are_those_of_the_single_message_at_the_same_bits(codes: np.ndarray) -> None:
    """Random octets in the header, anywhere, rows cut short and rows too long."""
    rng = np.random.default_rng(9)
    frames = np.zeros((ROWS, 44), np.uint8)
    frames[:, :40] = encode_cores(codes)[0]
    lengths = np.full(ROWS, 40)
    for row in range(ROWS):
        for _ in range(rng.integers(0, 3)):
            frames[row, rng.integers(0, 40 if row % 2 else 5)] = rng.integers(0, 256)
        if row % 4 == 0:
            lengths[row] = rng.integers(0, 45)
    found = decode_cores(frames, lengths)
    faulty = 0
    for row in range(ROWS):
        octets = frames[row, : lengths[row]].tobytes()
        try:
            message, fault = decode_bsm(octets), -1
        except CodecError as refusal:
            message, fault = None, refusal.offset_bits
        faulty += fault >= 0
        if found.more[row]:
            # What follows Part I is for the single decoder; up to there no fault was found.
            assert found.fault_bits[row] == -1
            assert message is None or message.core.codes == tuple(found.codes[row].tolist())
            continue
        assert found.fault_bits[row] == fault
        assert tuple(found.codes[row].tolist()) == (message.core.codes if message else (0,) * 25)
    assert 0.3 < faulty / ROWS < 0.95


def test_part_i_is_read_where_more_follows(codes: np.ndarray) -> None:
    cores = [BsmCore(tuple(row)) for row in codes[:3].tolist()]
    octets = [
        encode_bsm(cores[0], part_ii=((0, bytes(150)),)),
        encode_bsm(cores[1], regional=((128, b"model"),)),
        encode_message(BasicSafetyMessage(cores[2], frame_additions=(b"later",))),
    ]
    frames = np.zeros((3, 250), np.uint8)
    for row, one in enumerate(octets):
        frames[row, : len(one)] = np.frombuffer(one, np.uint8)
    found = decode_cores(frames, np.array([len(one) for one in octets]))
    assert found.fault_bits.tolist() == [-1, -1, -1]
    assert found.more.all()
    assert np.array_equal(found.codes, codes[:3])


def test_an_empty_batch_is_a_batch() -> None:
    nothing = np.empty((0, len(CORE_FIELDS)))
    frames, lengths = encode_cores(codes_of_values(nothing))
    assert frames.shape == (0, 40)
    assert decode_cores(frames, lengths).codes.shape == (0, len(CORE_FIELDS))


def test_what_cannot_be_written_is_refused_with_its_row(codes: np.ndarray, values: np.ndarray) -> None:
    wrong = codes.copy()
    wrong[5, CORE_INDEX["speed_mps"]] = 8192
    with pytest.raises(ValueError, match="row 5: speed_mps: code 8192"):
        encode_cores(wrong)
    unknown = values.copy()
    unknown[3, CORE_INDEX["yaw_rate_radps"]] = np.nan
    with pytest.raises(ValueError, match="row 3: yaw_rate_radps"):
        codes_of_values(unknown)
    unknown = values.copy()
    unknown[4, CORE_INDEX["message_count"]] = 128
    with pytest.raises(ValueError, match="row 4: message_count"):
        BsmCodec().quantise(unknown)


def test_arrays_that_do_not_fit_are_refused() -> None:
    with pytest.raises(ValueError, match="one column a field"):
        codes_of_values(np.zeros((2, 24)))
    with pytest.raises(ValueError, match="do not fit"):
        decode_cores(np.zeros((2, 40), np.uint8), np.array([40]))
    with pytest.raises(ValueError, match=r"0\.\.40"):
        decode_cores(np.zeros((1, 40), np.uint8), np.array([41]))

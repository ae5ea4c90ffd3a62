"""Claims about cooperative awareness messages as octets, checked bit by bit against the standard's layout."""

import sys
from threading import Thread
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from modelcast.core.exceptions import CodecError, MissingExtraError
from modelcast.messages import cam
from modelcast.messages.bits import BitReader
from modelcast.messages.cam import (
    CamLowFrequency,
    CooperativeAwarenessMessage,
    decode_cam,
    encode_cam,
    path_point,
)
from modelcast.messages.cam_fields import CAM_FIELDS, CAM_INDEX, CAM_ROLES, PATH_FIELDS

VALUES = {
    "station_id": 77,
    "generation_s": 1.0,
    "station_type": 5,
    "latitude_deg": 42.0,
    "longitude_deg": -83.0,
    "heading_rad": np.pi / 2,
    "speed_mps": 20.0,
    "length_m": 4.5,
    "width_m": 1.8,
    "acceleration_forward_mps2": 0.5,
    "yaw_rate_radps": np.deg2rad(1.0),
}
BARE = "02020000004d03e80059d5b340073a20d01ffffffc23b7743e00384fc3e87e02c88a9737feea018a00"
"""Of `VALUES`, read bit by bit in `test_the_octets_are_those_of_the_standard_field_by_field`."""

_FIELD_BITS = 64 + 3 + 9 + 63 + 36 + 24 + 2 + 7 + 19 + 23 + 19 + 16 + 14 + 3 + 20
"""Of the bare message up to its last field."""

codes = st.tuples(*(st.integers(field.low, field.high) for field in CAM_FIELDS))
points = st.tuples(*(st.integers(field.low, field.high) for field in PATH_FIELDS))
containers = st.builds(
    CamLowFrequency,
    st.sampled_from(CAM_ROLES),
    st.integers(0, 255),
    st.lists(points, max_size=40).map(tuple),
)
messages = st.builds(
    CooperativeAwarenessMessage,
    codes,
    low_frequency=st.none() | containers,
    model=st.none() | st.binary(min_size=1, max_size=300),
    version=st.sampled_from((1, 2)),
)


@settings(max_examples=60, deadline=None)
@given(messages)
def test_what_is_written_is_read_again(message: CooperativeAwarenessMessage) -> None:
    assert decode_cam(encode_cam(message)) == message


def test_the_octets_are_those_of_the_standard_field_by_field() -> None:
    """By hand: EN 302 637-2 in unaligned packed encoding rules, a field after another with its width."""
    octets = encode_cam(CooperativeAwarenessMessage.from_values(VALUES))
    assert octets.hex() == BARE
    reader = BitReader(octets)
    assert [reader.bits(8), reader.bits(8), reader.bits(32), reader.bits(16)] == [2, 2, 77, 1000]
    assert [reader.bits(1) for _ in range(3)] == [0, 0, 0]  # no additions, no low frequency, no special
    assert [reader.bits(1), reader.bits(8)] == [0, 5]  # station type
    assert [reader.bits(31) - 900_000_000, reader.bits(32) - 1_800_000_000] == [420_000_000, -830_000_000]
    assert [reader.bits(12), reader.bits(12), reader.bits(12)] == [4095, 4095, 3601]
    assert [reader.bits(20) - 100_000, reader.bits(4)] == [800_001, 15]
    assert [reader.bits(1), reader.bits(1)] == [0, 0]  # of two containers the vehicle's
    assert reader.bits(7) == 0  # nothing optional
    assert [reader.bits(12), reader.bits(7) + 1] == [900, 127]
    assert [reader.bits(14), reader.bits(7) + 1, reader.bits(2)] == [2000, 127, 0]
    assert [reader.bits(10) + 1, reader.bits(3), reader.bits(6) + 1] == [45, 4, 18]
    assert [reader.bits(9) - 160, reader.bits(7)] == [5, 102]
    assert [reader.bits(11) - 1023, reader.bits(3)] == [1023, 7]
    assert [reader.bits(1), reader.bits(2)] == [0, 2]  # curvature's mode is extensible, and unavailable
    assert [reader.bits(16) - 32766, reader.bits(4)] == [100, 8]
    reader.finish()


def test_a_model_is_the_first_addition_and_costs_its_octets_and_few_more() -> None:
    bare = encode_cam(CooperativeAwarenessMessage.from_values(VALUES))
    model = bytes(range(1, 12))
    octets = encode_cam(CooperativeAwarenessMessage.from_values(VALUES, model=model))
    assert len(octets) == len(bare) + len(model) + 2
    reader = BitReader(octets)
    reader.bits(64)
    assert reader.bits(1) == 1
    reader.bits(_FIELD_BITS - 65)
    assert reader.additions() == (model,)


@pytest.mark.parametrize(("points_behind", "octets"), [(0, 43), (1, 52), (23, 241)])
def test_a_path_behind_is_most_of_a_message(points_behind: int, octets: int) -> None:
    """A point takes 18 + 18 + 15 + 17 bits and two that say what it has: 23 of them 196 octets."""
    point = path_point({"delta_latitude_deg": 1e-6, "delta_longitude_deg": -2e-6, "age_s": 0.3})
    container = CamLowFrequency(path=(point,) * points_behind)
    message = CooperativeAwarenessMessage.from_values(VALUES, low_frequency=container)
    assert len(encode_cam(message)) == octets
    assert decode_cam(encode_cam(message)).low_frequency == container


@pytest.mark.parametrize(
    "name", ["heading_rad", "speed_mps", "yaw_rate_radps", "latitude_deg", "generation_s"]
)
@settings(max_examples=20, deadline=None)
@given(value=st.floats(0.0, 1.5))
def test_a_value_is_written_to_the_nearest_step(name: str, value: float) -> None:
    message = CooperativeAwarenessMessage.from_values({**VALUES, name: value})
    read = decode_cam(encode_cam(message)).value(name)
    assert read == pytest.approx(value, abs=0.5001 * CAM_FIELDS[CAM_INDEX[name]].resolution)


def test_an_instant_is_kept_modulo_two_to_the_sixteenth_milliseconds() -> None:
    message = CooperativeAwarenessMessage.from_values({**VALUES, "generation_s": 700_000_000.25})
    assert message.value("generation_s") == pytest.approx(700_000_000_250 % 65_536 / 1000.0)


@pytest.mark.parametrize(
    "octets",
    [b"", b"\x02\x02", bytes.fromhex(BARE)[:-3], bytes.fromhex(BARE) + b"\x00", b"\xff" * 60,
     b"\x02\x01" + bytes.fromhex(BARE)[2:], b"\x09" + bytes.fromhex(BARE)[1:]],
)  # fmt: skip
def test_what_is_no_message_is_refused(octets: bytes) -> None:
    with pytest.raises(CodecError):
        decode_cam(octets)


@settings(max_examples=60, deadline=None)
@given(st.binary(max_size=80) | st.binary(max_size=60).map(lambda tail: bytes.fromhex(BARE)[:12] + tail))
def test_hostile_octets_are_a_message_or_a_codec_error(octets: bytes) -> None:
    try:
        decode_cam(octets)
    except CodecError:
        return


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: CooperativeAwarenessMessage((1, 2, 3)),
        lambda: CooperativeAwarenessMessage.from_values(VALUES, model=b""),
        lambda: CooperativeAwarenessMessage.from_values({**VALUES, "station_id": -1}),
        lambda: CooperativeAwarenessMessage.from_values({"station_id": 1}),
        lambda: CooperativeAwarenessMessage(tuple(0 for _ in CAM_FIELDS), version=3),
        lambda: CamLowFrequency("pilot"),
        lambda: CamLowFrequency(exterior_lights=256),
        lambda: CamLowFrequency(path=((0, 0, 0, 0),) * 41),
        lambda: CamLowFrequency(path=((0, 0, 0, -1),)),
    ],
)
def test_impossible_messages_are_refused(wrong: object) -> None:
    with pytest.raises(ValueError, match=r"must|not known|outside|codes"):
        wrong()  # type: ignore[operator]


@pytest.mark.parametrize("wrong", [BARE, 3, None, bytearray.fromhex(BARE)])
def test_what_is_no_bytes_or_no_message_is_told_by_the_argument_s_name(wrong: Any) -> None:
    with pytest.raises(
        TypeError, match=f"data must be of bytes, not {type(wrong).__name__}: give the octets"
    ):
        decode_cam(wrong)
    with pytest.raises(TypeError, match=f"message must be of .*, not {type(wrong).__name__}"):
        encode_cam(wrong)


def test_threads_do_not_mix_their_messages() -> None:
    """Types of pycrate hold a value while they encode it."""
    made = [CooperativeAwarenessMessage.from_values({**VALUES, "station_id": k}) for k in range(40)]
    expected, found = [encode_cam(one) for one in made], [b""] * len(made)

    def encode(k: int) -> None:
        found[k] = encode_cam(made[k])

    threads = [Thread(target=encode, args=(k,)) for k in range(len(made))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == expected


def test_without_pycrate_one_line_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pycrate_asn1dir.ITS_CAM_2", None)
    cam._library.cache_clear()
    with pytest.raises(MissingExtraError, match=r" install pycrate$"):
        encode_cam(CooperativeAwarenessMessage.from_values(VALUES))
    cam._library.cache_clear()

"""Claims about model updates and identifications on the wire."""

import hashlib
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from modelcast.core.exceptions import CodecError
from modelcast.core.geodesy import Origin, enu_to_surface, stated_local
from modelcast.messages.asn1 import reference_codec, reference_encode
from modelcast.messages.bsm import BsmCore, decode_bsm, encode_bsm
from modelcast.messages.bsm_batch import codes_of_values, values_of_codes
from modelcast.messages.bsm_fields import CORE_FIELDS, LOCAL_REGION
from modelcast.messages.fields import Outside
from modelcast.messages.mbc import ModelUpdate, SubModelIdentification
from modelcast.messages.mbc_codec import IdentificationCodec, UpdateCodec
from modelcast.messages.mbc_profile import WireProfile
from modelcast.messages.mbc_update import UpdateMessage, UpdateReading, extension_octets, read_update
from modelcast.messages.mbc_values import (
    LocalFrame,
    identification_from_wire,
    identification_to_wire,
    update_from_wire,
    update_to_wire,
)
from modelcast.messages.mbc_wire import (
    MAX_COEFFICIENT_OCTETS,
    IdentificationMessage,
    ModelExtension,
    decode_extension,
    decode_identification,
    encode_extension,
    encode_identification,
    profile_number,
)
from modelcast.messages.update_document import HeldProfile, model_document, octets_of_model, read_model
from modelcast.models.bank import Bank
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.gp import GaussianProcess, vehicle_process
from modelcast.models.kinematic import ConstantTurnRateAcceleration
from modelcast.models.payload import PayloadField, PayloadLayout
from modelcast.models.profile import Profile, default_profile
from modelcast.models.trusted import Trusted
from modelcast.runtime.trip.runtime import TripRuntime
from modelcast.station.banks import bank_from_text, member_names
from modelcast.station.receiver.heard import heard_messages
from modelcast.station.receiver.local_dynamic_map import LocalDynamicMap, Receipt
from modelcast.station.sensing.velocity import velocity_estimator_for
from modelcast.world.drive import generate_drive

TRAINED = default_profile().sub_model("gp-trained")

FRAME = LocalFrame(Origin(42.3, -83.7, 250.0), minute_s=-17.0)
ELSEWHERE = LocalFrame(Origin(42.31, -83.69, 0.0), minute_s=103.0)
SMALL = WireProfile(0x44136F, (PayloadLayout((PayloadField("x_m", 0.1, bits=5),)), PayloadLayout()))

GRID_M = 0.5e-7 * 111_700 * np.sqrt(2)
"""Half a step of latitude and longitude each."""

HEIGHT_M = 0.05
"""Local positions are of a plane, places of the ellipsoid under it, and both origins differ in height."""

TURNED = 2e-4
"""North of one frame against that of another, a kilometre away [rad]."""

ROUNDING_M = 1e-6

extensions = st.builds(
    ModelExtension,
    st.integers(0, 2**24 - 1),
    st.integers(0, 7),
    carries_all=st.booleans(),
    coefficients=st.binary(max_size=MAX_COEFFICIENT_OCTETS),
)
identifications = st.builds(
    IdentificationMessage,
    st.integers(0, 2**32 - 1),
    st.integers(0, 127),
    sub_model=st.integers(0, 7),
    age=st.integers(0, 16383),
)


def some_core() -> BsmCore:
    return BsmCore.from_values(
        {
            "message_count": 7,
            "temporary_id": 99,
            "second_of_minute_s": 12.3,
            "latitude_deg": 42.3,
            "longitude_deg": -83.7,
            "speed_mps": 10.0,
            "heading_rad": np.pi / 2,
            "yaw_rate_radps": 0.0,
        }
    )


@given(extensions)
def test_a_model_has_the_octets_that_asn1tools_gives_it(extension: ModelExtension) -> None:
    value = {
        "profile": extension.profile.to_bytes(3, "big"),
        "subModel": extension.sub_model,
        "carriesAll": extension.carries_all,
        "coefficients": extension.coefficients,
    }
    octets = encode_extension(extension)
    assert octets == reference_codec().encode("ModelExtension", value)
    assert reference_codec().decode("ModelExtension", octets) == value
    assert decode_extension(octets) == extension


@given(identifications)
def test_an_identification_has_the_octets_that_asn1tools_gives_it(message: IdentificationMessage) -> None:
    value = {
        "id": message.temporary_id.to_bytes(4, "big"),
        "sequence": message.sequence,
        "subModel": message.sub_model,
        "age": message.age,
    }
    inner = reference_codec().encode("SubModelIdentification", value)
    octets = encode_identification(message)
    assert octets == reference_codec().encode("MessageFrame", {"messageId": 240, "value": inner})
    assert len(octets) == 10
    assert decode_identification(octets) == message


@given(st.binary(max_size=40))
def test_any_octets_are_a_model_or_refused_within_them(data: bytes) -> None:
    for decode, encode in (
        (decode_extension, encode_extension),
        (decode_identification, encode_identification),
    ):
        try:
            again = encode(decode(data))  # type: ignore[operator]
        except CodecError as refusal:
            assert 0 <= refusal.offset_bits <= 8 * len(data)  # noqa: PT017 - most octets are refused
        else:
            assert again == data


def test_the_default_model_takes_at_most_24_octets_with_id_and_length() -> None:
    profile = default_profile()
    wire = WireProfile.of_profile(profile)
    sizes = [extension_octets(layout.bits) for layout in wire.layouts]
    assert max(sizes) <= 24
    codes = tuple(field.high for field in wire.layouts[0].fields)
    message = UpdateMessage(some_core(), 0, carries_all=False, codes=(codes,))
    (extension,) = decode_bsm(UpdateCodec(wire).encode(message)).regional
    assert 2 + len(extension[1]) == sizes[0]
    digest = hashlib.sha256(profile.named_bytes).hexdigest()
    assert f"{wire.number:06x}" == digest[:6] == profile.identity[:6]


@pytest.mark.parametrize("degree", [3, 4])
def test_processes_in_the_vehicles_frame_fit_into_24_octets_too(degree: int) -> None:
    layout = replace(vehicle_process(), degree=degree).payload_layout
    assert extension_octets(layout.bits) <= 24


def test_a_legacy_receiver_reads_the_update_as_a_basic_safety_message() -> None:
    octets = UpdateCodec(SMALL).encode(UpdateMessage(some_core(), 0, carries_all=False, codes=((3,),)))
    message = decode_bsm(octets)
    assert message.core == some_core()
    assert reference_encode(message) == octets


def test_an_unknown_profile_is_said_and_part_i_is_left_for_what_the_bank_coasts_it_by() -> None:
    octets = UpdateCodec(SMALL).encode(UpdateMessage(some_core(), 0, carries_all=False, codes=((3,),)))
    found = read_update(octets, {1: SMALL})
    assert found.reading is UpdateReading.UNKNOWN_PROFILE
    assert found.extension is not None
    assert found.extension.profile == SMALL.number
    bank = Bank((ConstantTurnRateAcceleration(), ConstantVelocity()), plain="cv")
    update = update_from_wire(found, bank, FRAME, received_s=60.0 - 17.0 + 12.4)
    assert bank.members[update.in_use].name == "cv"
    assert update.t_s == pytest.approx(60.0 - 17.0 + 12.3)
    np.testing.assert_allclose(update.parameters[-2:], [10.0, 0.0], atol=1e-9)
    around = LocalDynamicMap((bank,))
    receipts, state = around.hear(around.init(), heard_messages([update], [update.t_s + 0.1]))
    assert receipts.tolist() == [Receipt.ACCEPTED]
    where = around.positions(state, update.t_s + 2.0)[1][0]
    np.testing.assert_allclose(where - update.position_m, [20.0, 0.0], atol=1e-9)
    assert update_from_wire(found, Bank(bank.members), FRAME, received_s=0.0).in_use == 0
    with pytest.raises(ValueError, match="no member does with Part I"):
        update_from_wire(found, Bank((GaussianProcess(),)).carried(), FRAME, received_s=0.0)


def test_a_plain_message_has_no_model() -> None:
    found = read_update(encode_bsm(some_core(), regional=((129, b"x"),)), {SMALL.number: SMALL})
    assert found.reading is UpdateReading.PLAIN
    assert found.update is None


@pytest.mark.parametrize(
    ("extension", "reason", "bit"),
    [
        (encode_extension(ModelExtension(SMALL.number, 5)), "sub-model 5 of 2", 24),
        (encode_extension(ModelExtension(SMALL.number, 0)), "0 octets of coefficients, not 1", 28),
        (encode_extension(ModelExtension(SMALL.number, 1, coefficients=b"\0")), "1 octets of coeff", 28),
        (encode_extension(ModelExtension(SMALL.number, 0, coefficients=b"\1")), "padding", 40),
        (b"\0\0", "24 bits needed", 0),
        (encode_extension(ModelExtension(1, 0)) + b"\0", "left over", 40),
    ],
)
@pytest.mark.parametrize("part_ii", [(), ((0, bytes(3)),), ((0, bytes(200)), (1, b"x"))])
def test_a_damaged_model_is_refused_at_its_bit_of_the_frame(
    extension: bytes, reason: str, bit: int, part_ii: tuple[tuple[int, bytes], ...]
) -> None:
    regional = ((1, b"other"), (LOCAL_REGION, extension))
    octets = encode_bsm(some_core(), part_ii=part_ii, regional=regional)
    with pytest.raises(CodecError, match=reason) as caught:
        read_update(octets, {SMALL.number: SMALL})
    whole = int.from_bytes(octets, "big")
    begin = caught.value.offset_bits - bit
    found = whole >> 8 * len(octets) - begin - 8 * len(extension) & (1 << 8 * len(extension)) - 1
    assert found == int.from_bytes(extension, "big")


def test_a_codec_of_updates_refuses_other_messages() -> None:
    codec = UpdateCodec(SMALL)
    good = encode_extension(ModelExtension(SMALL.number, 1))
    for octets, reason in (
        (encode_bsm(some_core()), "no model"),
        (
            encode_bsm(some_core(), regional=((LOCAL_REGION, encode_extension(ModelExtension(3, 1))),)),
            "profile",
        ),
        (encode_bsm(some_core(), regional=((LOCAL_REGION, good), (LOCAL_REGION, good))), "more than"),
        (encode_bsm(some_core(), part_ii=((0, b"x"),), regional=((LOCAL_REGION, good),)), "more than"),
    ):
        with pytest.raises(CodecError, match=reason):
            codec.decode(octets)


def test_what_cannot_be_written_is_refused_with_its_bound() -> None:
    with pytest.raises(ValueError, match="profile"):
        ModelExtension(2**24, 0)
    with pytest.raises(ValueError, match="127 octets"):
        ModelExtension(0, 0, coefficients=bytes(128))
    with pytest.raises(ValueError, match="age"):
        IdentificationMessage(0, 0, sub_model=0, age=16384)
    with pytest.raises(ValueError, match=r"code 99 must lie within -16\.\.15"):
        UpdateCodec(SMALL).encode(UpdateMessage(some_core(), 0, carries_all=False, codes=((99,),)))
    with pytest.raises(ValueError, match="1 to 8"):
        WireProfile(0, ())
    with pytest.raises(ValueError, match="sub-model must be within"):
        UpdateCodec(SMALL).sizes(np.full((1, 27), 3.0))


@pytest.mark.parametrize("name", member_names(default_profile()))
def test_no_sub_model_takes_more_than_24_octets_with_id_and_length(name: str) -> None:
    (layout,) = WireProfile.of(bank_from_text(name), 0).layouts
    assert extension_octets(layout.bits) <= 24


def test_a_host_is_told_that_no_message_carries_weights() -> None:
    bank = Bank((GaussianProcess(), ConstantVelocity()))
    found = read_update(encode_bsm(some_core()), {})
    with pytest.raises(ValueError, match="carried form"):
        update_from_wire(found, bank, FRAME, received_s=0.0)
    assert update_from_wire(found, bank.carried(), FRAME, received_s=0.0).in_use == 1


def test_a_profile_with_a_bare_process_is_read_and_written_as_its_path() -> None:
    profile = Profile(Bank((GaussianProcess(), ConstantVelocity()), "bare"))
    held = HeldProfile.of(profile)
    codes = (5, -20, 100, -7, 0, 30, -400, 9)
    update = UpdateMessage(some_core(), 0, carries_all=False, codes=(codes,))
    octets = UpdateCodec(held.wire).encode(update)
    found = read_model(octets, (held,))
    assert found is not None
    assert found.name == "gp-anchored"
    assert list(found.coefficients["gp-anchored"].values()) == pytest.approx(
        [0.25, -2.0, 20.0, -1.4, 0.0, 3.0, -80.0, 1.8]
    )
    # At 2 s, half the span: velocity east, then the polynomial at one half.
    assert found.predicted_m is not None
    assert found.predicted_m[1] == pytest.approx((20.0 + 0.25 - 1.0 + 5.0 - 0.175, 1.5 - 20.0 + 0.225))
    ((_, extension),) = decode_bsm(octets).regional
    assert octets_of_model(model_document(found), some_core(), (held,)) == extension


@pytest.mark.parametrize("carries_all", [True, False])
@pytest.mark.parametrize("frame", [FRAME, ELSEWHERE], ids=["same frame", "another frame"])
def test_the_host_predicts_from_octets_what_the_sender_predicts(carries_all: bool, frame: LocalFrame) -> None:
    """The sender's decoded copy is the host's: to the grid's phase, which frames do not share."""
    drive = generate_drive(2, 90.0)
    processes = (
        vehicle_process(),
        GaussianProcess(),
        Trusted(TRAINED, 2.0),
    )
    given = Bank((*bank_from_text("learned+ctra").members, ConstantVelocity(), *processes), "all")
    plain = given.carried()
    sender = TripRuntime(drive.input, given, velocity_estimator_for(drive.input), quantised=True)
    wire = WireProfile.of(given, 5)
    at = np.arange(30, 590, 23)
    sender.fit_at(at)
    ages_s = np.array([0.0, 0.7, 2.5])
    for row, i in enumerate(at.tolist()):
        in_use = row % len(plain.members)
        update = ModelUpdate(
            4_000_000_000,
            300 + row,
            float(drive.input.t_s[i]),
            position_m=drive.input.position_m[i],
            in_use=in_use,
            parameters=sender.parameters[i],
            dt_s=drive.input.dt_s,
        )
        message = update_to_wire(update, sender.bank, wire, FRAME, carries_all=carries_all)
        received = read_update(UpdateCodec(wire).encode(message), {5: wire})
        held = update_from_wire(received, plain, frame, received_s=update.t_s + 0.2 - frame_delay(frame))
        assert (held.vehicle, held.sequence, held.in_use) == (4_000_000_000, (300 + row) % 128, in_use)
        own, others = (
            bank.predict(np.concatenate([[in_use], values])[None], ages_s, dt_s=0.1)[0]
            for bank, values in ((sender.bank, update.parameters), (plain, held.parameters))
        )
        begins = held.position_m + others[0], update.position_m + own[0]
        places = [
            enu_to_surface(np.array([[*east_north, 0.0]]), one.origin)
            for east_north, one in zip(begins, (frame, FRAME), strict=True)
        ]
        assert np.linalg.norm(places[0] - places[1]) <= 2 * GRID_M + HEIGHT_M
        moved = (others - others[0]) - (own - own[0])
        assert np.hypot(*moved.T).max() <= ROUNDING_M + TURNED * np.hypot(*(own - own[0]).T).max()


@given(
    east_m=st.floats(-50_000.0, 50_000.0), north_m=st.floats(-50_000.0, 50_000.0), latitude=st.floats(-80, 80)
)
@example(east_m=50_000.0, north_m=-50_000.0, latitude=60.0)
def test_the_host_holds_the_stated_position_bit_for_bit_and_says_it_again_alike(
    east_m: float, north_m: float, latitude: float
) -> None:
    """Seventy kilometres from the origin too, where the plane is 400 m above the ground."""
    bank, place = Bank((ConstantVelocity(),)), Origin(latitude, 179.9, 250.0)
    wire, frame = WireProfile.of(bank, 5), LocalFrame(place)
    sent = ModelUpdate(
        7, 1, 5.0, position_m=np.array([east_m, north_m]), in_use=0, parameters=np.array([9.0, 0.0]), dt_s=0.1
    )
    octets = UpdateCodec(wire).encode(update_to_wire(sent, bank, wire, frame, carries_all=False))
    held = update_from_wire(read_update(octets, {5: wire}), bank, frame, received_s=5.0)
    assert held.position_m.tobytes() == stated_local(sent.position_m[None], place)[0].tobytes()
    assert np.abs(held.position_m - sent.position_m).max() < GRID_M
    assert UpdateCodec(wire).encode(update_to_wire(held, bank, wire, frame, carries_all=False)) == octets


def test_a_position_beyond_the_frame_is_refused_by_sender_and_host() -> None:
    bank = Bank((ConstantVelocity(),))
    far = ModelUpdate(
        7, 1, 5.0, position_m=np.array([6e5, 0.0]), in_use=0, parameters=np.array([9.0, 0.0]), dt_s=0.1
    )
    with pytest.raises(ValueError, match="no place within 500 km"):
        update_to_wire(far, bank, WireProfile.of(bank, 5), FRAME, carries_all=False)
    found = read_update(encode_bsm(some_core()), {})
    with pytest.raises(ValueError, match="no place within 500 km"):
        update_from_wire(found, bank, LocalFrame(Origin(-42.3, 96.3)), received_s=0.0)


def frame_delay(frame: LocalFrame) -> float:
    """What the clocks of both sides differ by; whole minutes are left out."""
    return (FRAME.minute_s - frame.minute_s) % 60.0


def test_an_identification_reaches_the_host() -> None:
    bank = Bank((ConstantTurnRateAcceleration(), ConstantVelocity()))
    sent = ModelUpdate(
        7, 130, 5.0, position_m=np.zeros(2), in_use=0, parameters=np.array([9.0, 0, 1, 0, 9, 0]), dt_s=0.1
    )
    wire = WireProfile.of(bank, 5)
    octets = UpdateCodec(wire).encode(update_to_wire(sent, bank, wire, FRAME, carries_all=True))
    held = update_from_wire(read_update(octets, {5: wire}), bank, FRAME, received_s=5.1)
    around = LocalDynamicMap((bank,))
    named = identification_to_wire(SubModelIdentification(7, 130, 6.26, in_use=1), sent)
    read = identification_from_wire(decode_identification(encode_identification(named)), held)
    assert read.t_s == pytest.approx(6.26)
    receipts, state = around.hear(around.init(), heard_messages([held, read], [5.1, 6.3]))
    assert receipts.tolist() == [Receipt.ACCEPTED, Receipt.ACCEPTED]
    assert around.believe(state, 7.0).in_use.tolist() == [1]
    with pytest.raises(ValueError, match="older"):
        identification_to_wire(SubModelIdentification(7, 130, 4.0, in_use=1), sent)


def test_a_profile_is_named_by_its_bytes() -> None:
    assert f"{profile_number(b'{}'):06x}" == hashlib.sha256(b"{}").hexdigest()[:6]


def test_nothing_is_coasted_from_without_a_position() -> None:
    core = BsmCore(
        tuple(field.low if field.unavailable is None else field.unavailable for field in CORE_FIELDS)
    )
    found = read_update(encode_bsm(core), {})
    with pytest.raises(ValueError, match="latitude_deg"):
        update_from_wire(found, Bank((ConstantVelocity(),)), FRAME, received_s=0.0)


@pytest.mark.parametrize(
    ("row", "match"),
    [
        ((-1.0, 7.0, 2.0, 1.3), "temporary_id"),
        ((1.0, 128.0, 2.0, 1.3), "sequence"),
        ((1.0, 7.0, 2.5, 1.3), "sub_model"),
        ((1.0, 7.0, np.nan, 1.3), "sub_model"),
        ((1.0, 7.0, 2.0, np.nan), "age_s"),
    ],
)
def test_an_identification_that_cannot_be_written_is_refused_singly_and_in_batch(
    row: tuple[float, ...], match: str
) -> None:
    codec = IdentificationCodec()
    with pytest.raises(ValueError, match=match):
        codec.message_of(row)
    with pytest.raises(ValueError, match=match):
        codec.quantise(np.array([[1.0, 7.0, 2.0, 1.3], row]))


def test_identifications_in_batch_have_four_columns() -> None:
    with pytest.raises(ValueError, match=r"\(B, 4\)"):
        IdentificationCodec().sizes(np.zeros((2, 3)))


@pytest.mark.parametrize(
    ("column", "value", "match"),
    [
        (0, 128.0, "row 1: message_count"),
        (16, np.nan, "row 1: yaw_rate_radps"),
        (len(CORE_FIELDS), 2.0, "sub-model"),
        (len(CORE_FIELDS) + 1, np.nan, "row 1: every coefficient"),
    ],
)
def test_a_row_of_a_batch_that_cannot_be_written_is_told(column: int, value: float, match: str) -> None:
    codec = UpdateCodec(SMALL)
    rows = np.zeros((3, len(CORE_FIELDS) + 2))
    rows[1, column] = value
    with pytest.raises(ValueError, match=match):
        codec.quantise(rows)


@pytest.mark.parametrize("carries_all", [False, True])
def test_the_compiled_rounding_is_that_of_the_fields_and_layouts(carries_all: bool) -> None:
    rng = np.random.default_rng(11)
    rows = np.zeros((400, len(CORE_FIELDS) + 2))
    for column, field in enumerate(CORE_FIELDS):
        low, high = (1.2 * code * field.resolution for code in field.known_codes)
        refused = field.outside is Outside.REFUSE
        rows[:, column] = 0.0 if refused else rng.uniform(min(low, -1.0), high, len(rows))
        if not refused and field.unavailable is not None:
            rows[::9, column] = np.nan
    rows[:, -2] = rng.integers(0, 2, len(rows))
    rows[:, -1] = rng.uniform(-3.0, 3.0, len(rows))
    rows[0, -2:] = 0.0, 1e308
    core = values_of_codes(codes_of_values(rows[:, : len(CORE_FIELDS)]))
    coefficients = SMALL.layouts[0].quantise(rows[:, -1:])
    if not carries_all:
        coefficients[rows[:, -2] != 0.0] = np.nan
    wanted = np.concatenate([core, rows[:, -2:-1], coefficients], axis=1)
    np.testing.assert_array_equal(UpdateCodec(SMALL, carries_all).quantise(rows), wanted)


def test_numbers_of_numpy_are_written_like_those_of_python() -> None:
    core = BsmCore.from_values({"message_count": 7, "temporary_id": 1, "yaw_rate_radps": 0.0})
    same = BsmCore(tuple(np.array(core.codes)))
    assert same == core
    assert encode_bsm(same, regional=((np.int64(128), bytes(9)),)) == encode_bsm(
        core, regional=((128, bytes(9)),)
    )
    numbers = np.arange(4)
    spoken = IdentificationMessage(numbers[1], numbers[2], sub_model=numbers[3], age=numbers[3])
    assert encode_identification(spoken) == encode_identification(
        IdentificationMessage(1, 2, sub_model=3, age=3)
    )
    model = ModelExtension(numbers[3], numbers[1], coefficients=bytes(9))
    assert encode_extension(model) == encode_extension(ModelExtension(3, 1, coefficients=bytes(9)))
    wire = replace(SMALL, number=np.int64(SMALL.number))
    update = UpdateMessage(same, numbers[0], carries_all=False, codes=((numbers[3],),))
    plain = UpdateMessage(core, 0, carries_all=False, codes=((3,),))
    assert UpdateCodec(wire).encode(update) == UpdateCodec(SMALL).encode(plain)


def test_what_is_no_whole_number_is_a_value_error() -> None:
    core = BsmCore.from_values({"message_count": 7, "temporary_id": 1, "yaw_rate_radps": 0.0})
    with pytest.raises(ValueError, match=r"message_count must be a whole number within 0..127, got 7.0"):
        BsmCore((7.0, *core.codes[1:]))  # pyright: ignore[reportArgumentType]
    with pytest.raises(ValueError, match="region_id"):
        encode_bsm(core, regional=((128.0, bytes(1)),))  # pyright: ignore[reportArgumentType]
    with pytest.raises(ValueError, match="sequence"):
        IdentificationMessage(1, 7.0, sub_model=2, age=3)  # pyright: ignore[reportArgumentType]
    half = UpdateMessage(core, 0, carries_all=False, codes=((1.5,),))  # pyright: ignore[reportArgumentType]
    with pytest.raises(ValueError, match="x_m"):
        UpdateCodec(SMALL).encode(half)

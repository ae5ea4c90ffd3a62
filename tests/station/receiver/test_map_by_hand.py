"""Claims about what a map holds after each message, worked out by hand: slots, what gives way, and bounds."""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from modelcast.core.arrays import FloatArray
from modelcast.messages.mbc import ModelUpdate, SubModelIdentification
from modelcast.models.bank import Bank
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.gp import GaussianProcess
from modelcast.models.kinematic import ConstantAcceleration, ConstantTurnRateAcceleration
from modelcast.station.banks import profile_number_of
from modelcast.station.policy.neighbours import neighbour_tables
from modelcast.station.policy.neighbours_kernels import find, place
from modelcast.station.receiver import plausibility_kernels, slot_kernels, track_kernels
from modelcast.station.receiver.ears import Ears
from modelcast.station.receiver.heard import Heard, heard_messages
from modelcast.station.receiver.local_dynamic_map import LocalDynamicMap, MapState, Receipt
from modelcast.station.receiver.plausibility import Plausibility
from modelcast.station.receiver.plausibility_limits import DEFAULT_LIMITS
from modelcast.station.receiver.statements import statements_of
from modelcast.station.sender.octets import SentMessages, StationOctets
from modelcast.station.sensing.sensing import NOWHERE
from modelcast.trips.trajectory import Trajectory

CV = ConstantVelocity()
AROUND = LocalDynamicMap((Bank((CV, ConstantAcceleration())),), expiry_s=4.0)
ACCEPTED = Receipt.ACCEPTED


def update(vehicle: int, t_s: float, **changes: Any) -> ModelUpdate:
    """An update of a car that stands, 500 m from the car of the next id."""
    message = ModelUpdate(
        vehicle,
        0,
        t_s,
        position_m=np.array([500.0 * vehicle, 0.0]),
        in_use=0,
        parameters=np.zeros(5),
        dt_s=0.1,
    )
    return replace(message, **changes)


def hear(
    around: LocalDynamicMap,
    state: MapState,
    *messages: ModelUpdate | SubModelIdentification,
    received_s: Sequence[float] | None = None,
) -> list[Receipt]:
    """What becomes of each; they arrive at once where nothing else is said."""
    times = [one.t_s for one in messages] if received_s is None else received_s
    return [Receipt(one) for one in around.hear(state, heard_messages(messages, times))[0].tolist()]


def held(around: LocalDynamicMap, state: MapState, t_s: float) -> list[int]:
    return around.positions(state, t_s)[0].tolist()


# Slots and their index -------------------------------------------------------------------------------------


@pytest.mark.parametrize(("capacity", "length"), [(1, 2), (2, 4), (3, 8), (4, 8), (5, 16), (8, 16)])
def test_a_new_map_holds_nothing_anywhere(capacity: int, length: int) -> None:
    """The index is the least power of two twice as long as the slots."""
    state = replace(AROUND, capacity=capacity).init()
    assert (state.held.shape, state.told.shape[0], state.facts.shape[0]) == (
        (capacity, 5),
        capacity,
        capacity,
    )
    assert state.lookup.tolist() == [-1] * length
    assert state.ends.tolist() == [0, -1, -1]
    assert (state.held == -1.0).all()
    assert (state.facts == -1).all()
    assert np.isnan(state.told).all()
    assert np.isnan(state.judged).all()


def ids_at(start: int, many: int, length: int) -> list[int]:
    """Ids whose search starts at one place of the index."""
    return list(itertools.islice((one for one in itertools.count() if place(one, length) == start), many))


@pytest.mark.parametrize("start", [0, 5, 7])
@pytest.mark.parametrize(
    ("apart", "newcomer_apart"),
    [((0, 0, 0, 1), 1), ((0, 0, 0, 4), 5), ((0, 0, 4, 4), 2), ((0, 0, 1, 4), 5), ((0, 1, 0, 1), 6)],
)
def test_who_leaves_the_index_leaves_all_others_to_be_found(
    start: int, apart: tuple[int, ...], newcomer_apart: int
) -> None:
    """Four slots, eight places: ids whose search starts this far behind one place, also over the end.

    In every order of the four, and with each of them the one that gives way.
    """
    by_place = {place: iter(ids_at((start + place) % 8, 4, 8)) for place in range(8)}
    four, newcomer = [next(by_place[one]) for one in apart], next(by_place[newcomer_apart])
    for ids, leaves in itertools.product(itertools.permutations(four), range(4)):
        slots = replace(AROUND, capacity=4).init().slots
        for vehicle in ids:
            slot_kernels.new_slot(slots, vehicle)
        for slot in range(4):
            if slot != leaves:
                slot_kernels.renew_slot(slots, slot)
        assert slot_kernels.new_slot(slots, newcomer) == leaves
        now = [newcomer if slot == leaves else one for slot, one in enumerate(ids)]
        assert [slot_kernels.find_slot(slots, one) for one in now] == [0, 1, 2, 3]
        assert slot_kernels.find_slot(slots, ids[leaves]) == -1
        assert sorted(slots.lookup[slots.lookup >= 0].tolist()) == [0, 1, 2, 3]


def test_the_instant_held_is_told_of_the_first_slot_too() -> None:
    state = AROUND.init()
    hear(AROUND, state, update(7, 10.5), update(2, 11.25), update(9, 12.0))
    told = AROUND.fit_s(state, np.array([9, 7, 3, 2]))
    np.testing.assert_array_equal(told, [12.0, 10.5, np.nan, 11.25])


# Who gives way ---------------------------------------------------------------------------------------------

RENEWALS = [
    (SubModelIdentification(1, 0, 1.5, in_use=1), 1.5, ACCEPTED, True),
    (SubModelIdentification(1, 3, 1.5, in_use=1), 1.5, Receipt.UNKNOWN_UPDATE, False),
    (SubModelIdentification(1, 0, -0.5, in_use=1), 1.5, Receipt.OLDER, False),
    (update(1, 0.0), 1.5, Receipt.REPEATED, False),  # a copy, as a relay sends it
    (replace(update(1, 0.0), sequence=9), 1.5, Receipt.REPEATED, True),
    (update(1, -0.5), 1.5, Receipt.OLDER, False),
    (update(1, 1.5), 1.5, ACCEPTED, True),
]


@pytest.mark.parametrize(("message", "received_s", "receipt", "renews"), RENEWALS)
def test_what_tells_that_a_remote_is_alive_keeps_its_slot(
    message: ModelUpdate | SubModelIdentification, received_s: float, receipt: Receipt, renews: bool
) -> None:
    """Room for two, 1 heard before 2: whichever was not renewed since gives way to 3."""
    around = replace(AROUND, capacity=2)
    state = around.init()
    hear(around, state, update(1, 0.0), update(2, 1.0))
    assert hear(around, state, message, received_s=[received_s]) == [receipt]
    hear(around, state, update(3, 2.0))
    assert held(around, state, 2.0) == ([1, 3] if renews else [2, 3])


# Refused messages end no track -----------------------------------------------------------------------------


@pytest.mark.parametrize("judges", [False, True], ids=["malformed", "implausible"])
def test_a_refused_message_at_a_silent_track_s_place_ends_it_not(judges: bool) -> None:
    """It is of the remote in the first slot, which stands like the silent one; it would agree with that."""
    around = replace(AROUND, plausibility=Plausibility() if judges else None)
    state = around.init()
    hear(around, state, update(1, 10.0), update(2, 10.0))
    place_m = np.array([1000.0, 0.0])
    wrong = update(1, 10.2, position_m=place_m)
    if not judges:
        wrong = replace(wrong, parameters=np.array([math.nan, 0.0, 0.0, 0.0, 0.0]))
    assert hear(around, state, wrong) == [Receipt.POSITION_JUMP if judges else Receipt.MALFORMED]
    assert (held(around, state, 10.2), state.renamed) == ([1, 2], 0)
    assert hear(around, state, update(3, 10.3, position_m=place_m)) == [ACCEPTED]
    assert (held(around, state, 10.3), state.renamed) == ([1, 3], 1)


@pytest.mark.parametrize(
    ("after_s", "receipt"), [(2.0, Receipt.POSITION_JUMP), (math.nextafter(2.0, 3.0), ACCEPTED)]
)
def test_what_is_judged_by_is_kept_for_just_the_memory(after_s: float, receipt: Receipt) -> None:
    """5 km in 2 s: no vehicle does that; where the first place is forgotten any other is believed."""
    around = replace(AROUND, plausibility=Plausibility(memory_s=2.0))
    state = around.init()
    hear(around, state, update(1, 0.0))
    assert hear(around, state, update(1, after_s, position_m=np.array([5000.0, 0.0]))) == [receipt]


# Settings and shapes ---------------------------------------------------------------------------------------


def test_sampling_intervals_from_a_millisecond_to_ten_seconds_are_taken() -> None:
    for dt_s in (1e-3, 10.0):
        assert replace(AROUND, dt_s=dt_s).dt_s == dt_s
    for dt_s in (math.nextafter(1e-3, 0.0), math.nextafter(10.0, 11.0)):
        with pytest.raises(ValueError, match=r"dt_s must be from 0.001 to 10.0, got"):
            replace(AROUND, dt_s=dt_s)


def test_messages_given_as_values_have_no_known_user_and_an_identification_no_parameters() -> None:
    named = heard_messages([SubModelIdentification(7, 3, 11.0, in_use=1)], [11.5])
    assert (named.parameters.shape, named.user.tolist()) == ((1, 0), [-1])
    both = heard_messages([update(7, 10.0), update(8, 10.0)], [10.5, 10.5])
    assert (both.parameters.shape, both.user.tolist()) == ((2, 5), [-1, -1])


# Covariances -----------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Certain(ConstantVelocity):
    """Constant velocity with a covariance of its own: variances east and north at any age."""

    label: str = "certain"
    east_m2: float = 1.0
    north_m2: float = 1.0

    @property
    def name(self) -> str:
        """Its label."""
        return self.label

    def covariance(self, parameters: FloatArray, horizons_s: FloatArray, *, dt_s: float) -> FloatArray:
        """The same at any age, whatever the interval."""
        assert dt_s == 0.1
        one = np.diag([self.east_m2, self.north_m2])
        return np.broadcast_to(one, (parameters.shape[0], horizons_s.size, 2, 2)).copy()


def moving(profiles: tuple[Bank, ...], messages: Sequence[tuple[int, int]], age_s: float) -> FloatArray:
    """Covariances at one age of cars by profile (-1 for Part I) and sub-model in use."""
    around = LocalDynamicMap(profiles)
    base = heard_messages([update(at, 0.0) for at in range(len(messages))], [0.0] * len(messages))
    given: Heard = replace(
        base,
        profile=np.array([one for one, _ in messages]),
        in_use=np.array([one for _, one in messages]),
        speed_mps=np.zeros(len(messages)),
        heading_rad=np.zeros(len(messages)),
        parameters=np.zeros((len(messages), 6)),
    )
    receipts, state = around.hear(around.init(), given)
    assert set(receipts.tolist()) == {ACCEPTED}
    return around.believe(state, age_s).covariance_m2


def test_every_sub_model_of_every_profile_gives_its_own_covariance() -> None:
    """One bank of one, one of three; Part I by the first that does with it, the first bank's."""
    banks = (
        Bank((Certain(1.0, "a", 1.0, 10.0),)),
        Bank((Certain(1.0, "b", 2.0, 20.0), Certain(1.0, "c", 3.0, 30.0), Certain(1.0, "d", 4.0, 40.0))),
    )
    told = [(1, 2), (0, 0), (-1, 0), (1, 1), (1, 0), (0, 0)]
    wanted = [(4.0, 40.0), (1.0, 10.0), (1.0, 10.0), (3.0, 30.0), (2.0, 20.0), (1.0, 10.0)]
    for order in (slice(None), slice(None, None, -1)):
        found = moving(banks, told[order], 2.0)
        np.testing.assert_array_equal(found, [np.diag(one) for one in wanted[order]])


@pytest.mark.parametrize(
    ("east_m2", "north_m2", "own"),
    [
        (0.0, 0.0, True),
        (0.0, 5.0, True),
        (5.0, -1e-9, False),
        (-1e-9, 5.0, False),
        (5.0, np.nan, False),
    ],
)
def test_a_covariance_of_a_negative_variance_is_none_one_of_zero_is(
    east_m2: float, north_m2: float, own: bool
) -> None:
    """Then that of constant velocity stands in, (½·1·3²)² m² after 3 s."""
    found = moving((Bank((Certain(1.0, "a", east_m2, north_m2),)),), [(0, 0)], 3.0)[0]
    np.testing.assert_array_equal(found, np.diag([east_m2, north_m2]) if own else np.diag([20.25, 20.25]))


# What plausibility keeps, and one track --------------------------------------------------------------------


def test_what_plausibility_keeps_of_two_reports() -> None:
    """East at 10 m/s and north at 4 m/s, half a second later 12 and 6: the way is 5.5 m and 2.5 m."""
    row, limits = np.zeros(plausibility_kernels.COLUMNS), DEFAULT_LIMITS.numbers
    row[0] = np.nan
    for t_s, place_m, velocity_mps in ((3.0, [7.0, 8.0], [10.0, 4.0]), (3.5, [12.0, 11.0], [12.0, 6.0])):
        finding = plausibility_kernels.judge_one(
            row, t_s, np.array(place_m), np.array(velocity_mps), t_s, limits
        )
        assert finding == plausibility_kernels.PLAUSIBLE
        speed, first = math.hypot(*velocity_mps), t_s == 3.0
        way = [0.0, 0.0, 0.0] if first else [5.5, 2.5, 0.25 * 10.0 * 0.25]
        kept = [t_s, *place_m, *velocity_mps, 3.0, 7.0, 8.0, *way, 0.0, t_s, speed, np.nan]
        np.testing.assert_array_equal(row, kept)


def test_an_update_repeated_after_an_identification_is_still_a_repeated_one() -> None:
    """And one fitted when the identification was sent is a new one."""
    row = np.empty(track_kernels.TRACK_COLUMNS)
    track_kernels.forget(row)
    track_kernels.take_update(row, 4, 0, 10.0, 10.0, 3.0)
    assert track_kernels.take_identification(row, 4, 1, 11.0, 11.0, 3.0) == track_kernels.ACCEPTED
    assert track_kernels.take_update(row, 4, 0, 10.0, 11.5, 3.0) == track_kernels.REPEATED
    assert row.tolist() == [4.0, 1.0, 10.0, 11.0, 11.0]
    assert track_kernels.take_update(row, 5, 0, 11.0, 11.6, 3.0) == track_kernels.ACCEPTED
    assert row.tolist() == [5.0, 0.0, 11.0, 11.0, 11.6]


@pytest.mark.parametrize("missing", ["speed_mps", "heading_rad"])
def test_a_trip_without_speed_or_heading_states_nothing(missing: str) -> None:
    trip = Trajectory(
        "east",
        np.arange(3.0),
        np.zeros((3, 2)),
        segments=np.array([0, 3]),
        dt_s=1.0,
        speed_mps=np.full(3, 5.0),
        heading_rad=np.full(3, 0.5 * math.pi),
    )
    said = statements_of(trip)
    assert said is not None
    np.testing.assert_allclose(said.velocity_mps, [[5.0, 0.0]] * 3, atol=1e-12)
    assert statements_of(replace(trip, **{missing: None})) is None


# Motions ---------------------------------------------------------------------------------------------------


def test_from_a_decimetre_a_second_on_a_vehicle_has_a_course() -> None:
    """North at about 0.1 m/s, some of them just that, but stated to head east: a slower one heads so."""
    speeds_mps = 0.1 + np.spacing(0.1) * np.arange(-8, 9)
    cars = [update(at, 0.0, parameters=np.array([0, one, 0, 0, 0])) for at, one in enumerate(speeds_mps)]
    given = heard_messages(cars, np.zeros(len(cars)))
    state = AROUND.init()
    AROUND.hear(state, replace(given, heading_rad=np.full(len(cars), 0.5 * math.pi)))
    for t_s in (0.0, 0.05, 0.125, 1.0):
        beliefs = AROUND.believe(state, t_s)
        wanted = np.where(beliefs.speed_mps < 0.1, 0.5 * math.pi, 0.0)
        np.testing.assert_array_equal(beliefs.heading_rad, wanted)
        np.testing.assert_array_equal(beliefs.vehicle, np.arange(len(cars)))


@pytest.mark.parametrize("age_s", [0.0, 0.02, 0.05, 0.3])
def test_a_path_is_differentiated_from_its_fit_on_and_not_before(age_s: float) -> None:
    """A circle of 10 m at 10 m/s: the parabola through three of its places 0.05 s apart, the first at 0."""
    around = LocalDynamicMap((Bank((ConstantTurnRateAcceleration(),)),))
    state, step_s = around.init(), 0.05
    around.hear(state, heard_messages([update(7, 0.0, parameters=np.array([0.0, 10.0, 0.0, 1.0]))], [0.0]))
    times_s = max(age_s, step_s) + step_s * np.array([-1.0, 0.0, 1.0])
    circle = 10.0 * np.stack([1.0 - np.cos(times_s), np.sin(times_s)], axis=1)
    bent = np.polyfit(times_s - age_s, circle, 2)
    beliefs = around.believe(state, age_s)
    assert beliefs.velocity_mps[0] == pytest.approx(bent[1], abs=1e-9)
    assert beliefs.speed_mps[0] == pytest.approx(math.hypot(*bent[1]), abs=1e-9)
    across = 2.0 * (bent[0, 0] * bent[1, 1] - bent[0, 1] * bent[1, 0])
    assert beliefs.yaw_rate_radps[0] == pytest.approx(across / (bent[1] @ bent[1]), abs=1e-7)


def test_a_sub_model_whose_path_begins_off_the_earth_is_malformed() -> None:
    """30 000 km away now, half way back after 1 s, and within reach when it expires after 2 s."""
    model = GaussianProcess(4, "intercept")
    around = LocalDynamicMap((Bank((model,)),), expiry_s=2.0)
    for intercept_m, receipt in ((3e7, Receipt.MALFORMED), (1.9e7, ACCEPTED)):
        values = {"intercept_east_m": intercept_m, "slope_east_mps": -1.5e7, "lengthscale_s": 1.0}
        parameters = np.array([values.get(name, 0.0) for name in model.parameter_names])
        assert hear(around, around.init(), update(7, 0.0, parameters=parameters)) == [receipt]


# Octets ----------------------------------------------------------------------------------------------------

NARROW, WIDE = Bank((CV,)), Bank((ConstantAcceleration(), CV))


@pytest.mark.parametrize("banks", [(NARROW, WIDE), (WIDE, NARROW)])
def test_neighbours_are_counted_by_sub_intervals_of_a_second_by_any_profile(banks: tuple[Bank, ...]) -> None:
    """Of 0.6 s, 1.4 s and 2.2 s each is in a second of its own; both banks' parameters fit."""
    ears = Ears(banks, plausibility=None)
    tables, state = neighbour_tables(1, 4), ears.init()
    sample = np.array([[5.0, 6.0, 9.0, 12.0, 1.5, 0.0, 0.0]])
    for sequence, t_s in enumerate((0.6, 1.4, 2.2)):
        sent = SentMessages(
            np.array([1]),
            np.array([sequence]),
            vehicle=np.array([11]),
            t_s=np.array([t_s]),
            sample=sample,
            stated_m=sample[:, :2],
            in_use=np.array([0]),
            parameters=np.array([[9.0, 12.0, 1.5, 9.0, 12.0]]),
            update=np.array([sequence]),
            fit_s=np.array([t_s]),
        )
        octets = StationOctets.of(WIDE, profile_number_of(WIDE), "never", NOWHERE).encode(sent)
        receipts, state = ears.hear(state, octets, [t_s], origin=NOWHERE, tables=tables)
        assert receipts.tolist() == [ACCEPTED]
    slot = tables.slots[0, find(tables.slots, tables.lookup, 0, 11)]
    assert slot["newest"] == 2
    assert slot["received"].tolist() == [1, 1, 1, 0, 0, 0, 0, 0, 0, 0]

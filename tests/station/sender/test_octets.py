"""Claims about octets of stations: the motion that Part I holds where the sub-model in use has none."""

import numpy as np
import pytest

from modelcast.core.arrays import FloatArray
from modelcast.core.geodesy import Origin
from modelcast.messages.bsm import decode_bsm
from modelcast.messages.bsm_fields import CORE_INDEX
from modelcast.messages.mbc_wire import decode_identification
from modelcast.models.bank import Bank
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.gp import linear_process
from modelcast.station.sender.octets import SentMessages, StationOctets

BANK = Bank((linear_process(3), ConstantVelocity())).carried()
"""Of the first sub-model a message carries no velocity."""

ORIGIN = Origin(42.0, -83.0)


def sent(samples: FloatArray, in_use: int, velocity: tuple[float, float] = (0.0, 0.0)) -> SentMessages:
    """An update of each sample, all else of it the same."""
    count = len(samples)
    parameters = np.zeros((count, int(BANK.offsets[-1])))
    parameters[:, int(BANK.offsets[1]) :] = velocity
    return SentMessages(
        np.ones(count, dtype=np.int64),
        np.arange(count) + 130,
        vehicle=np.arange(count) + 7,
        t_s=np.full(count, 61.25),
        sample=samples,
        stated_m=np.ascontiguousarray(samples[:, :2]),
        in_use=np.full(count, in_use),
        parameters=parameters,
        update=np.arange(count) + 130,
        fit_s=np.full(count, 61.25),
    )


def part_i(messages: SentMessages, *names: str) -> list[list[int]]:
    """Codes of some fields of each message."""
    writer = StationOctets.of(BANK, 5, "never", ORIGIN)
    codes = [decode_bsm(octets).core.codes for octets in writer.encode(messages)]
    return [[int(one[CORE_INDEX[name]]) for name in names] for one in codes]


def sample(
    east_mps: float, north_mps: float, acceleration: float = 0.0, yaw_rate: float = 0.0
) -> list[float]:
    return [0.0, 0.0, east_mps, north_mps, acceleration, yaw_rate, 0.0]


def test_speed_and_course_come_from_the_sample_where_the_sub_model_has_none() -> None:
    """Codes of speed are 2 cm/s, of heading 1/80 degree, clockwise from north; under 0.5 m/s it is 0."""
    samples = np.array(
        [
            sample(3.0, 4.0),
            sample(12.0, 0.0, 0.0, 0.5),
            sample(0.0, -7.0, 0.0, 0.5),
            sample(0.5, 0.0),
            sample(0.4999, 0.0),
            sample(-0.1, 0.0),
            sample(0.0, 0.0),
        ]
    )
    found = part_i(sent(samples, 0), "speed_mps", "heading_rad")
    assert found == [
        [250, round(np.rad2deg(np.arctan2(3.0, 4.0)) * 80)],
        [600, 90 * 80],
        [350, 180 * 80],
        [25, 90 * 80],
        [25, 0],
        [5, 0],
        [0, 0],
    ]


def test_a_vehicle_that_a_sub_model_has_at_rest_keeps_the_course_of_its_sample() -> None:
    samples = np.array([sample(5.0, 0.0), sample(0.0, -5.0), sample(0.3, 0.0)])
    assert part_i(sent(samples, 1), "speed_mps", "heading_rad") == [[0, 7200], [0, 14400], [0, 0]]
    moving = part_i(sent(samples, 1, (0.0, 2.0)), "speed_mps", "heading_rad")
    assert moving == [[100, 0]] * 3


@pytest.mark.parametrize("in_use", [0, 1])
def test_rates_come_from_the_sample(in_use: int) -> None:
    """Acceleration in cm/s², yaw rate in hundredths of a degree a second, clockwise."""
    samples = np.array([sample(8.0, 6.0, 1.25, 0.1), sample(8.0, 6.0, -3.5, -0.2)])
    found = part_i(sent(samples, in_use, (8.0, 6.0)), "acceleration_forward_mps2", "yaw_rate_radps")
    assert found == [[125, round(np.rad2deg(0.1) * 100)], [-350, round(np.rad2deg(-0.2) * 100)]]


def test_who_and_how_many_and_when_stand_in_part_i() -> None:
    samples = np.array([sample(8.0, 6.0), sample(9.0, 6.0)])
    names = ("temporary_id", "message_count", "second_of_minute_s")
    assert part_i(sent(samples, 0), *names) == [[7, 2, 1250], [8, 3, 1250]]


def test_instants_are_counted_from_the_minute_that_is_given() -> None:
    """61.25 s are 1.25 s after a minute that began at 0 s, and 51.25 s after one that began at 10 s."""
    messages = sent(np.array([sample(8.0, 6.0)]), 0)
    mark = CORE_INDEX["second_of_minute_s"]
    of = StationOctets.of(BANK, 5, "never", ORIGIN)
    writers = [
        StationOctets(of.codec, ORIGIN),
        of,
        StationOctets.of(BANK, 5, "never", ORIGIN, minute_s=10.0),
    ]
    marks = [decode_bsm(one.encode(messages)[0]).core.codes[mark] for one in writers]
    assert marks == [1250, 1250, 51_250]


def test_updates_and_identifications_come_in_their_order() -> None:
    """An identification says which update it names, and how old that is in hundredths of a second."""
    samples = np.array([sample(8.0, 6.0), sample(9.0, 6.0), sample(10.0, 6.0)])
    messages = sent(samples, 1, (8.0, 6.0))
    messages.kind[:] = [1, 2, 1]
    messages.update[1], messages.fit_s[1], messages.in_use[1] = 129, 60.0, 0
    first, named, last = StationOctets.of(BANK, 5, "best", ORIGIN).encode(messages)
    read = decode_identification(named)
    assert (read.temporary_id, read.sequence, read.sub_model, read.age) == (8, 1, 0, 125)
    counts = [decode_bsm(octets).core.codes[CORE_INDEX["message_count"]] for octets in (first, last)]
    assert counts == [2, 4]
    messages.kind[:] = 2
    assert [len(one) for one in StationOctets.of(BANK, 5, "best", ORIGIN).encode(messages)] == [10, 10, 10]

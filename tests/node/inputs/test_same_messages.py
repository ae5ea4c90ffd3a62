"""A station fed through a node's inputs says what one fed from the trip says, octet by octet."""

import numpy as np
import pytest

from modelcast.node.inputs.motion_source import MotionSource
from modelcast.node.inputs.replay import TripReplay
from modelcast.station.station import Station
from modelcast.world.drive import generate_drive

STEPS = 250


@pytest.mark.parametrize("sender", ["mbc", "j2945"])
def test_a_replayed_trip_gives_the_same_octets(sender: str):
    trip = generate_drive(4, 90.0).truth
    replay = TripReplay(trip)
    source = MotionSource(replay.origin)
    direct, fed = (Station(sender, temporary_id=7, origin=replay.origin) for _ in range(2))
    said = 0
    for at in range(STEPS):
        t_s = float(trip.t_s[at])
        one = direct.sense(
            t_s,
            tuple(trip.position_m[at].tolist()),
            speed_mps=float(trip.speed_mps[at]),
            heading_rad=float(trip.heading_rad[at]),
            acceleration_mps2=float(trip.acceleration_mps2[at]),
            yaw_rate_radps=float(trip.yaw_rate_radps[at]),
        )
        source.feed(replay.take(t_s))
        motion = source.at(t_s)
        assert motion is not None
        other = fed.sense(
            motion.t_s,
            motion.position_m,
            speed_mps=motion.speed_mps,
            heading_rad=motion.heading_rad,
            acceleration_mps2=motion.acceleration_mps2,
            yaw_rate_radps=motion.yaw_rate_radps,
            begins=motion.begins,
        )
        assert [message.octets for message in one] == [message.octets for message in other]
        assert np.array_equal([message.send_s for message in one], [message.send_s for message in other])
        said += len(one)
    assert said > 5

"""Claims about what a host has heard of late, by the counts of messages."""

import numpy as np
import pytest

from modelcast.station.station import Station

SPEED_MPS = 15.0


def heard(lost: np.ndarray, temporary_id: int = 2**31 + 5) -> Station:
    """A host that hears one who sends ten messages a second, but for those that are lost."""
    host, remote = Station(temporary_id=1), Station("bsm-10hz", temporary_id=temporary_id)
    for step in range(lost.size):
        t_s = 0.1 * step
        host.sense(t_s, (-50.0, 0.0), speed_mps=0.0, heading_rad=0.0)
        for one in remote.sense(t_s, (0.0, SPEED_MPS * t_s), speed_mps=SPEED_MPS, heading_rad=0.0):
            if not lost[step]:
                host.hear([one.octets], received_s=[one.send_s])
    return host


@pytest.mark.parametrize("share", [0.0, 0.3, 0.6])
def test_the_share_lost_is_that_of_the_last_five_seconds(share: float) -> None:
    """Losses before do not count; those of the running second do not yet."""
    rng = np.random.default_rng(3)
    lost = rng.random(200) < share
    lost[:100] = rng.random(100) < 0.8
    found = heard(lost).deliveries(np.array([2**31 + 5, 99]), 20.0)
    assert found.received[1] == found.sent[1] == 0
    assert np.isnan(found.loss_ratio[1])
    # Five parts of a second that are over; where they begin is the station's own.
    counts = [int((~lost[first : first + 50]).sum()) for first in range(140, 151)]
    assert int(found.received[0]) in counts
    assert found.received[0] <= found.sent[0] <= 51
    assert abs(float(found.loss_ratio[0]) - lost[140:200].mean()) < 0.12
    assert found.total_loss_ratio == found.loss_ratio[0]


def test_nobody_heard_is_no_loss() -> None:
    found = heard(np.ones(30, dtype=np.bool_)).deliveries(np.array([], dtype=np.int64), 3.0)
    assert found.received.size == 0
    assert np.isnan(found.total_loss_ratio)

"""Claims: what a radio delivers is refused where no fleet can read it, whichever thread reads it."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from modelcast.channel.radio import OUTCOMES, AbstractRadio, Receptions, Transmissions
from modelcast.core.arrays import FloatArray
from modelcast.runtime.fleet.loop import FleetLoop
from modelcast.runtime.fleet.settings import NetworkSettings
from modelcast.station.sender.sender import named_sender
from modelcast.world.scenario.base import run_scenario
from modelcast.world.scenario.highway import Highway


@dataclass(frozen=True)
class Wrong(AbstractRadio[float]):
    """Delivers one reception, whatever is sent."""

    message_id: int
    sender: int
    receiver: int
    t_s: float

    def init(self, vehicles: int, rng: np.random.Generator) -> float:
        """Begin at time 0."""
        del vehicles, rng
        return 0.0

    def step(
        self, state: float, transmissions: Transmissions, position_m: FloatArray, until_t_s: float
    ) -> tuple[Receptions, float]:
        """Deliver it."""
        del state, transmissions, position_m
        received = Receptions(
            np.array([self.message_id]),
            np.array([self.sender]),
            receiver=np.array([self.receiver]),
            t_s=np.array([self.t_s]),
            rssi_dbm=np.array([-60.0]),
            outcomes=np.zeros((4, len(OUTCOMES)), dtype=np.int64),
            expired=np.empty(0, dtype=np.int64),
        )
        return received, until_t_s

    def channel_busy_ratio(self, state: float) -> FloatArray:
        """Say that the channel is idle."""
        del state
        return np.zeros(4)


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize(
    ("radio", "told"),
    [
        (Wrong(0, 0, 9, 0.01), r"Wrong: receiver must lie within 0\.\.3, got 9\.\.9"),
        (Wrong(0, 1, 1, 0.01), "Wrong: vehicle 1 must not receive what it sends itself"),
        (Wrong(0, 0, 1, -0.5), "Wrong: t_s must lie after the interval's start"),
        (Wrong(5, 0, 1, 0.01), "Wrong: message 5 was never sent"),
    ],
)
def test_receptions_that_cannot_be_are_refused(radio: AbstractRadio[Any], told: str, threads: int) -> None:
    road = Highway(200.0, 20.0, warm_up_s=0.0)
    frame = next(run_scenario(road, np.random.default_rng(1), duration_s=1.0))
    loop = FleetLoop(frame, named_sender("mbc"), radio, NetworkSettings(), seed=1, threads=threads)
    with pytest.raises(ValueError, match=told):
        loop.step(frame)

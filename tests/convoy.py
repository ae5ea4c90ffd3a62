"""Vehicles that drive, and a disc radio, for tests of sessions: whoever is asked, the same world."""

from typing import Any

import numpy as np

from modelcast.runtime.external.exchange import Sent, Step


class Convoy:
    """Vehicles one behind the other that brake and turn as numbers drawn once say."""

    def __init__(self, vehicles: int, *, seed: int = 0, first_id: int = 3) -> None:
        rng = np.random.default_rng(seed)
        self.vehicle = first_id + 7 * np.arange(vehicles)
        self.speed_mps = rng.uniform(10.0, 20.0, vehicles)
        self.phase = rng.uniform(0.0, 6.0, vehicles)
        self.position_m = np.stack([np.zeros(vehicles), -30.0 * np.arange(vehicles)], axis=1)
        self.heard: dict[str, Any] = {}

    def step(self, number: int, *, order: Any = slice(None), **more: Any) -> Step:
        """The next step, of rows in the order given."""
        t_s = 0.1 * number
        heading = 0.3 * np.sin(0.5 * t_s + self.phase)
        speed = self.speed_mps + 3.0 * np.sin(0.3 * t_s + self.phase)
        if number:
            self.position_m = self.position_m + 0.1 * speed[:, None] * np.stack(
                [np.sin(heading), np.cos(heading)], axis=1
            )
        return Step(
            t_s,
            self.vehicle[order],
            position_m=self.position_m[order],
            **{
                "speed_mps": speed[order],
                "heading_rad": np.mod(heading, 2.0 * np.pi)[order],
                "acceleration_mps2": (0.9 * np.cos(0.3 * t_s + self.phase))[order],
                "yaw_rate_radps": (0.15 * np.cos(0.5 * t_s + self.phase))[order],
                **self.heard,
                **more,
            },
        )

    def carry(self, sent: Sent, order: Any = slice(None)) -> None:
        """Let everybody but the sender receive everything, 2 ms later."""
        pairs = [(row, host) for row, who in enumerate(sent.vehicle) for host in self.vehicle if host != who]
        row, host = np.array(pairs, dtype=np.int64).reshape(-1, 2).T
        late_s = np.minimum(sent.send_s[row] + 0.002, sent.t_s + 0.1)
        self.heard = {
            "receiver": host[order],
            "received_s": late_s[order],
            "message": np.asarray(sent.message, dtype=np.int64)[row][order],
        }

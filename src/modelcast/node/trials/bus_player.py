"""A vehicle's bus that tells of a drive, and fails as it is asked to."""

import asyncio
import math
import struct
from collections.abc import Callable
from typing import Literal, final

from modelcast.core.exceptions import MissingExtraError
from modelcast.node.trials.drive import Drive
from modelcast.node.trials.pacing import at_every

try:
    import can
except ImportError as error:
    raise MissingExtraError("playing a vehicle's bus", "node") from error

__all__ = ["BUS_DBC", "BUS_SIGNALS", "BusGives", "BusPlayer"]

BusGives = Literal["values", "same values", "nothing"]

BUS_DBC = """VERSION ""

BS_:

BU_: XXX

BO_ 180 MOTION: 8 XXX
 SG_ SPEED : 0|16@1+ (0.01,0) [0|655] "km/h" XXX
 SG_ YAW_RATE : 16|16@1- (0.01,0) [-300|300] "deg/s" XXX
 SG_ ACCELERATION : 32|16@1- (0.001,0) [-30|30] "m/s2" XXX
"""
"""What its frames hold, as a DBC file."""

BUS_SIGNALS = "speed_mps=MOTION.SPEED, yaw_rate_radps=MOTION.YAW_RATE, acceleration_mps2=MOTION.ACCELERATION"
"""What they mean, for `modelcast.node.inputs.signals`."""

_MESSAGE_ID = 180
_PERIOD_S = 0.02


@final
class BusPlayer:
    """Sends a frame of speed, yaw rate and acceleration fifty times a second.

    Parameters
    ----------
    bus
        Of python-can; `stop` shuts it down.
    drive
        What it tells of.
    utc_s
        Gives UTC, since 1970 [s].
    """

    def __init__(self, bus: can.BusABC, drive: Drive, utc_s: Callable[[], float]) -> None:
        self._bus, self._drive, self._utc_s = bus, drive, utc_s
        self.gives: BusGives = "values"
        """What is on the bus; may be set at any time."""
        self._held: bytes = b""
        self._task: asyncio.Task[None] | None = None

    def start(self) -> None:
        """Begin to send, in the running loop."""
        if self._task is None:
            self._task = asyncio.create_task(at_every(_PERIOD_S, self._utc_s, self._send))

    async def stop(self) -> None:
        """End, and shut the bus down."""
        task, self._task = self._task, None
        if task is not None:
            task.cancel()
            await asyncio.gather(task, return_exceptions=True)
        self._bus.shutdown()

    def _send(self, now_s: float) -> None:
        if self.gives == "nothing":
            return
        if self.gives == "values" or not self._held:
            driven = self._drive.at(now_s)
            self._held = struct.pack(
                "<Hhhxx",
                round(driven.speed_mps * 3.6 / 0.01),
                round(math.degrees(driven.yaw_rate_radps) / 0.01),
                round(driven.acceleration_mps2 / 0.001),
            )
        self._bus.send(can.Message(arbitration_id=_MESSAGE_ID, data=self._held, is_extended_id=False))

"""The study: every sender and loss over the same platoons, beside one that knows everything."""

from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass

import numpy as np

from modelcast.channel.erasure_radio import ErasureRadio
from modelcast.models.bank import Bank
from modelcast.runtime.fleet.loop import FleetLoop
from modelcast.runtime.fleet.settings import NetworkSettings
from modelcast.runtime.platoon.drive import PlatoonTrace, drive_platoons
from modelcast.runtime.platoon.knowledge import Heard, Perfect
from modelcast.station.sender.message_arrays import AIRTIME_S, MESSAGES, PAYLOAD_BYTES
from modelcast.station.sender.sender import Sender
from modelcast.study.cruise.measure import DRIVE, measure_drive, speed_change_ratio
from modelcast.study.cruise.senders import platoon_sender
from modelcast.study.cruise.settings import CruiseSettings, Loss
from modelcast.study.table import Row, Table, TableSchema, quantity, ratio, text
from modelcast.world.platoon.platoons import Platoons

__all__ = [
    "CRUISE",
    "PERFECT",
    "REFERENCE",
    "CruiseResult",
    "Driven",
    "drive_perfect",
    "drive_sender",
    "run_cruise",
]

PERFECT = "perfect"
"""In the place of a sender: everybody knows the truth of every frame, and nothing is sent."""

REFERENCE = "bsm-10hz"
"""What messages saved and changes of speed are counted from: this sender, where nothing is lost."""

_REACH_M = 350.0
"""Of hosts, as in a network run [m]."""


CRUISE = TableSchema(
    "runs",
    "What one sender was worth under one loss.",
    (
        text("sender", "Name of the sender."),
        quantity("threshold_m", "m", "Error that calls for a message.", missing="no error does"),
        ratio("loss_ratio", "Mean share of messages lost."),
        quantity("burst_s", "s", "Mean length of bursts of losses; 0 for one by one."),
        quantity("rate_hz", "1/s", "Messages of a vehicle."),
        quantity("bytes_per_s", "byte/s", "Payload bytes of a vehicle."),
        quantity("airtime_per_s", "s/s", "Time on the air of a vehicle."),
        quantity(
            "fewer_messages_ratio",
            "1",
            "Share of the reference's messages that are not sent, negative where more are.",
        ),
        quantity(
            "speed_change_ratio",
            "1",
            "Mean difference of the followers' speeds from those under the reference, over their mean.",
        ),
        *DRIVE.columns,
    ),
)
"""Platoons: a row a sender, threshold and loss."""


@dataclass(frozen=True, slots=True)
class CruiseResult:
    """What `run_cruise` found.

    Parameters
    ----------
    rows
        Perfect knowledge first, then a row a sender, threshold and loss.
    leader, law, ranging
        What was driven, by which law, and whether with a ranging sensor.
    platoons, vehicles
        How many, and how long.
    """

    rows: Table
    _: KW_ONLY
    leader: str
    law: str
    ranging: bool
    platoons: int
    vehicles: int


@dataclass(frozen=True, slots=True, eq=False)
class Driven:
    """One run on the air: what was driven, and what was sent for it, a vehicle and second."""

    trace: PlatoonTrace
    rate_hz: float
    bytes_per_s: float
    airtime_per_s: float


def drive_sender(settings: CruiseSettings, sender: Sender, loss: Loss) -> Driven:
    """Drive the platoons of a study by what one sender's messages say.

    Parameters
    ----------
    settings
        The study.
    sender
        What all vehicles send, and when.
    loss
        What becomes of it.
    """
    drive = settings.drive
    platoons = Platoons(settings.platoons, settings.vehicles)
    first_mps = float(settings.leader.speed_mps(np.zeros(1))[0])
    gap = settings.law.gap_m(np.full((platoons.count, platoons.vehicles - 1), first_mps))
    # A platoon stays within reach of itself, whatever gaps fallbacks leave.
    spread_m = (platoons.vehicles - 1) * (platoons.length_m + float(gap.max()))
    reach_m = max(_REACH_M, 2.0 * spread_m)
    loop = FleetLoop(
        platoons.frame(platoons.init(gap, first_mps)),
        sender,
        ErasureRadio(loss.channel, reach_m),
        NetworkSettings(dt_s=drive.frame_s, reach_m=reach_m),
        seed=settings.seed,
    )
    heard = Heard(platoons, loop, most_age_s=settings.most_age_s)
    settled = round(drive.settle_s / drive.frame_s)

    def forget(frames: int) -> None:
        if frames == settled:
            loop.forget_counts()

    trace = drive_platoons(platoons, settings.leader, settings.law, heard, drive, progress=forget)
    seconds = (trace.t_s.size - settled) * drive.frame_s * platoons.count * platoons.vehicles
    total = loop.sent.total / seconds
    return Driven(trace, float(total[MESSAGES]), float(total[PAYLOAD_BYTES]), float(total[AIRTIME_S]))


def drive_perfect(settings: CruiseSettings) -> PlatoonTrace:
    """Drive one platoon of a study that knows everything: nothing of it is chance.

    Parameters
    ----------
    settings
        The study.
    """
    one = Platoons(1, settings.vehicles)
    return drive_platoons(one, settings.leader, settings.law, Perfect(one), settings.drive)


def run_cruise(
    settings: CruiseSettings,
    *,
    bank: Bank | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> CruiseResult:
    """Run the study.

    Parameters
    ----------
    settings
        What is compared.
    bank
        Of the senders that send models; None for the shipped profile's.
    progress
        Called with runs done and runs to do.

    Raises
    ------
    ValueError
        Where a sender does not take the bank.
    """
    settled_s = settings.drive.settle_s
    reference = drive_sender(settings, platoon_sender(REFERENCE), Loss(0.0))

    def row(name: str, threshold_m: float | None, loss: Loss, driven: Driven) -> Row:
        return CRUISE.row(
            sender=name,
            threshold_m=threshold_m,
            loss_ratio=loss.ratio,
            burst_s=loss.burst_s,
            rate_hz=driven.rate_hz,
            bytes_per_s=driven.bytes_per_s,
            airtime_per_s=driven.airtime_per_s,
            fewer_messages_ratio=1.0 - driven.rate_hz / reference.rate_hz,
            speed_change_ratio=speed_change_ratio(driven.trace, reference.trace, from_s=settled_s),
            **dict(measure_drive(driven.trace, from_s=settled_s).items()),
        )

    perfect = Driven(drive_perfect(settings), 0.0, 0.0, 0.0)
    rows = [row(PERFECT, None, Loss(0.0), perfect)]
    cases = [(contender, loss) for contender in settings.contenders for loss in settings.losses]
    for number, ((name, threshold_m), loss) in enumerate(cases):
        if progress is not None:
            progress(number, len(cases))
        sender = platoon_sender(
            name,
            threshold_m=threshold_m,
            keep_alive_s=settings.keep_alive_s,
            approach_m=settings.approach_m,
            budget=settings.budget,
            bank=bank,
        )
        rows.append(row(name, threshold_m, loss, drive_sender(settings, sender, loss)))
    if progress is not None:
        progress(len(cases), len(cases))
    return CruiseResult(
        CRUISE.table(rows),
        leader=settings.leader.name,
        law=settings.law.name,
        ranging=settings.drive.ranging,
        platoons=settings.platoons,
        vehicles=settings.vehicles,
    )

"""A recorded trip driven by a policy in NumPy, sample by sample, between the station's own steps."""

from typing import Any

import numpy as np

from modelcast.core.arrays import BoolArray, FloatArray, IntArray
from modelcast.station.arrays import Fits, Sensed, lanes
from modelcast.station.policy.base import AbstractTransmitPolicy, Air, MessageKind
from modelcast.station.policy.error_driven import ErrorDriven
from modelcast.station.sender.asking import Asking, inputs_of
from modelcast.station.sender.bank import SenderBank
from modelcast.station.sender.deciding_kernels import asked, know_sample, say_sample
from modelcast.station.sender.lane_rules import speaking_lanes

__all__ = ["decided_walk"]


def decided_walk(
    policy: AbstractTransmitPolicy[Any],
    rule: ErrorDriven,
    own: SenderBank,
    sensed: Sensed,
    fits: Fits,
    *,
    t_s: FloatArray,
    critical: BoolArray,
    rng: np.random.Generator,
) -> tuple[IntArray, IntArray, IntArray]:
    """Drive one trip; returns kind, sub-model in use and update of each sample, (T,) each.

    A message leaves at the sample it was decided at. Nothing is known of a channel: it is idle, and nobody is
    heard.

    Parameters
    ----------
    policy
        Decides.
    rule
        How the station chooses a sub-model where the policy leaves it to it.
    own, sensed, fits
        The bank, what was sensed of the trip, and the fits that are kept.
    t_s
        Sample times, (T,) [s].
    critical
        Whether a critical event goes on, (T,).
    rng
        Of the policy.

    Raises
    ------
    ValueError
        Where the policy decides what a station cannot do.
    """
    members = len(own.bank.members)
    models = own.models(())
    rules = speaking_lanes([rule], [0], guards=(), dt_s=own.dt_s).rules
    state = lanes(1, members=members, parameters=int(own.bank.offsets[-1]), older=0)
    known, one = asked(1, members), np.zeros(1, dtype=np.int64)
    asking = Asking(policy, 1, members, rng)
    idle = Air(np.zeros(1), np.zeros(1), packet_error_ratio=np.full(1, np.nan), airtime_s=np.zeros(1))
    kind, in_use, update = (np.zeros(t_s.size, dtype=np.int64) for _ in range(3))
    for number, now_s in enumerate(t_s.tolist()):
        know_sample(models, sensed, rules, state, number, now_s, known)
        event = critical[number : number + 1]
        inputs = inputs_of(known, one, dt_s=own.dt_s, critical=event, air=idle)
        said = asking.decide(one, inputs)
        kind[number] = said.kind[0]
        if kind[number] == MessageKind.NOTHING:
            in_use[number], update[number] = in_use[number - 1], update[number - 1]
            continue
        wanted, believed = int(said.in_use[0]), bool(said.believed[0])
        in_use[number] = say_sample(models, sensed, fits, rules, state, number, now_s, wanted, believed)
        update[number] = number
    return kind, in_use, update

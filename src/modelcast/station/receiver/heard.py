"""What a host hears: messages of many remotes as arrays, in the order in which they arrived."""

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass, fields, replace
from enum import IntEnum

import numpy as np

from modelcast.core.arrays import FloatArray, IntArray
from modelcast.messages.mbc import ModelUpdate, SubModelIdentification

__all__ = ["Heard", "HeardKind", "heard_messages"]


class HeardKind(IntEnum):
    """What a message is."""

    UPDATE = 0
    PLAIN = 1
    IDENTIFICATION = 2


@dataclass(frozen=True, slots=True, eq=False)
class Heard:
    """K messages in the order of their arrival; several of one remote may be among them.

    Nothing in them is trusted: shapes are checked here, values by `LocalDynamicMap.hear`, message by message.

    Parameters
    ----------
    kind
        `HeardKind` of each, (K,).
    temporary_id
        Of the sender, (K,).
    message_count
        Of the sender; an identification's is that of the update it names, (K,).
    t_s
        Instant of the state or fit; of the decision for an identification, (K,) [s].
    received_s
        Arrival, not falling, (K,) [s].
    position_m
        East and north stated; of no meaning for an identification, (K, 2) [m].
    speed_mps, heading_rad, acceleration_mps2, yaw_rate_radps
        Motion stated: speed, heading clockwise from north, acceleration along it, yaw rate clockwise; NaN
        where unknown, (K,).
    profile
        Place of the profile that an update names among those held, -1 for none or one not held, (K,).
    in_use
        Sub-model in use, (K,).
    parameters
        Parameters of all sub-models of the profile's bank, from the left; the rest is not looked at, and
        what a message does not carry is NaN, (K, P).
    length_m, width_m
        Size of the sender, NaN where unknown, (K,) [m].
    user
        Kind of road user, values of `modelcast.core.kinds.Kind`, -1 where unknown, (K,).

    Raises
    ------
    ValueError
        Where shapes do not agree, or an arrival is no number or before the one that it follows.
    """

    kind: IntArray
    temporary_id: IntArray
    message_count: IntArray
    _: KW_ONLY
    t_s: FloatArray
    received_s: FloatArray
    position_m: FloatArray
    speed_mps: FloatArray
    heading_rad: FloatArray
    acceleration_mps2: FloatArray
    yaw_rate_radps: FloatArray
    profile: IntArray
    in_use: IntArray
    parameters: FloatArray
    length_m: FloatArray
    width_m: FloatArray
    user: IntArray

    def __post_init__(self) -> None:
        count = self.kind.size
        wide = {"position_m": (count, 2), "parameters": (count, *self.parameters.shape[1:])}
        if self.parameters.ndim != 2:
            raise ValueError(f"parameters must be ({count}, P), got {self.parameters.shape}")
        for one in fields(self):
            shape, wanted = getattr(self, one.name).shape, wide.get(one.name, (count,))
            if shape != wanted:
                raise ValueError(f"{one.name} must be {wanted}, got {shape}")
        if not (np.isfinite(self.received_s).all() and (np.diff(self.received_s) >= 0).all()):
            raise ValueError("received_s must be finite and not fall: messages come in order of arrival")

    def taken(self, rows: IntArray) -> "Heard":
        """Some of the messages, in their order.

        Parameters
        ----------
        rows
            Their numbers, rising.
        """
        return replace(self, **{one.name: getattr(self, one.name)[rows] for one in fields(self)})

    @property
    def codes(self) -> IntArray:
        """Whole numbers as the compiled loop takes them, (K, 6)."""
        return np.stack(
            [self.kind, self.temporary_id, self.message_count, self.profile, self.in_use, self.user], axis=1
        ).astype(np.int64, copy=False)

    @property
    def numbers(self) -> FloatArray:
        """Other numbers as the compiled loop takes them, (K, 10)."""
        return np.column_stack(
            [
                self.t_s,
                self.received_s,
                self.position_m,
                self.speed_mps,
                self.heading_rad,
                self.acceleration_mps2,
                self.yaw_rate_radps,
                self.length_m,
                self.width_m,
            ]
        ).astype(np.float64, copy=False)


def heard_messages(
    messages: Sequence[ModelUpdate | SubModelIdentification],
    received_s: Sequence[float] | FloatArray,
    *,
    profile: int = 0,
) -> Heard:
    """Messages given as values, all of one profile; they state no motion beside that of their models.

    Parameters
    ----------
    messages
        In order of arrival.
    received_s
        When each arrived, (K,) [s].
    profile
        Place of the profile that the updates name among those held.

    Raises
    ------
    ValueError
        Where an update has another number of parameters than the first.

    Examples
    --------
    >>> sent = ModelUpdate(
    ...     7, 0, 0.0, position_m=np.zeros(2), in_use=0, parameters=np.array([10.0, 0.0]), dt_s=0.1
    ... )
    >>> heard_messages([sent], [0.1]).parameters
    array([[10.,  0.]])
    """
    count = len(messages)
    updates = [(at, one) for at, one in enumerate(messages) if isinstance(one, ModelUpdate)]
    position_m = np.full((count, 2), np.nan)
    parameters = np.full((count, updates[0][1].parameters.size if updates else 0), np.nan)
    kind = np.full(count, int(HeardKind.IDENTIFICATION))
    for at, one in updates:
        if one.parameters.shape != parameters.shape[1:]:
            raise ValueError(f"an update has {one.parameters.shape} parameters, the first {parameters.shape}")
        position_m[at], parameters[at], kind[at] = one.position_m, one.parameters, HeardKind.UPDATE
    unknown = np.full(count, np.nan)
    return Heard(
        kind,
        np.array([one.vehicle for one in messages], dtype=np.int64),
        np.array([one.sequence for one in messages], dtype=np.int64),
        t_s=np.array([one.t_s for one in messages], dtype=np.float64),
        received_s=np.array(received_s, dtype=np.float64),
        position_m=position_m,
        speed_mps=unknown,
        heading_rad=unknown,
        acceleration_mps2=unknown,
        yaw_rate_radps=unknown,
        profile=np.full(count, profile),
        in_use=np.array([one.in_use for one in messages], dtype=np.int64),
        parameters=parameters,
        length_m=unknown,
        width_m=unknown,
        user=np.full(count, -1),
    )

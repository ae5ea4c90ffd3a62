"""How many bytes each message takes: those of the codec, for any bank.

The baseline is a basic safety message with Part I alone, or a personal safety message of what every such
message holds. A model update is the same with a regional extension, and an identification is a frame of its
own (`mbc_wire`). Of a sub-model whose parameters no message carries, such as the weights of a Gaussian
process, the predicted path is sent and counted.
"""

from dataclasses import dataclass

import numpy as np

from modelcast.core.arrays import IntArray
from modelcast.core.kinds import Kind
from modelcast.messages.mbc_codec import IDENTIFICATION_OCTETS
from modelcast.messages.mbc_profile import carries_all, plain_members
from modelcast.messages.mbc_update import update_octets
from modelcast.messages.message_heads import HEADS, check_speaks, heads_of_members
from modelcast.models.bank import Bank
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.predicted_path import carried_layout

__all__ = ["SizeModel"]

_CONSTANT_VELOCITY = Bank((ConstantVelocity(),))


@dataclass(frozen=True, slots=True)
class SizeModel:
    """Bytes by kind of message.

    Parameters
    ----------
    more_bytes
        What every such message holds beside that and the model: Part II, for instance.
    kind
        Of the stations that send.

    Raises
    ------
    ValueError
        Where the bytes are negative, or the kind has no message of its own.

    Examples
    --------
    >>> from modelcast.models.constant_velocity import ConstantVelocity
    >>> from modelcast.models.kinematic import ConstantTurnRateAcceleration
    >>> bank = Bank((ConstantTurnRateAcceleration(), ConstantVelocity()))
    >>> sizes = SizeModel()
    >>> sizes.baseline_bytes(), sizes.identification_bytes
    (40, 10)
    >>> sizes.each_update_bytes(bank, "on-failure").tolist(), sizes.each_update_bytes(bank, "never").tolist()
    ([47, 47], [40, 47])
    >>> SizeModel(kind=Kind.CYCLIST).each_update_bytes(bank, "never").tolist()
    [42, 29]
    """

    more_bytes: int = 0
    kind: Kind = Kind.VEHICLE

    def __post_init__(self) -> None:
        if self.more_bytes < 0:
            raise ValueError(f"more_bytes must not be negative, got {self.more_bytes}")
        check_speaks(self.kind)

    @property
    def identification_bytes(self) -> int:
        """A whole identification."""
        return IDENTIFICATION_OCTETS

    def baseline_bytes(self) -> int:
        """A plain message of what constant velocity needs."""
        (head,) = heads_of_members(_CONSTANT_VELOCITY, self.kind, carries_all=False)
        return HEADS[head].frame_octets() + self.more_bytes

    def each_update_bytes(self, bank: Bank, identify: str) -> IntArray:
        """A model update, by the sub-model in use, (M,).

        Where another sub-model may be named later, all are sent. By the rule ``never`` only the one in use
        is; and where that is what the bank's receivers coast a plain message by, the message is a plain one.

        Parameters
        ----------
        bank
            The sub-models.
        identify
            The policy's rule, as `modelcast.station.policy.rules` names it.
        """
        bits = [carried_layout(member).bits for member in bank.members]
        together = carries_all(bank, identify)
        heads = [HEADS[one] for one in heads_of_members(bank, self.kind, carries_all=together)]
        sizes = [
            head.frame_octets() if plain else update_octets(sum(bits) if together else own, head)
            for own, head, plain in zip(bits, heads, plain_members(bank, identify, self.kind), strict=True)
        ]
        return np.array(sizes, dtype=np.int64) + self.more_bytes

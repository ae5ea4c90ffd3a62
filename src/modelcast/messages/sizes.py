"""How many bytes each message takes: those of the codec, for any bank.

The baseline is a basic safety message with Part I alone. A model update is the same with a regional
extension, and an identification is a frame of its own (`mbc_wire`). Of a sub-model whose parameters no
message carries, such as the weights of a Gaussian process, the predicted path is sent and counted.
"""

from dataclasses import dataclass

import numpy as np

from modelcast.core.arrays import IntArray
from modelcast.messages.bsm_batch import CORE_FRAME_OCTETS
from modelcast.messages.mbc_codec import IDENTIFICATION_OCTETS
from modelcast.messages.mbc_profile import carries_all, plain_members
from modelcast.messages.mbc_update import update_octets
from modelcast.models.bank import Bank
from modelcast.models.predicted_path import carried_layout

__all__ = ["SizeModel"]


@dataclass(frozen=True, slots=True)
class SizeModel:
    """Bytes by kind of message.

    Parameters
    ----------
    more_bytes
        What every basic safety message holds beside Part I and the model: Part II, for instance.

    Raises
    ------
    ValueError
        Where it is negative.

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
    """

    more_bytes: int = 0

    def __post_init__(self) -> None:
        if self.more_bytes < 0:
            raise ValueError(f"more_bytes must not be negative, got {self.more_bytes}")

    @property
    def identification_bytes(self) -> int:
        """A whole identification."""
        return IDENTIFICATION_OCTETS

    def baseline_bytes(self) -> int:
        """A plain basic safety message."""
        return CORE_FRAME_OCTETS + self.more_bytes

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
        sizes = [update_octets(sum(bits) if together else own) for own in bits]
        plain = plain_members(bank, identify)
        return np.where(plain, CORE_FRAME_OCTETS, sizes).astype(np.int64) + self.more_bytes

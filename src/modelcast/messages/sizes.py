"""How many application bytes each message takes: a plain, stated model.

It counts the application payload only: no security header, no lower layers. The core basic safety message
frame of SAE J2735 takes 40 bytes in unaligned PER, as measured on real encoded messages. A model update is
that core, so that any receiver can use it, followed by a short header and the parameters at 16 bits each. An
identification names its update and a sub-model, nothing else.
"""

from dataclasses import dataclass

import numpy as np

from modelcast.core.arrays import IntArray
from modelcast.models.bank import Bank

__all__ = ["SizeModel"]


@dataclass(frozen=True, slots=True)
class SizeModel:
    """Application bytes by kind of message.

    Parameters
    ----------
    core_bytes
        Core basic safety message frame: what the baseline sends.
    update_header_bytes
        Sequence number, sub-model in use, sampling interval and profile of a model update.
    parameter_bytes
        Each model parameter.
    identification_bytes
        A whole identification: frame, temporary id, time mark, sequence number, sub-model.

    Examples
    --------
    >>> from modelcast.models.constant_velocity import ConstantVelocity
    >>> sizes = SizeModel()
    >>> sizes.baseline_bytes(), sizes.update_bytes(Bank((ConstantVelocity(),)))
    (40, 48)
    """

    core_bytes: int = 40
    update_header_bytes: int = 8
    parameter_bytes: int = 2
    identification_bytes: int = 12

    def baseline_bytes(self) -> int:
        """A raw basic safety message."""
        return self.core_bytes

    def update_bytes(self, bank: Bank) -> int:
        """A model update; kinematic models cost nothing, since the core carries all they hold.

        Parameters
        ----------
        bank
            The sub-models whose parameters it holds.
        """
        carried = sum(member.payload_parameters for member in bank.members)
        return self.core_bytes + self.update_header_bytes + self.parameter_bytes * carried

    def each_update_bytes(self, bank: Bank, identify: str) -> IntArray:
        """A model update by the sub-model in use, (M,).

        Where no other is ever named, the parameters of the one in use are all that need be sent.

        Parameters
        ----------
        bank
            The sub-models.
        identify
            The identification rule, as in `modelcast.policy.error_driven.ErrorDriven`.
        """
        if identify == "never":
            return np.array([self.update_bytes(Bank((member,))) for member in bank.members])
        return np.full(len(bank.members), self.update_bytes(bank))

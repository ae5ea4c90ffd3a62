"""What the wire needs of a profile: its number, and the fields of each sub-model of its bank."""

from dataclasses import dataclass

from modelcast.core.kinds import PEOPLE, Kind
from modelcast.messages.mbc_wire import MAX_COEFFICIENT_OCTETS, PROFILE, SUB_MODEL, profile_number
from modelcast.models.bank import Bank
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.payload import PayloadLayout
from modelcast.models.plain_meaning import same_receiver
from modelcast.models.predicted_path import carried_layout
from modelcast.models.profile import Profile, people_plain_bank

__all__ = ["WireProfile", "carries_all", "plain_members"]


def carries_all(bank: Bank, identify: str) -> bool:
    """Whether updates hold the coefficients of all sub-models: where another may be named later.

    Parameters
    ----------
    bank
        The sub-models.
    identify
        The policy's rule, as `modelcast.station.policy.rules` names it; by ``never`` none is named.
    """
    return identify != "never" and len(bank.members) > 1


def plain_members(bank: Bank, identify: str, kind: Kind = Kind.VEHICLE) -> tuple[bool, ...]:
    """With which sub-models an update is a plain message, as `Bank.sent_plain` says.

    Of people it is with the shipped stop-and-go sub-model, by which everybody coasts their plain messages,
    and with constant velocity, which that is where no acceleration is stated.

    Parameters
    ----------
    bank, identify
        As in `carries_all`; where all are sent, none is: who names another later must know the bank.
    kind
        Of the sender.
    """
    alone = not carries_all(bank, identify)
    if kind in PEOPLE:
        (everybody,) = people_plain_bank().members
        return tuple(
            alone and (isinstance(member, ConstantVelocity) or same_receiver(member, everybody))
            for member in bank.members
        )
    return tuple(alone and plain for plain in bank.sent_plain)


@dataclass(frozen=True, slots=True)
class WireProfile:
    """What the wire needs of a profile: its number, and how each sub-model of its bank is carried.

    Parameters
    ----------
    number
        `mbc_wire.profile_number`.
    layouts
        One for each sub-model, 1 to 8.

    Raises
    ------
    ValueError
        Where the number or the count is out of its range, or the coefficients of all sub-models do not fit.

    Examples
    --------
    >>> from modelcast.models.constant_velocity import ConstantVelocity
    >>> WireProfile.of(Bank((ConstantVelocity(),)), 0x44136F).layouts
    (PayloadLayout(fields=()),)
    """

    number: int
    layouts: tuple[PayloadLayout, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "number", PROFILE.checked(self.number))
        if not 1 <= len(self.layouts) <= SUB_MODEL.high + 1:
            raise ValueError(f"a profile has 1 to {SUB_MODEL.high + 1} sub-models, got {len(self.layouts)}")
        octets = -(-sum(layout.bits for layout in self.layouts) // 8)
        if octets > MAX_COEFFICIENT_OCTETS:
            raise ValueError(f"coefficients take {MAX_COEFFICIENT_OCTETS} octets at most, here {octets}")

    @classmethod
    def of(cls, bank: Bank, number: int) -> "WireProfile":
        """Profile of a bank.

        Parameters
        ----------
        bank
            Its sub-models; of one without a layout the predicted path is carried.
        number
            Number of the profile they are from.

        Raises
        ------
        ValueError
            As for the profile's own fields.
        """
        return cls(number, tuple(carried_layout(member) for member in bank.members))

    @classmethod
    def of_profile(cls, profile: Profile) -> "WireProfile":
        """Profile by the bytes that name it.

        Parameters
        ----------
        profile
            The profile.

        Raises
        ------
        ValueError
            As for `of`.
        """
        return cls.of(profile.bank, profile_number(profile.named_bytes))

    def carried(self, sub_model: int, *, carries_all: bool) -> tuple[int, ...]:
        """Sub-models whose coefficients a message holds.

        Parameters
        ----------
        sub_model, carries_all
            As in `ModelExtension`.
        """
        return tuple(range(len(self.layouts))) if carries_all else (sub_model,)

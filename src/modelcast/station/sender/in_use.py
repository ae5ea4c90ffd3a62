"""The bank and the rules that a user means who names a sender: the same wherever a sender is named."""

from typing import TypedDict

from modelcast.core.kinds import Kind
from modelcast.models.bank import Bank
from modelcast.models.learned import Selector
from modelcast.models.profile import Profile
from modelcast.station.banks import NamedBank, free_bank
from modelcast.station.policy.costs import CostTable
from modelcast.station.policy.rules import CostUnit, IdentifyRule, StartRule
from modelcast.station.sender.names import own_sender, sends_free

__all__ = ["InUse", "in_use"]


class InUse(TypedDict):
    """Bank and rules of a sender, as `modelcast.station.sender.sender.named_sender` takes them."""

    bank: Bank | None
    start: StartRule | None
    identify: IdentifyRule | None
    costs: CostTable | None
    selector: Selector | None


def in_use(
    policy: str,
    named: NamedBank | None,
    *,
    profile: Profile,
    kind: Kind = Kind.VEHICLE,
    start: StartRule | None = None,
    identify: IdentifyRule | None = None,
    cost: CostUnit = "bytes",
) -> InUse:
    """The bank of a policy, and its rules: those asked for, else the bank's where it is error-driven.

    Parameters
    ----------
    policy
        Name of the sender.
    named
        The bank that was named; None for a policy that sends no model.
    profile
        The one in use: the free policies of vehicles take its sub-model.
    kind
        Of who sends.
    start, identify, cost
        As asked for; None for the bank's.

    Examples
    --------
    >>> from modelcast.models.profile import default_profile
    >>> [in_use("free", None, profile=default_profile(), kind=kind)["bank"].members[0].name
    ...  for kind in (Kind.VEHICLE, Kind.PEDESTRIAN)]
    ['free', 'stop-and-go']
    """
    if named is None:
        bank = free_bank(profile, kind) if sends_free(policy) else None
        return InUse(bank=bank, start=None, identify=None, costs=None, selector=None)
    failing = own_sender(policy) == "mbc"
    start = start or (named.start if failing else None)
    identify = identify or named.identify if failing else None
    return InUse(
        bank=named.bank,
        start=start,
        identify=identify,
        costs=named.costs(cost) if identify == "cheapest" else None,
        selector=named.selector if start == "predicted" else None,
    )

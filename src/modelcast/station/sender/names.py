"""Names of senders: ours, and the policies of other packages.

Other packages add a policy through the entry-point group ``modelcast.policies``: each entry point loads a
class derived from `modelcast.station.policy.base.AbstractTransmitPolicy` whose arguments all have defaults.
It sends the models of whatever bank is named, as ``mbc`` does.
"""

from typing import Any

from modelcast.core.exceptions import ConfigError
from modelcast.core.named_settings import named_settings
from modelcast.core.open_group import OpenGroup
from modelcast.station.policy.base import AbstractTransmitPolicy, at_threshold, takes_threshold

__all__ = [
    "ERROR_SENDERS",
    "FREE_SENDERS",
    "MODEL_SENDERS",
    "POLICIES",
    "SENDERS",
    "check_sender",
    "foreign_policy",
    "has_threshold",
    "plain_policy",
    "sends_models",
    "sets_threshold",
]

SENDERS = (
    "bsm-10hz",
    "baseline",
    "free",
    "mbc",
    "j2945",
    "j2945-filtered",
    "j2945-free",
    "j2945-free-relaxed",
    "j2945-free-relaxed-5",
    "j2945-mbc",
    "j2945-mbc-relaxed",
    "j2945-mbc-relaxed-5",
    "cam",
    "cam-reactive",
    "cam-uncontrolled",
    "cam-road",
)
"""Names of ours, as `modelcast.station.sender.sender.named_sender` makes them."""

MODEL_SENDERS = tuple(name for name in SENDERS if "mbc" in name)
"""Those that send models; the others send basic safety messages, and no bank makes a difference to them."""

FREE_SENDERS = tuple(name for name in SENDERS if "free" in name)
"""Those whose plain messages are coasted by the best free sub-model, whatever the bank of the others."""

ERROR_SENDERS = ("baseline", "free", "mbc")
"""Those that a tracking error over a threshold calls; timers call the others."""

POLICIES: OpenGroup[AbstractTransmitPolicy[Any]] = OpenGroup(
    "modelcast.policies",
    AbstractTransmitPolicy,
    called="policy",
    own=dict.fromkeys(SENDERS, "modelcast.station.sender.sender:named_sender"),
)
"""Our senders, behind whose names stands what makes the whole sender, and policies of other packages."""


def check_sender(text: str) -> None:
    """Refuse what names no sender.

    Parameters
    ----------
    text
        One of `SENDERS`, or another package's policy as ``NAME`` or ``NAME:KEY=VALUE,KEY=VALUE``.

    Raises
    ------
    ConfigError
        Where nothing of that name is known, or it refuses its settings.
    """
    if text in SENDERS:
        POLICIES.loaded(text)
    else:
        foreign_policy(text)


def sends_models(text: str) -> bool:
    """Whether a bank makes a difference to a sender: another package's policy sends by any.

    Parameters
    ----------
    text
        As for `check_sender`.
    """
    return text in MODEL_SENDERS or text not in SENDERS


def sets_threshold(text: str) -> bool:
    """Whether a word sets a threshold itself.

    Parameters
    ----------
    text
        As for `check_sender`.
    """
    return "threshold_m" in named_settings(text)[1]


def has_threshold(text: str) -> bool:
    """Whether a sender is run at each threshold: where a tracking error over it calls for messages.

    Parameters
    ----------
    text
        As for `check_sender`. Another package's policy has one where a setting of it is `threshold_m`, and
        its word does not set it.
    """
    if text in SENDERS:
        return text in ERROR_SENDERS
    return not sets_threshold(text) and takes_threshold(foreign_policy(text))


def foreign_policy(text: str) -> AbstractTransmitPolicy[Any]:
    """Return a policy of another package.

    Parameters
    ----------
    text
        As for `check_sender`, none of ours.

    Raises
    ------
    ConfigError
        Where it is one of ours, nothing of that name is known, or it refuses its settings.
    """
    if named_settings(text)[0] in SENDERS:
        raise ConfigError(f"{text!r} is a sender of modelcast: name a policy of another package")
    return POLICIES.made_from(text)


def plain_policy(text: str, threshold_m: float) -> AbstractTransmitPolicy[Any]:
    """Return another package's policy, at a threshold where it has one.

    Parameters
    ----------
    text
        As for `check_sender`, none of ours.
    threshold_m
        The threshold [m].

    Raises
    ------
    ConfigError
        As for `check_sender`.
    ValueError
        Where it refuses the threshold.
    """
    policy = foreign_policy(text)
    return at_threshold(policy, threshold_m) if has_threshold(text) else policy

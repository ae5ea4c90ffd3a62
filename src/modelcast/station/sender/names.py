"""Names of senders: ours, and the policies of other packages.

Other packages add a policy through the entry-point group ``modelcast.policies``: each entry point loads a
class derived from `modelcast.station.policy.base.AbstractTransmitPolicy` whose arguments all have defaults.
It sends the models of whatever bank is named, as ``mbc`` does.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
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
    "SWITCHES",
    "OwnSettings",
    "check_one_word_each",
    "check_sender",
    "foreign_policy",
    "has_threshold",
    "own_sender",
    "own_settings",
    "plain_policy",
    "sends_free",
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
    "j3161",
    "j3161-mbc",
    "j3161-mbc-relaxed",
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

SWITCHES = ("power_control", "tracking_error_trigger")
"""Settings of the senders under SAE J3161/1, on which sources disagree."""

_GRANTS = ("any", "periodic", "one-shot")

ERROR_SENDERS = ("baseline", "free", "mbc")
"""Those that a tracking error over a threshold calls; timers call the others."""

POLICIES: OpenGroup[AbstractTransmitPolicy[Any]] = OpenGroup(
    "modelcast.policies",
    AbstractTransmitPolicy,
    called="policy",
    own=dict.fromkeys(SENDERS, "modelcast.station.sender.sender:named_sender"),
)
"""Our senders, behind whose names stands what makes the whole sender, and policies of other packages."""


def own_sender(text: str) -> str | None:
    """Return which of `SENDERS` a word stands for; None for none of ours.

    Parameters
    ----------
    text
        As for `check_sender`.

    Examples
    --------
    >>> own_sender("j3161:power_control=true"), own_sender("another")
    ('j3161', None)
    """
    name = text.partition(":")[0]
    return name if name in SENDERS else None


def sends_free(text: str) -> bool:
    """Whether a sender's plain messages are coasted by the best free sub-model, as those of `FREE_SENDERS`.

    Parameters
    ----------
    text
        As for `check_sender`.
    """
    return own_sender(text) in FREE_SENDERS


def check_sender(text: str) -> None:
    """Refuse what names no sender.

    Parameters
    ----------
    text
        One of `SENDERS`, or another package's policy; either as ``NAME`` or ``NAME:KEY=VALUE,KEY=VALUE``.

    Raises
    ------
    ConfigError
        Where nothing of that name is known, or it refuses its settings.
    """
    name = own_sender(text)
    if name is None:
        foreign_policy(text)
        return
    POLICIES.loaded(name)
    own_settings(text)


def check_one_word_each(texts: Iterable[str]) -> None:
    """Refuse two words for one sender, which would be run as two.

    Parameters
    ----------
    texts
        Each as for `check_sender`; the same word may come again.

    Raises
    ------
    ConfigError
        Where two set the same, in another spelling or order.

    Examples
    --------
    >>> check_one_word_each(["j3161", "j3161:power_control=yes", "j3161"])
    >>> check_one_word_each(["mbc", "mbc:grant=any"])
    Traceback (most recent call last):
    modelcast.core.exceptions.ConfigError: 'mbc:grant=any' is 'mbc': name it once
    """
    found: dict[str, str] = {}
    for text in texts:
        name, given = named_settings(text)
        if own_sender(text) is not None:
            said = own_settings(text)
            given = {"grant": said.grant, **said.switches}
        first = found.setdefault(repr((name, sorted(given.items()))), text)
        if first != text:
            raise ConfigError(f"{text!r} is {first!r}: name it once")


@dataclass(frozen=True, slots=True)
class OwnSettings:
    """What the word of one of our senders sets.

    Parameters
    ----------
    grant
        Which `modelcast.channel.radio.Grant` each message asks for: ``any``, ``periodic`` or ``one-shot``.
    switches
        Of SAE J3161/1, for the senders under it: `power_control`, `tracking_error_trigger`.
    """

    grant: str = "any"
    switches: Mapping[str, bool] = field(default_factory=dict[str, bool])


def own_settings(text: str) -> OwnSettings:
    """Return what the word of one of our senders sets.

    Parameters
    ----------
    text
        One of `SENDERS`, or ``NAME:KEY=VALUE,KEY=VALUE``. All take ``grant``: ``any``, ``periodic`` or
        ``one-shot``. Those under SAE J3161/1 take its switches: ``true`` or ``yes``, ``false`` or ``no``.

    Raises
    ------
    ConfigError
        Where the word has another form, a setting is not known, or its value is none of these.

    Examples
    --------
    >>> own_settings("j3161:power_control=yes,grant=one-shot").switches
    {'power_control': True}
    """
    name, given = named_settings(text)
    known = ("grant", *(SWITCHES if name.startswith("j3161") else ()))
    for key in given:
        if key not in known:
            raise ConfigError(f"{text!r}: {name} has no setting {key!r}; it takes {', '.join(known)}")
    grant = str(given.pop("grant", "any"))
    if grant not in _GRANTS:
        raise ConfigError(f"{text!r}: grant must be one of {', '.join(_GRANTS)}, got {grant!r}")
    switches: dict[str, bool] = {}
    for key, value in given.items():
        if not isinstance(value, bool):
            raise ConfigError(f"{text!r}: {key} must be yes or no, got {value!r}")
        switches[key] = value
    return OwnSettings(grant, switches)


def sends_models(text: str) -> bool:
    """Whether a bank makes a difference to a sender: another package's policy sends by any.

    Parameters
    ----------
    text
        As for `check_sender`.
    """
    name = own_sender(text)
    return name is None or name in MODEL_SENDERS


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
    name = own_sender(text)
    if name is not None:
        return name in ERROR_SENDERS
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
    if own_sender(text) is not None:
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

"""A word on the command line that names one of an open group: refused with its option."""

import warnings
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

from modelcast.core.exceptions import ConfigError, ModelcastWarning

if TYPE_CHECKING:
    from modelcast.models.bank import Bank
    from modelcast.station.policy.base import AbstractTransmitPolicy

__all__ = ["check_word", "origins_in_use", "policy_that_decides"]


def check_word(option: str, check: Callable[[str], object], word: str) -> None:
    """Refuse a word that names nothing.

    Parameters
    ----------
    option
        Where it stands, ``--radio`` for one.
    check
        Refuses it by a ConfigError.
    word
        As the user gives it.

    Raises
    ------
    ConfigError
        As the check, with the option.
    """
    try:
        check(word)
    except ConfigError as error:
        raise ConfigError(f"{option}: {error}") from error


def policy_that_decides(word: str) -> "AbstractTransmitPolicy[Any]":
    """The policy that ``--policy`` names over recorded trips, which ``--threshold`` runs at each threshold.

    Parameters
    ----------
    word
        As the user gives it.

    Raises
    ------
    ConfigError
        Where it is no policy of another package, or sets a threshold of its own.
    """
    from modelcast.station.policy.base import takes_threshold
    from modelcast.station.sender.names import foreign_policy, sets_threshold

    check_word("--policy", foreign_policy, word)
    if sets_threshold(word):
        raise ConfigError(f"--policy {word}: leave threshold_m out and give --threshold")
    policy = foreign_policy(word)
    if not takes_threshold(policy):
        warnings.warn(
            f"--policy {word} has no threshold_m: it sends the same at every --threshold, which is that of "
            "the baselines beside it.",
            ModelcastWarning,
            stacklevel=2,
        )
    return policy


def origins_in_use(policy: str | None, banks: "Iterable[Bank]") -> dict[str, str]:
    """Package and version of what other packages bring to senders over recorded trips, by kind and word.

    Parameters
    ----------
    policy
        What ``--policy`` names, as the user gives it; None where it is not given.
    banks
        Whose sub-models are sent.
    """
    from modelcast.models.sub_models import sub_model_origins
    from modelcast.station.sender.names import POLICIES

    members = (member for bank in banks for member in bank.members)
    return {**({} if policy is None else POLICIES.origins([policy])), **sub_model_origins(members)}

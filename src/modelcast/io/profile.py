"""Profiles as files."""

from pathlib import Path
from typing import get_args

from modelcast.core.exceptions import ConfigError
from modelcast.core.rules import FieldError, Text, check
from modelcast.io.output import atomic_file
from modelcast.io.regular import read_document
from modelcast.messages.mbc_profile import WireProfile
from modelcast.models.profile import Profile, profile_from_text
from modelcast.station.policy.costs import CostTable
from modelcast.station.policy.guard import GUARD
from modelcast.station.policy.rules import IdentifyRule, StartRule

__all__ = ["read_profile", "write_profile"]

_START, _IDENTIFY = Text(choices=get_args(StartRule)), Text(choices=get_args(IdentifyRule))


def read_profile(path: str | Path) -> Profile:
    """The profile in a file that ``modelcast train`` wrote, checked field by field.

    Parameters
    ----------
    path
        The file.

    Raises
    ------
    ConfigError
        Where it is no ordinary file, too large, or no profile; it names the file, the path of the field, what
        stands there and what was expected.
    """
    text = read_document(Path(path))
    try:
        profile = profile_from_text(text)
        _require_usable(profile)
    except ValueError as error:
        raise ConfigError(
            f"{path} is no profile: {error}. Name a file that 'modelcast train' wrote."
        ) from error
    return profile


def _require_usable(profile: Profile) -> None:
    """Refuse rules that nobody knows, costs that are none, and a bank that no message can carry."""
    check(profile.start, _START, "$.start")
    check(profile.identify, _IDENTIFY, "$.identify")
    names = [member.name for member in profile.bank.members]
    if profile.start == "guarded" and len(names) > 1 and GUARD not in names:
        raise FieldError("$.members", names, f"sub-models with {GUARD} among them, which 'guarded' needs")
    if profile.start == "predicted" and profile.selector is None:
        raise FieldError("$.selector", None, "a selector, which 'predicted' needs")
    if profile.costs:
        try:
            CostTable.from_plain(profile.costs).check_members(len(profile.bank.complete().members))
        except FieldError as error:
            raise FieldError(
                f"$.costs{error.place.removeprefix('$')}", error.value, error.expected
            ) from error
        except ValueError as error:
            raise ValueError(f"$.costs: {error}") from error
    try:
        WireProfile.of_profile(profile)
    except ValueError as error:
        raise ValueError(f"$.members: no message can carry them: {error}") from error


def write_profile(profile: Profile, path: str | Path) -> None:
    """Write the profile's text.

    Parameters
    ----------
    profile
        The profile.
    path
        The file, which appears whole or not at all.

    Raises
    ------
    ConfigError
        Where its folder does not exist, or it cannot be written.
    """
    with atomic_file(path) as file:
        file.write(profile.text.encode())

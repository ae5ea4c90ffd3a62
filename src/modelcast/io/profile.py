"""Profiles as files."""

from pathlib import Path

from modelcast.core.exceptions import DataFormatError
from modelcast.models.profile import Profile, profile_from_text

__all__ = ["read_profile", "write_profile"]


def read_profile(path: str | Path) -> Profile:
    """The profile in a file that ``modelcast train`` wrote.

    Parameters
    ----------
    path
        The file.

    Raises
    ------
    DataFormatError
        Where it is missing or no profile.
    """
    try:
        text = Path(path).read_text(encoding="utf-8")
        return profile_from_text(text)
    except OSError as error:
        raise DataFormatError(
            str(path), f"cannot be read: {error.strerror}", remedy="Name a file that 'modelcast train' wrote."
        ) from error
    except ValueError as error:
        raise DataFormatError(
            str(path), f"is no profile: {error}", remedy="Name a file that 'modelcast train' wrote."
        ) from error


def write_profile(profile: Profile, path: str | Path) -> None:
    """Write the profile's canonical text; its bytes have the profile's identity as SHA-256.

    Parameters
    ----------
    profile
        The profile.
    path
        The file; its folder must exist.
    """
    Path(path).write_text(profile.text, encoding="utf-8", newline="\n")

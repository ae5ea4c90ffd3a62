"""Banks and profiles as users name them: by a word, or by a file."""

from pathlib import Path

from modelcast.io.profile import read_profile
from modelcast.models.profile import Profile, default_profile, shipped_profile
from modelcast.models.shipped import SHIPPED, names_profile
from modelcast.station.banks import NamedBank, named_bank

__all__ = ["bank_in_use", "profile_in_use"]


def profile_in_use(path: str | Path | None) -> Profile:
    """The profile in a file, or one that ships with modelcast.

    Parameters
    ----------
    path
        The file, or the name of a shipped profile; None for that of vehicles.

    Raises
    ------
    DataFormatError
        Where it is no profile.
    """
    if path is None:
        return default_profile()
    return shipped_profile(str(path)) if str(path) in SHIPPED else read_profile(path)


def bank_in_use(
    text: str,
    *,
    profile: Profile,
    noise_floor_m: float | None = None,
    window: int = 10,
    trusted_horizon_s: float | None = None,
) -> NamedBank:
    """The bank a user means, and its rules.

    Parameters
    ----------
    text
        A file that ``modelcast train`` wrote (its name ends in .json), ``people`` for the bank of the shipped
        profile of people, or what `named_bank` takes.
    profile
        The profile in use.
    noise_floor_m, window, trusted_horizon_s
        As for `named_bank`.

    Raises
    ------
    ConfigError
        As for `named_bank`.
    DataFormatError
        Where the file is no profile.
    """
    return named_bank(
        "default" if names_profile(text) else text,
        noise_floor_m=noise_floor_m,
        window=window,
        trusted_horizon_s=trusted_horizon_s,
        profile=profile_in_use(text) if names_profile(text) else profile,
        label=text,
    )

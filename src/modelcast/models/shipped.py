"""The profiles that ship with modelcast, by name: ``default`` for vehicles, ``people`` for people."""

import importlib.resources
import re
from pathlib import Path

__all__ = ["DEFAULT", "PEOPLE", "SHIPPED", "bank_name", "names_profile", "profile_path"]

DEFAULT = "default"
"""The profile of vehicles, in use where nobody names another."""

PEOPLE = "people"
"""The profile of people on foot and on bicycles (``docs/people.md``)."""

SHIPPED = (DEFAULT, PEOPLE)
"""Names of the profiles that ship."""

_SETTINGS = re.compile(r":[A-Za-z]\w*=")
"""Where a sub-model's settings begin (`modelcast.core.named_settings`)."""


def profile_path(text: str | Path) -> Path:
    """The file of a profile that a user names.

    Parameters
    ----------
    text
        A name of `SHIPPED`, or the file itself.

    Examples
    --------
    >>> profile_path("people").name, profile_path("mine.json").name
    ('people.json', 'mine.json')
    """
    if str(text) not in SHIPPED:
        return Path(text)
    with importlib.resources.as_file(importlib.resources.files("modelcast") / "profiles") as folder:
        return folder / f"{text}.json"


def names_profile(bank: str) -> bool:
    """Whether the text of a bank names a profile other than the one in use: a file, or ``people``.

    Parameters
    ----------
    bank
        As users write it.

    Examples
    --------
    >>> [names_profile(text) for text in ("people", "mine.json", "default", "cv+ctra", "near:file=a.json")]
    [True, True, False, False, False]
    """
    return bank == PEOPLE or (bank.endswith(".json") and not _SETTINGS.search(bank))


def bank_name(bank: str) -> str:
    """A bank as rows and run keys name it: of a file its last part, of any other text all of it.

    Parameters
    ----------
    bank
        As users write it.

    Examples
    --------
    >>> [bank_name(text) for text in ("banks/mine.json", "cv+ctra", "near:file=a/b")]
    ['mine.json', 'cv+ctra', 'near:file=a/b']
    """
    return Path(bank).name if names_profile(bank) else bank

"""A word on the command line that names one of an open group: refused with its option."""

from collections.abc import Callable

from modelcast.core.exceptions import ConfigError

__all__ = ["check_word"]


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

"""What is said of words that the command line does not take: the cause, and what to type instead."""

import re
from collections.abc import Sequence
from difflib import SequenceMatcher
from pathlib import Path

from cyclopts import (
    CoercionError,
    CycloptsError,
    MissingArgumentError,
    UnknownCommandError,
    UnknownOptionError,
)

__all__ = ["usage_problem"]

_NUMBER_AND_UNIT = re.compile(r"[-+]?[\d.,]+(e[-+]?\d+)?\s*(%|[a-zµ]+)", re.IGNORECASE)
_GUESS = re.compile(r"(--\S+?)\. Did you mean (--\S+?)\?")
_ALIKE = 0.75
_NAMES_LISTED = re.compile(r" Available commands: .*", re.DOTALL)


def usage_problem(error: CycloptsError, words: Sequence[str]) -> str:
    """Return a line on words that are refused.

    Parameters
    ----------
    error
        What cyclopts says.
    words
        All words after ``modelcast``.
    """
    text = _without_far_guess(" ".join(str(error).split()))
    chain = " ".join(error.command_chain or ())
    helped = " ".join(("modelcast", *chain.split(), "--help"))
    if isinstance(error, UnknownCommandError):
        token = (error.unused_tokens or [""])[0]
        return f"{_NAMES_LISTED.sub('', text)} {_instead(token)}{helped} lists all."
    if "-" in words and isinstance(error, UnknownOptionError):
        return f"{text} Only decode and encode read the standard input: write it into a file and name that."
    if isinstance(error, CoercionError) and error.token is not None:
        if "Choose from" in text:
            return text
        remedy = _remedy(error.token.value, error.token.keyword or "")
        return f"{text} {remedy}" if remedy else f"{text} {helped} says what it takes."
    if isinstance(error, MissingArgumentError):
        return f"{text} {helped} shows an example."
    return f"{text} {helped} lists all options."


def _without_far_guess(text: str) -> str:
    """The text without a question for an option that is hardly like the one that was given."""
    guess = _GUESS.search(text)
    if guess is None or SequenceMatcher(None, guess[1], guess[2]).ratio() >= _ALIKE:
        return text
    return text.replace(guess[0], f"{guess[1]}.")


def _instead(word: str) -> str:
    """What to type where no command stands but something else; nothing where that is not known."""
    if word == "help":
        return "For help, type --help. "
    if Path(word).exists():
        return f"It is a file or folder: modelcast evaluate {word} evaluates it. "
    return ""


def _remedy(value: str, option: str) -> str:
    """What to type instead of a value that is no number; nothing where that is not known."""
    if (
        Path(value).suffix
        and not _is_number(value)
        and (Path(value).exists() or value.rpartition(".")[2].isalpha())
    ):
        return f"Put files before {option}." if option else ""
    if "," in value and all(part.strip() for part in value.split(",")):
        return f"Write several after one another, with a point for decimals: {option} {_apart(value)}."
    if _is_number(value):
        return f"Give {option} a whole number." if option else ""
    if _NUMBER_AND_UNIT.fullmatch(value):
        return f"Write the number alone, in the unit that --help names for {option}."
    return ""


def _is_number(value: str) -> bool:
    try:
        float(value)
    except ValueError:
        return False
    return True


def _apart(value: str) -> str:
    return " ".join(part.strip() for part in value.split(","))

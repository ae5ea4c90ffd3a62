"""Errors of two held against one another, case by case: in how many one errs more, and where most."""

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass

from modelcast.report.ratio_words import share_text
from modelcast.study.wording import centimetres

__all__ = ["HeldErrors", "chance_text", "worse_text"]


@dataclass(frozen=True, slots=True)
class HeldErrors:
    """The errors of two at one threshold and loss ratio.

    Parameters
    ----------
    threshold_m, ratio
        Which case.
    own_m, other_m
        90th percentile of whoever is judged, and of whom it is held against [m].
    paid
        Messages of the first over the second's.
    may_be_chance
        Whether intervals cannot tell the two apart; None where there are none.
    """

    threshold_m: float
    ratio: float
    _: KW_ONLY
    own_m: float
    other_m: float
    paid: float
    may_be_chance: bool | None

    @property
    def over(self) -> float:
        """One over the other."""
        return self.own_m / self.other_m

    @property
    def is_worse(self) -> bool:
        """Whether whoever is judged errs more."""
        return self.own_m > self.other_m


def worse_text(
    name: str,
    same: Sequence[HeldErrors],
    matched: Sequence[HeldErrors],
    *,
    at_rate: str = "at the same rate",
) -> str:
    """Return in how many cases somebody errs more than another, by reading, and where most; or nothing.

    Parameters
    ----------
    name
        Of the other's error.
    same, matched
        The cases at the same threshold, and at the same rate.
    at_rate
        What the latter rate is called.
    """
    readings = (("at the same threshold", same), (at_rate, matched))
    parts = [f"in {_many(cases)} {at}{_most(cases, at)}" for at, cases in readings if cases]
    return f"{name} {' and '.join(parts)}" if parts else ""


def chance_text(cases: Sequence[HeldErrors], rival: str) -> str:
    """Return where the seeds cannot tell a comparison at the same rate from chance.

    Parameters
    ----------
    cases
        The cases; nothing is said of none.
    rival
        Who the second is.
    """
    known = [case for case in cases if case.may_be_chance is not None]
    if not known:
        return " One seed has no interval that tells this from chance." if cases else ""
    alike = share_text(sum(case.may_be_chance is True for case in known), len(known))
    return f" At the same rate its interval over the seeds and the {rival}'s overlap in {alike}."


def _many(cases: Sequence[HeldErrors]) -> str:
    return share_text(sum(case.is_worse for case in cases), len(cases))


def _most(cases: Sequence[HeldErrors], at: str) -> str:
    """Where the first errs most, and at the same threshold what that saved."""
    worse = [case for case in cases if case.is_worse]
    if not worse:
        return ""
    most = max(worse, key=lambda case: case.over)
    place = centimetres(most.threshold_m) + (f", {100 * most.ratio:.4g} % lost" if most.ratio else "")
    price = f", for {most.paid:.2f} times the messages" if at == "at the same threshold" else ""
    return f" (most at {place}: {most.own_m:.2f} against {most.other_m:.2f} m{price})"

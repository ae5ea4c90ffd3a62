"""Banks of sub-models by name, and the rules they are used with."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import isfinite
from typing import cast

import numpy as np

from modelcast.core.exceptions import ConfigError
from modelcast.core.kinds import PEOPLE, Kind
from modelcast.core.near_names import near
from modelcast.messages.airtime import Stack
from modelcast.messages.mbc_wire import profile_number
from modelcast.messages.sizes import SizeModel
from modelcast.models.bank import Bank
from modelcast.models.base import AbstractSubModel
from modelcast.models.calibration import Calibration
from modelcast.models.constant_velocity import ConstantVelocity
from modelcast.models.gp import (
    GaussianProcess,
    KernelProcess,
    VehicleProcess,
    linear_process,
    process_of,
)
from modelcast.models.learned import Selector
from modelcast.models.profile import Profile, default_profile, people_plain_bank, people_profile
from modelcast.models.regimes import REGIME_BANK
from modelcast.models.reserved import EXPRESSION, KINEMATIC, UNTRAINED
from modelcast.models.sub_models import SUB_MODELS, model_of_word, names_registered
from modelcast.models.trusted import Trusted
from modelcast.station.policy.costs import CostTable
from modelcast.station.policy.guard import unguarded
from modelcast.station.policy.rules import BelieveRule, CostUnit, IdentifyRule, StartRule

__all__ = [
    "BASELINE_BANK",
    "FREE",
    "PAPER_BANK",
    "PAPER_NOISE_FLOOR_M",
    "NamedBank",
    "bank_from_text",
    "believe_of",
    "calibrations_of",
    "free_bank",
    "free_receiver",
    "member_names",
    "named_bank",
    "parts_of",
    "profile_number_of",
    "rules_of",
]

PAPER_NOISE_FLOOR_M = 1e-5
"""The paper's Gaussian process has no noise floor: a hundredth of a millimetre stands for none [m]."""

PAPER_BANK = Bank(
    (ConstantVelocity(), GaussianProcess(form="anchored", noise_floor_m=PAPER_NOISE_FLOOR_M)),
    "paper",
)
"""The paper's bank: constant velocity, then the per-axis maximum-likelihood Gaussian process."""

BASELINE_BANK = Bank((ConstantVelocity(),), "cv")
"""Raw basic safety messages: the receiver coasts at constant velocity."""

DEFAULT = "default"
"""The bank of the profile in use."""

CONTEXT = "free-context"
"""Name of the sub-model that also knows the vehicle ahead and the road."""

WITH_CONTEXT = "default+context"
"""The bank of the profile in use with that sub-model before its own."""

FREE = "free"
"""Name of the sub-model, and of the bank of it alone, that a plain message is best coasted by."""


def free_bank(profile: Profile | None = None, kind: Kind = Kind.VEHICLE) -> Bank:
    """The best receiver of plain messages: the profile's sub-model ``free``, or ``ctra`` where it has none.

    Parameters
    ----------
    profile
        The profile in use; the one that ships with modelcast where None.
    kind
        Of who sends them; people's are coasted by the shipped stop-and-go switch, whatever the profile.

    Examples
    --------
    >>> free_bank().name
    'free'
    """
    if kind in PEOPLE:
        return people_plain_bank()
    return Bank((_free(default_profile() if profile is None else profile),), FREE)


def _free(profile: Profile) -> AbstractSubModel:
    found = profile.sub_model(FREE)
    return KINEMATIC["ctra"] if found is None else found


def rules_of(bank: Bank) -> tuple[StartRule, IdentifyRule]:
    """The rules that a bank is used with where nobody says otherwise.

    Parameters
    ----------
    bank
        The shipped profile's bank is used as that profile says, the best free receiver as an order that no
        message changes, any other as the paper reads.
    """
    profile = default_profile()
    if bank == profile.bank:
        return cast("StartRule", profile.start), cast("IdentifyRule", profile.identify)
    return "order", "never" if bank.label == FREE else "on-failure"


def believe_of(start: StartRule, identify: IdentifyRule) -> BelieveRule:
    """What senders take their remotes to hold where nobody says otherwise.

    Parameters
    ----------
    start, identify
        The rules in use. Senders that choose by a threshold and name nobody without an update, as those of a
        profile's bank, expect losses; those of the paper believe in what they sent.
    """
    chooses = start in {"guarded", "hindsight", "predicted"}
    return "expected" if chooses and identify == "never" else "sent"


def calibrations_of(bank: Bank) -> Mapping[str, Calibration]:
    """What makes the covariances of a bank honest, by sub-model; empty where nobody measured it.

    Parameters
    ----------
    bank
        The shipped profile's bank has that profile's, any other none.
    """
    profile = default_profile()
    return profile.calibrations if bank == profile.bank else {}


INTERCEPT_NOISE_FLOOR_M = 1e-3
"""Smallest noise of ``gp-intercept`` and ``gp-adaptive`` where the user names none [m]."""

_DEFAULT_WINDOW = 10


@dataclass(frozen=True, slots=True)
class NamedBank:
    """The bank a user means, and the rules it is used with.

    Parameters
    ----------
    bank
        Its sub-models.
    start, identify
        The policy's rules where the user names none.
    profile
        The profile it comes from; None where it comes from none.
    trained_on
        Fingerprints of the trips that any of its sub-models was trained on.
    """

    bank: Bank
    start: StartRule
    identify: IdentifyRule
    profile: Profile | None = None
    trained_on: frozenset[str] = frozenset()

    @property
    def selector(self) -> Selector | None:
        """What the start rule ``predicted`` asks, where the profile has it."""
        return None if self.profile is None else self.profile.selector

    def costs(self, unit: CostUnit) -> CostTable | None:
        """What the rule ``cheapest`` weighs, where the profile has it.

        Parameters
        ----------
        unit
            What a message costs: ``messages`` counts one each, ``bytes`` their octets, ``airtime`` the
            seconds of their frames with certificates.

        Raises
        ------
        ConfigError
            Where the profile's costs are damaged.
        """
        if self.profile is None or not self.profile.costs:
            return None
        try:
            table = CostTable.from_plain(self.profile.costs)
        except (KeyError, TypeError, ValueError) as error:
            raise ConfigError(f"the profile's costs are damaged: {error}") from error
        sizes = SizeModel()
        octets = np.array([sizes.each_update_bytes(self.bank, "cheapest").max(), sizes.identification_bytes])
        if unit == "messages":
            return table.priced(1.0, 1.0)
        if unit == "bytes":
            return table.priced(float(octets[0]), float(octets[1]))
        airtime_s = Stack().airtime_s(octets.astype(np.int64), np.ones(2, dtype=np.bool_))
        return table.priced(float(airtime_s[0]), float(airtime_s[1]))


def free_receiver(profile: Profile) -> NamedBank:
    """What a bank under a profile is held against: the free receiver of those whose profile it is.

    Parameters
    ----------
    profile
        The profile in use; where that is the shipped one of people, a message is coasted as theirs are.
    """
    kind = Kind.PEDESTRIAN if profile == people_profile() else Kind.VEHICLE
    members = free_bank(profile, kind).members
    trained = any(_is_trained(member.name, profile) for member in members)
    return NamedBank(
        Bank(members, FREE), "order", "never", trained_on=frozenset(profile.training_trips if trained else ())
    )


def member_names(profile: Profile) -> tuple[str, ...]:
    """Sub-models that a bank may be made of: untrained ones, the profile's, and those of other packages.

    Parameters
    ----------
    profile
        The profile in use.
    """
    trained = (member.name for member in profile.sub_models)
    return tuple(dict.fromkeys((*UNTRAINED, *trained, *SUB_MODELS.foreign_names())))


def named_bank(
    text: str,
    *,
    noise_floor_m: float | None = None,
    window: int = _DEFAULT_WINDOW,
    trusted_horizon_s: float | None = None,
    profile: Profile | None = None,
    label: str | None = None,
) -> NamedBank:
    """The bank a user means, and its rules.

    Parameters
    ----------
    text
        ``default`` (the bank of the profile in use), ``default+context`` (the same, with the sub-model that
        knows the vehicle ahead and the road before its own), or anything that `bank_from_text` takes.
    noise_floor_m, window, trusted_horizon_s
        As for `bank_from_text`; a profile's bank has its own.
    profile
        The profile in use; the one that ships with modelcast where None.
    label
        What errors call the bank; ``text`` where None.

    Raises
    ------
    ConfigError
        Where a name is unknown, a value out of range, or an option is given that a profile's bank does not
        take.
    """
    profile = default_profile() if profile is None else profile
    rules = cast("StartRule", profile.start), cast("IdentifyRule", profile.identify)
    if text not in (DEFAULT, WITH_CONTEXT):
        bank = bank_from_text(
            text,
            noise_floor_m=noise_floor_m,
            window=window,
            trusted_horizon_s=trusted_horizon_s,
            profile=profile,
        )
        rules = (unguarded(rules[0]), rules[1]) if text in (REGIME_BANK, FREE) else rules_of(bank)
        trained = any(_is_trained(member.name, profile) for member in bank.members)
        return NamedBank(bank, *rules, trained_on=frozenset(profile.training_trips if trained else ()))
    if noise_floor_m is not None or trusted_horizon_s is not None or window != _DEFAULT_WINDOW:
        raise ConfigError(
            f"--bank {label or text}: a profile's bank has its own windows, noise floor and trusted "
            "horizons; leave out --window, --noise-floor and --trusted-horizon, or name the sub-models"
        )
    trained_on = frozenset(profile.training_trips)
    if text == WITH_CONTEXT:
        return NamedBank(_with_context(profile), *rules, trained_on=trained_on)
    return NamedBank(profile.bank, *rules, profile, trained_on)


def _with_context(profile: Profile) -> Bank:
    """The profile's bank with the sub-model that knows the vehicle ahead and the road before all others."""
    found = profile.sub_model(CONTEXT)
    if found is None:
        raise ConfigError(
            f"--bank {WITH_CONTEXT}: the profile has no sub-model {CONTEXT}; train one with 'modelcast train'"
        )
    bank = profile.bank
    others = tuple(member for member in bank.members if member.name != CONTEXT)
    return Bank((found, *others), WITH_CONTEXT, bank.plain)


def bank_from_text(
    text: str,
    *,
    noise_floor_m: float | None = None,
    window: int = _DEFAULT_WINDOW,
    trusted_horizon_s: float | None = None,
    profile: Profile | None = None,
) -> Bank:
    """The bank a user means.

    Parameters
    ----------
    text
        ``paper`` (constant velocity, then the anchored Gaussian process), or sub-models in order, joined by
        ``+``: ``cv``, ``ca``, ``ctrv``, ``ctra``, ``imm``, ``gp-anchored``, ``gp-intercept``,
        ``gp-adaptive``, ``gp-linear``, ``gp(...)`` with a kernel's expression, ``gp(matern32*(linear+rbf))``
        (`modelcast.models.gp.kernels`), and what the profile in use holds: in the shipped one
        ``gp-trained``, ``gp-vehicle``, ``gp-derivative``, ``learned``, ``gp-regime-1`` to ``gp-regime-3``,
        ``shs`` and ``hdp-hmm``; and what other packages register (`modelcast.models.sub_models`), where the
        profile holds none of that name, with settings of their fields or without, as
        ``NAME:KEY=VALUE,KEY=VALUE``. ``regimes`` stands for the sub-models of all regimes, ``free`` for
        the best receiver of plain messages (`free_bank`).
    noise_floor_m
        Smallest position noise the Gaussian processes fitted by likelihood may assume [m]; where None, none
        to speak of for the paper's form and 1 mm for the others.
    window
        Samples they are fitted to.
    trusted_horizon_s
        Age beyond which sub-models are damped [s]; None for never. Constant velocity needs none, and the
        learned sub-model has its own.
    profile
        The profile in use; the one that ships with modelcast where None.

    Raises
    ------
    ConfigError
        Where a name is unknown or a value out of range.

    Examples
    --------
    >>> bank_from_text("gp-intercept+cv").name
    'gp-intercept+cv'
    >>> [member.name for member in bank_from_text("cv+gp(linear + rq)+gp(matern32)").members]
    ['cv', 'gp(linear+rq)', 'gp(matern32)']
    """
    profile = default_profile() if profile is None else profile
    try:
        names = [name for part in parts_of(text) for name in _members_of(part, profile)]
        members = tuple(_member(name, profile, noise_floor_m, window) for name in names)
        if trusted_horizon_s is not None:
            members = tuple(
                member if _needs_no_horizon(member) else Trusted(member, trusted_horizon_s)
                for member in members
            )
        return Bank(members, text if text in ("paper", REGIME_BANK, FREE) or ":" in text else "")
    except (ConfigError, ValueError) as error:
        raise ConfigError(f"--bank {text}: {error}") from error


def parts_of(text: str) -> list[str]:
    """Split the text of a bank at every ``+`` that is outside parentheses.

    Parameters
    ----------
    text
        Sub-models joined by ``+``.

    Examples
    --------
    >>> parts_of("cv+gp(linear+rbf)")
    ['cv', 'gp(linear+rbf)']
    """
    parts = [""]
    depth = 0
    for character in text:
        depth += (character == "(") - (character == ")")
        if character == "+" and depth <= 0:
            parts.append("")
        else:
            parts[-1] += character
    return [part.strip() for part in parts]


def _is_trained(name: str, profile: Profile) -> bool:
    """Whether a sub-model is the profile's: its name means nothing without one."""
    return name not in UNTRAINED and not name.startswith(EXPRESSION) and profile.sub_model(name) is not None


def _members_of(part: str, profile: Profile) -> tuple[str, ...]:
    """The names that one stands for."""
    if part == "paper":
        return tuple(member.name for member in PAPER_BANK.members)
    if part != REGIME_BANK:
        return (part,)
    if profile.regimes is None:
        raise ValueError("the profile in use has no regimes; train one that has ('modelcast train')")
    return tuple(member.name for member in profile.regimes.members)


def _needs_no_horizon(member: AbstractSubModel) -> bool:
    """Constant velocity, and a model that has a horizon of its own."""
    return isinstance(member, ConstantVelocity) or isfinite(member.trusted_horizon_s)


def _member(name: str, profile: Profile, noise_floor_m: float | None, window: int) -> AbstractSubModel:
    if name in KINEMATIC:
        return KINEMATIC[name]
    if name == "gp-linear":
        return linear_process(window)
    if name == "gp-anchored":
        floor_m = PAPER_NOISE_FLOOR_M if noise_floor_m is None else noise_floor_m
        return GaussianProcess(window, "anchored", noise_floor_m=floor_m)
    if name in ("gp-intercept", "gp-adaptive"):
        floor_m = INTERCEPT_NOISE_FLOOR_M if noise_floor_m is None else noise_floor_m
        noise = "estimated" if name == "gp-adaptive" else "floor"
        return GaussianProcess(window, "intercept", noise_floor_m=floor_m, noise=noise)
    if name.startswith(EXPRESSION):
        if not name.endswith(")"):
            raise ValueError(f"a ) is missing in '{name}'")
        return process_of(
            name.removeprefix(EXPRESSION)[:-1],
            window,
            noise_floor_m=noise_floor_m,
            closed_floor_m=PAPER_NOISE_FLOOR_M,
        )
    found = _free(profile) if name == FREE else profile.sub_model(name)
    if found is None and names_registered(name):
        found = model_of_word(name)
    if found is None:
        raise _unknown_member(name, profile)
    fitted = isinstance(found, GaussianProcess | KernelProcess | VehicleProcess)
    return replace(found, samples=window) if fitted else found


def _unknown_member(name: str, profile: Profile) -> ValueError:
    """What to raise for a name that is none of a sub-model."""
    if ":" in name:
        others = ", ".join(SUB_MODELS.foreign_names()) or "none"
        return ValueError(f"'{name}': settings are for sub-models of other packages, here {others}")
    *most, last = member_names(profile)
    known = f"there are {', '.join(most)} and {last}, and gp(...) of a kernel"
    meant = ": join several by +, as in cv+gp-intercept" if "," in name else near(name, (*most, last))
    return ValueError(f"no sub-model is named '{name}'{meant}; {known}")


def profile_number_of(bank: Bank) -> int:
    """Number by which messages name a bank: that of the shipped profile for its bank, else of the bank alone.

    Parameters
    ----------
    bank
        Any bank whose sub-models a profile can hold.
    """
    shipped = default_profile()
    return profile_number((shipped if bank == shipped.bank else Profile(bank)).named_bytes)

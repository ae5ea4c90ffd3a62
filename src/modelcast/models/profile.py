"""A profile: what all vehicles share about their sub-models, learned once and named in every message.

It holds the bank with everything learned, the policy's rules, the calibrations and a record of the training.
Its text is canonical JSON (sorted keys, no spaces, one final newline), and its name on the air is the SHA-256
of these bytes: who holds the same profile holds the same bytes. One profile ships with modelcast.
"""

import functools
import hashlib
import importlib.resources
import json
from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, field
from typing import Any, cast

from modelcast.models.bank import Bank
from modelcast.models.base import AbstractSubModel
from modelcast.models.calibration import Calibration
from modelcast.models.learned import Selector
from modelcast.models.plain import from_plain, to_plain
from modelcast.models.regimes import Regimes

__all__ = ["PROFILE_SCHEMA", "Profile", "default_profile", "profile_from_text"]

PROFILE_SCHEMA = 1
"""Version of the layout; it rises when a key changes its meaning or goes away.

The key ``regimes`` was added without a new number: a profile that has none does not write it, so that older
files keep their bytes and with them their identity.
"""

_KEYS = (
    "schema",
    "label",
    "members",
    "shelf",
    "start",
    "identify",
    "selector",
    "costs",
    "calibrations",
    "record",
)


@dataclass(frozen=True, eq=False)
class Profile:
    """A bank with everything learned, and how it is used.

    Parameters
    ----------
    bank
        The sub-models, in order.
    shelf
        Other sub-models that were trained, to make other banks of.
    regimes
        Driving regimes with a sub-model each; None where there are none.
    start, identify
        The policy's rules, as in `modelcast.policy.error_driven.ErrorDriven`.
    selector
        What the start rule ``predicted`` asks; None where there is none.
    costs
        What the rule ``cheapest`` weighs, as `modelcast.policy.costs.CostTable.as_plain` has it; empty where
        there is nothing.
    calibrations
        Calibration of each sub-model's covariance, by name; some or none.
    record
        How it was trained: trips, seeds, settings, figures. Plain values.

    Raises
    ------
    ValueError
        Where a calibration is of no sub-model of the bank, or two trained sub-models share a name.

    Examples
    --------
    >>> from modelcast.models.constant_velocity import ConstantVelocity
    >>> profile = Profile(Bank((ConstantVelocity(),), "example"))
    >>> profile_from_text(profile.text) == profile
    True
    >>> len(profile.identity)
    64
    """

    bank: Bank
    _: KW_ONLY
    shelf: tuple[AbstractSubModel, ...] = ()
    regimes: Regimes | None = None
    start: str = "order"
    identify: str = "never"
    selector: Selector | None = None
    costs: Mapping[str, Any] = field(default_factory=dict[str, Any])
    calibrations: Mapping[str, Calibration] = field(default_factory=dict[str, Calibration])
    record: Mapping[str, Any] = field(default_factory=dict[str, Any])

    def __post_init__(self) -> None:
        names = {member.name for member in self.bank.members}
        foreign = sorted(set(self.calibrations) - names)
        if foreign:
            raise ValueError(f"calibrations of no sub-model of the bank: {', '.join(foreign)}")
        every = [member.name for member in self.sub_models]
        twice = sorted({name for name in every if every.count(name) > 1})
        if twice:
            raise ValueError(f"sub-models of a profile must have distinct names, twice: {', '.join(twice)}")

    @property
    def sub_models(self) -> tuple[AbstractSubModel, ...]:
        """All that it holds: the bank's, the shelf's and the regimes'."""
        regimes = () if self.regimes is None else self.regimes.members
        return (*self.bank.members, *self.shelf, *(one for one in regimes if one not in self.bank.members))

    def sub_model(self, name: str) -> AbstractSubModel | None:
        """The trained sub-model of that name, or None.

        Parameters
        ----------
        name
            As in banks.
        """
        found = [member for member in self.sub_models if member.name == name]
        return found[0] if found else None

    @functools.cached_property
    def text(self) -> str:
        """Canonical JSON."""
        document: dict[str, Any] = {
            "schema": PROFILE_SCHEMA,
            "label": self.bank.label,
            "members": to_plain(self.bank.members),
            "shelf": to_plain(self.shelf),
            "start": self.start,
            "identify": self.identify,
            "selector": to_plain(self.selector),
            "costs": self.costs,
            "calibrations": {name: one.as_plain() for name, one in self.calibrations.items()},
            "record": self.record,
        }
        if self.regimes is not None:
            document["regimes"] = to_plain(self.regimes)
        return json.dumps(document, sort_keys=True, separators=(",", ":"), allow_nan=False) + "\n"

    def __eq__(self, other: object) -> bool:
        return self.text == other.text if isinstance(other, Profile) else NotImplemented

    def __hash__(self) -> int:
        return hash(self.text)

    @functools.cached_property
    def identity(self) -> str:
        """SHA-256 of the text's bytes, in hexadecimal digits."""
        return hashlib.sha256(self.text.encode("utf-8")).hexdigest()


def profile_from_text(text: str) -> Profile:
    """The profile that a text describes.

    Parameters
    ----------
    text
        As `Profile.text`.

    Raises
    ------
    ValueError
        Where it is no profile, is of another schema, or what it holds is refused.
    """
    try:
        document: Any = json.loads(text)
    except ValueError as error:
        raise ValueError(f"no JSON: {error}") from error
    if not isinstance(document, dict) or "schema" not in document:
        raise ValueError("no profile: it has no 'schema'")
    plain = cast("dict[str, Any]", document)
    if plain["schema"] != PROFILE_SCHEMA:
        raise ValueError(f"schema {plain['schema']!r}; this version reads schema {PROFILE_SCHEMA}")
    missing = [key for key in _KEYS if key not in plain]
    if missing:
        raise ValueError(f"{', '.join(missing)} missing")
    calibrations, record, costs = plain["calibrations"], plain["record"], plain["costs"]
    if not all(isinstance(item, dict) for item in (calibrations, record, costs)):
        raise ValueError("calibrations, record and costs must be mappings")
    selector: Any = from_plain(plain["selector"])
    if selector is not None and not isinstance(selector, Selector):
        raise ValueError("selector must be one, or null")
    regimes: Any = from_plain(plain.get("regimes"))
    if regimes is not None and not isinstance(regimes, Regimes):
        raise ValueError("regimes must be such, or left out")
    return Profile(
        Bank(_sub_models(plain, "members"), str(plain["label"])),
        shelf=_sub_models(plain, "shelf"),
        regimes=regimes,
        start=str(plain["start"]),
        identify=str(plain["identify"]),
        selector=selector,
        costs=cast("dict[str, Any]", costs),
        calibrations=_calibrations(cast("dict[str, Any]", calibrations)),
        record=cast("dict[str, Any]", record),
    )


def _sub_models(plain: Mapping[str, Any], key: str) -> tuple[AbstractSubModel, ...]:
    found: Any = from_plain(plain[key])
    if not isinstance(found, tuple) or not all(
        isinstance(member, AbstractSubModel) for member in cast("tuple[Any, ...]", found)
    ):
        raise ValueError(f"{key} must be a list of sub-models")
    return cast("tuple[AbstractSubModel, ...]", found)


def _calibrations(plain: Mapping[str, Any]) -> dict[str, Calibration]:
    try:
        return {name: Calibration.from_plain(one) for name, one in plain.items()}
    except (KeyError, TypeError) as error:
        raise ValueError(f"damaged calibration: {error!r}") from error


@functools.cache
def default_profile() -> Profile:
    """The profile that ships with modelcast: the best bank measured so far."""
    place = importlib.resources.files("modelcast") / "profiles" / "default.json"
    return profile_from_text(place.read_text(encoding="utf-8"))

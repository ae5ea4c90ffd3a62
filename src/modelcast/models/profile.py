"""A profile: what all vehicles share about their sub-models, learned once and named in every message.

It holds the bank with everything learned, the policy's rules, the calibrations and a record of the training.
Its text is canonical JSON (sorted keys, no spaces, one final newline). Its name on the air is the SHA-256 of
these bytes without the key ``training_trips``, which no vehicle needs: who holds the same profile holds the
same numbers, whether or not it says which trips they are from. Two profiles ship with modelcast, of vehicles
and of people.

A profile from a file is hostile until it is checked. `profile_from_text` refuses whatever is not a value that
a compiled loop may read, and names its path.
"""

import functools
import hashlib
import json
from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, field
from typing import Any, cast

from modelcast.core.json_text import parse_json, schema_of
from modelcast.core.rules import Anything, Each, FieldError, Keys, Maybe, Table, Text, check
from modelcast.models.bank import Bank
from modelcast.models.base import AbstractSubModel
from modelcast.models.calibration import Calibration
from modelcast.models.learned import Selector
from modelcast.models.plain import from_plain, to_plain
from modelcast.models.plain_meaning import is_free
from modelcast.models.regimes import Regimes
from modelcast.models.reserved import check_name
from modelcast.models.shipped import DEFAULT, PEOPLE, SHIPPED, profile_path
from modelcast.trips.fingerprint import FINGERPRINT

__all__ = [
    "MOST_MEMBERS",
    "PROFILE_SCHEMA",
    "Profile",
    "default_profile",
    "people_plain_bank",
    "people_profile",
    "profile_from_text",
    "shipped_profile",
]

PROFILE_SCHEMA = 1
"""Version of the layout; it rises when a key changes its meaning or goes away.

The keys ``plain``, ``regimes`` and ``training_trips`` were added without a new number: a profile that has
none does not write them, so that older files keep their bytes and with them their identity.
"""

MOST_MEMBERS = 8
"""Sub-models that a profile's bank may have."""

_MOST_SHELF, _MOST_TRIPS = 64, 100_000
_MAPPING = Table(Anything(), 1000)
_TEXT = Keys(
    {
        "schema": Anything(),
        "label": Text(64, empty=True),
        "members": Each(_MAPPING, 1, MOST_MEMBERS),
        "shelf": Each(_MAPPING, 0, _MOST_SHELF),
        "start": Text(64),
        "identify": Text(64),
        "selector": Maybe(_MAPPING),
        "costs": _MAPPING,
        "calibrations": Table(_MAPPING, MOST_MEMBERS),
        "record": _MAPPING,
    },
    {
        "plain": Text(64),
        "regimes": Maybe(_MAPPING),
        "training_trips": Each(Text(64, pattern=FINGERPRINT), 0, _MOST_TRIPS),
        "added": Keys({"members": Each(_MAPPING, 1, _MOST_SHELF), "record": _MAPPING}),
    },
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
        The policy's rules, as in `modelcast.station.policy.error_driven.ErrorDriven`.
    selector
        What the start rule ``predicted`` asks; None where there is none.
    costs
        What the rule ``cheapest`` weighs, as `modelcast.station.policy.costs.CostTable.as_plain` has it;
        empty where there is nothing.
    calibrations
        Calibration of each sub-model's covariance, by name; some or none.
    record
        How it was trained: trips, seeds, settings, figures. Plain values.
    training_trips
        `modelcast.trips.fingerprint.fingerprint` of every trip it was trained on; empty where that is not
        known. Not part of the identity.
    added
        Sub-models trained later, to make other banks of; not part of the identity, since the bank that
        messages name stays what it was.
    added_record
        How those were trained. Plain values.

    Raises
    ------
    ValueError
        Where a calibration is of no sub-model of the bank or another's, a selector is for another bank, or
        two trained sub-models share a name, or one has a name that means something else in a bank's text.

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
    training_trips: tuple[str, ...] = ()
    added: tuple[AbstractSubModel, ...] = ()
    added_record: Mapping[str, Any] = field(default_factory=dict[str, Any])

    def __post_init__(self) -> None:
        names = {member.name for member in self.bank.members}
        foreign = sorted(set(self.calibrations) - names)
        if foreign:
            raise ValueError(f"calibrations of no sub-model of the bank: {', '.join(foreign)}")
        for name, one in self.calibrations.items():
            if one.sub_model != name:
                raise FieldError(f"calibrations.{name}.sub_model", one.sub_model, repr(name))
        if self.selector is not None:
            try:
                self.selector.check_members(tuple(member.name for member in self.bank.complete().members))
            except ValueError as error:
                raise FieldError("selector.members", self.selector.members, "those of the bank") from error
        every = [member.name for member in self.sub_models]
        twice = sorted({name for name in every if every.count(name) > 1})
        if twice:
            raise ValueError(f"sub-models of a profile must have distinct names, twice: {', '.join(twice)}")
        for member in self.sub_models:
            check_name(member)

    @property
    def sub_models(self) -> tuple[AbstractSubModel, ...]:
        """All that it holds: the bank's, the shelf's, the regimes', and what was added."""
        regimes = () if self.regimes is None else self.regimes.members
        others = (one for one in regimes if one not in self.bank.members)
        return (*self.bank.members, *self.shelf, *others, *self.added)

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
        """Canonical JSON, all of it: what a file holds."""
        document = self._document
        if self.training_trips:
            document["training_trips"] = list(self.training_trips)
        if self.added:
            document["added"] = {"members": to_plain(self.added), "record": self.added_record}
        return _canonical(document)

    @property
    def _document(self) -> dict[str, Any]:
        """What is part of the identity, in terms of JSON."""
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
        if self.bank.plain:
            document["plain"] = self.bank.plain
        if self.regimes is not None:
            document["regimes"] = to_plain(self.regimes)
        return document

    def __eq__(self, other: object) -> bool:
        return self.text == other.text if isinstance(other, Profile) else NotImplemented

    def __hash__(self) -> int:
        return hash(self.text)

    @functools.cached_property
    def identity(self) -> str:
        """SHA-256 of `named_bytes`, in hexadecimal digits."""
        return hashlib.sha256(self.named_bytes).hexdigest()

    @functools.cached_property
    def named_bytes(self) -> bytes:
        """What messages name: the text's bytes without the training trips and what was added."""
        return _canonical(self._document).encode("utf-8")


def _canonical(document: Mapping[str, Any]) -> str:
    return json.dumps(document, sort_keys=True, separators=(",", ":"), allow_nan=False) + "\n"


def profile_from_text(text: str) -> Profile:
    """The profile that a text describes.

    Parameters
    ----------
    text
        As `Profile.text`.

    Raises
    ------
    ValueError
        Where it is no profile, is of another schema, or what it holds is refused; the text begins with the
        path of what is wrong, as ``$.members[0].lags``.
    """
    document: Any = parse_json(text)
    schema_of(document, PROFILE_SCHEMA)  # there was never another
    check(document, _TEXT)
    plain = cast("dict[str, Any]", document)
    selector: Any = from_plain(plain["selector"], "$.selector")
    if selector is not None and not isinstance(selector, Selector):
        raise FieldError("$.selector", selector, "a selector, or null")
    regimes: Any = from_plain(plain.get("regimes"), "$.regimes")
    if regimes is not None and not isinstance(regimes, Regimes):
        raise FieldError("$.regimes", regimes, "regimes, or left out")
    members, shelf = _sub_models(plain, "members", "$"), _sub_models(plain, "shelf", "$")
    meaning = plain.get("plain", "")
    if meaning not in ("", *(member.name for member in members if is_free(member))):
        raise FieldError("$.plain", meaning, "the name of a sub-model of the bank that Part I is enough for")
    added: dict[str, Any] = plain.get("added", {"members": [], "record": {}})
    try:
        return Profile(
            Bank(members, plain["label"], meaning),
            shelf=shelf,
            regimes=regimes,
            start=plain["start"],
            identify=plain["identify"],
            selector=selector,
            costs=plain["costs"],
            calibrations=_calibrations(plain["calibrations"]),
            record=plain["record"],
            training_trips=tuple(plain.get("training_trips", ())),
            added=_sub_models(added, "members", "$.added"),
            added_record=added["record"],
        )
    except FieldError as error:
        raise error if error.place.startswith("$") else error.below("$") from None


def _sub_models(plain: Mapping[str, Any], key: str, path: str) -> tuple[AbstractSubModel, ...]:
    found: tuple[Any, ...] = from_plain(plain[key], f"{path}.{key}")
    for at, member in enumerate(found):
        if not isinstance(member, AbstractSubModel):
            raise FieldError(f"{path}.{key}[{at}]", member, "a sub-model")
    return found


def _calibrations(plain: Mapping[str, Any]) -> dict[str, Calibration]:
    found: dict[str, Calibration] = {}
    for name, one in plain.items():
        try:
            found[name] = Calibration.from_plain(one)
        except FieldError as error:
            raise FieldError(
                f"$.calibrations.{name}.{error.place.removeprefix('$').removeprefix('.')}",
                error.value,
                error.expected,
            ) from error
    return found


@functools.cache
def shipped_profile(name: str) -> Profile:
    """A profile that ships with modelcast.

    Parameters
    ----------
    name
        One of `modelcast.models.shipped.SHIPPED`.

    Raises
    ------
    ValueError
        Where none has that name.

    Examples
    --------
    >>> shipped_profile("people").bank.name
    'people'
    """
    if name not in SHIPPED:
        raise ValueError(f"shipped profiles are {', '.join(SHIPPED)}, got {name!r}")
    return profile_from_text(profile_path(name).read_text(encoding="utf-8"))


def default_profile() -> Profile:
    """The profile of vehicles that ships with modelcast: the best bank measured so far."""
    return shipped_profile(DEFAULT)


def people_profile() -> Profile:
    """The profile of people that ships with modelcast: it has no trained weights (``docs/people.md``)."""
    return shipped_profile(PEOPLE)


@functools.cache
def people_plain_bank() -> Bank:
    """What everybody coasts a person's message without a model by: the shipped profile's free sub-model.

    Where the message states no acceleration that is constant velocity.

    Examples
    --------
    >>> [member.name for member in people_plain_bank().members]
    ['stop-and-go']
    """
    bank = people_profile().bank
    return Bank((bank.members[bank.plain_place],), "people's plain messages")

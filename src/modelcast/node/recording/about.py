"""All that a recorded node is made again from, as plain values of JSON and back."""

from dataclasses import dataclass
from typing import Any, cast

from modelcast.core.geodesy import Origin
from modelcast.core.json_text import schema_of
from modelcast.core.rules import Each, FieldError, Keys, Maybe, Number, Text, Whole, check

__all__ = ["MOST_CERTIFICATES", "SCHEMA", "About", "about_words", "read_about"]

MOST_CERTIFICATES = 1000
"""Of a node, and of authorities that it trusts."""

SCHEMA = 1
"""Of a recording; one of a newer modelcast is refused."""

_ABOUT = Keys(
    {
        "schema": Whole(1, SCHEMA),
        "version": Text(60),
        "policy": Text(60),
        "profile": Maybe(Whole(-1, 2**48)),
        "utc_at_zero_s": Number(0.0, 1e11),
        "origin": Each(Number(-1e5, 1e5), 3, 3),
        "names_seed": Text(40),
        "station_seed": Text(40),
        "config": Each(Text(2000, empty=True), 0, 500),
        "trusted": Each(Text(1000), 0, MOST_CERTIFICATES),
        "own": Each(Text(1000), 0, MOST_CERTIFICATES),
    }
)


@dataclass(frozen=True, slots=True, kw_only=True)
class About:
    """All that a node is made again from.

    Parameters
    ----------
    version
        Of the modelcast that recorded.
    policy
        What it sent by.
    profile
        Number of the bank as messages name it; None where it sends no sub-models.
    utc_at_zero_s
        UTC at the clock's 0, since 1970 [s].
    origin
        Of its plane.
    names_seed, station_seed
        Of temporary ids and of the station.
    config
        Its configuration, lines of TOML; the page's token is left out.
    trusted, own
        Certificates of the authorities that it trusts, and its own, as octets; keys are left out.
    """

    version: str
    policy: str
    profile: int | None
    utc_at_zero_s: float
    origin: Origin
    names_seed: int
    station_seed: int
    config: tuple[str, ...]
    trusted: tuple[bytes, ...] = ()
    own: tuple[bytes, ...] = ()


def about_words(about: About) -> dict[str, Any]:
    """What a node is made again from."""
    place = about.origin
    return {
        "schema": SCHEMA,
        "version": about.version,
        "policy": about.policy,
        "profile": about.profile,
        "utc_at_zero_s": about.utc_at_zero_s,
        "origin": [place.latitude_deg, place.longitude_deg, place.altitude_m],
        "names_seed": f"{about.names_seed:x}",
        "station_seed": f"{about.station_seed:x}",
        "config": list(about.config),
        "trusted": [one.hex() for one in about.trusted],
        "own": [one.hex() for one in about.own],
    }


def read_about(words: object) -> About:
    """The same back.

    Raises
    ------
    ValueError
        Where it is none, or of a newer modelcast.
    """
    schema_of(words, SCHEMA)
    check(words, _ABOUT)
    own = cast("dict[str, Any]", words)
    try:
        seeds = int(own["names_seed"], 16), int(own["station_seed"], 16)
    except ValueError as error:
        raise FieldError("$.names_seed", own["names_seed"], "a whole number in hexadecimal") from error
    if min(seeds) < 0:
        raise FieldError("$.names_seed", min(seeds), "not negative")
    return About(
        version=own["version"],
        policy=own["policy"],
        profile=own["profile"],
        utc_at_zero_s=float(own["utc_at_zero_s"]),
        origin=Origin(*(float(value) for value in own["origin"])),
        names_seed=seeds[0],
        station_seed=seeds[1],
        config=tuple(own["config"]),
        trusted=_octets(own, "trusted"),
        own=_octets(own, "own"),
    )


def _octets(words: dict[str, Any], name: str) -> tuple[bytes, ...]:
    try:
        return tuple(bytes.fromhex(one) for one in words[name])
    except ValueError as error:
        raise FieldError(f"$.{name}", words[name], "octets in hexadecimal") from error

"""The keys and certificates of a node, as files in a folder.

======================  ==================================================================================
file                    octets
======================  ==================================================================================
``trusted/*.cert``      certificates of authorities whose issue is trusted, in canonical OER
``own/*.cert``          the node's pseudonym certificates, taken one after the other by their names
``own/*.key``           the secret number of each, 32 octets, for its user's eyes alone
``authority/``          ``authority.cert`` and ``authority.key`` of who issues here; only where it was made
======================  ==================================================================================

This is enough to try signatures among machines of one's own. It is no public key infrastructure: nobody is
enrolled, nothing is revoked, and whoever has the authority's key can issue.
"""

import os
import stat
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from modelcast.core.exceptions import CodecError, ConfigError
from modelcast.core.refusals import refusal
from modelcast.io.output import written_into
from modelcast.messages.psids import SAFETY_PSID
from modelcast.messages.security.authority import Authority
from modelcast.messages.security.certificate import Certificate
from modelcast.messages.security.p256 import SECRET_OCTETS, SEED_OCTETS, PrivateKey
from modelcast.messages.security.signer import Signer
from modelcast.node.recording.about import MOST_CERTIFICATES

__all__ = ["Credentials", "make_credentials", "read_authority", "read_credentials"]

_LARGEST_OCTETS = 1024


@dataclass(frozen=True, slots=True)
class Credentials:
    """What a node signs with, and whom it trusts.

    Parameters
    ----------
    trusted
        Certificates of authorities.
    own
        A signer a pseudonym.
    """

    trusted: tuple[Certificate, ...]
    own: tuple[Signer, ...]

    def good_until_s(self, t_s: float, psid: int | None = None) -> float:
        """When the last certificate ends of those that are good at a time; the time where none is [s].

        Parameters
        ----------
        t_s
            Since 2004-01-01 00:00 UTC, leap seconds counted [s].
        psid
            The application that they must be good for; None for any.
        """
        own = [one.certificate for one in self.own if psid is None or psid in one.certificate.psids]
        good = [one for one in own if one.is_good_at(t_s)]
        return max((float(one.start_s + one.duration_s) for one in good), default=t_s)


def make_credentials(
    folder: Path,
    *,
    count: int,
    start_s: int,
    duration_s: int,
    random: Callable[[int], bytes],
    authority: Path | None = None,
    psids: tuple[int, ...] = (SAFETY_PSID,),
) -> Credentials:
    """Make a folder of credentials.

    Parameters
    ----------
    folder
        A new folder, or an empty one.
    count
        Pseudonym certificates, 1 to `MOST_CERTIFICATES`.
    start_s, duration_s
        What all of them are good for, whole seconds since 2004-01-01 00:00 UTC, leap seconds counted.
    random
        Gives so many octets that nobody can guess.
    authority
        Folder ``authority`` of another node, whose authority issues these; None for one of this folder's own.
    psids
        Applications that the certificates are good for (`modelcast.messages.psids`).

    Raises
    ------
    ConfigError
        Where a number is out of range, the folder is not empty, the authority cannot be read or is not good
        for that time, or a file cannot be written.
    """
    if not 1 <= count <= MOST_CERTIFICATES:
        raise ConfigError(f"count must be from 1 to {MOST_CERTIFICATES}, got {count}")
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise ConfigError(f"{folder} is there and not an empty folder: name another")
    issuer = None if authority is None else read_authority(authority)

    def write(place: Path) -> list[Path]:
        by = issuer
        (place / "trusted").mkdir(mode=0o700)
        if by is None:
            by = Authority.create(_drawn(random), start_s=start_s, duration_s=duration_s)
            _write_pair(place / "authority", "authority", by.key, by.certificate)
        (place / "trusted" / "authority.cert").write_bytes(by.certificate.octets)
        for number in range(1, count + 1):
            key = _drawn(random)
            certificate = by.issue(key.public_octets, start_s=start_s, duration_s=duration_s, psids=psids)
            _write_pair(place / "own", f"{number:04d}", key, certificate)
        return []

    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        written_into(folder, write)
    except ValueError as error:
        raise ConfigError(str(error)) from error
    except OSError as error:
        raise ConfigError(f"{folder} cannot be written into: {refusal(error)}") from error
    return read_credentials(folder)


def read_credentials(folder: str | Path) -> Credentials:
    """Read a folder of credentials.

    Parameters
    ----------
    folder
        The folder.

    Raises
    ------
    ConfigError
        Where a file is missing, is not what it should be, or others than its user may read a key; it names
        the file and the remedy.
    """
    place = Path(folder)
    if not place.is_dir():
        raise ConfigError(f"{place} is no folder: make one with modelcast credentials new {place}")
    trusted = tuple(_certificate(one) for one in _files(place / "trusted", "cert"))
    own: list[Signer] = []
    for one in _files(place / "own", "cert"):
        certificate, secret = _certificate(one), one.with_suffix(".key")
        if not certificate.psids:
            raise ConfigError(f"{one} is an authority's certificate: it belongs into {place / 'trusted'}")
        try:
            own.append(Signer(_key(secret), certificate))
        except ValueError as error:
            raise ConfigError(f"{secret} is not the key of {one.name}: {error}") from error
    return Credentials(trusted, tuple(own))


def read_authority(folder: str | Path) -> Authority:
    """Read an authority that issues.

    Parameters
    ----------
    folder
        With ``authority.cert`` and ``authority.key``.

    Raises
    ------
    ConfigError
        As for `read_credentials`.
    """
    place = Path(folder)
    certificate, secret = _certificate(place / "authority.cert"), place / "authority.key"
    try:
        return Authority(_key(secret), certificate)
    except ValueError as error:
        raise ConfigError(f"{secret} is not the key of authority.cert: {error}") from error


def _files(folder: Path, ending: str) -> Sequence[Path]:
    found = sorted(folder.glob(f"*.{ending}")) if folder.is_dir() else []
    if not found:
        raise ConfigError(f"{folder} holds no *.{ending}: make credentials with modelcast credentials new")
    if len(found) > MOST_CERTIFICATES:
        raise ConfigError(f"{folder} holds {len(found)} certificates, at most {MOST_CERTIFICATES} are read")
    return found


def _octets(path: Path) -> bytes:
    try:
        with path.open("rb") as file:
            found = file.read(_LARGEST_OCTETS + 1)
    except OSError as error:
        raise ConfigError(f"{path}: {error.strerror or error}") from error
    if len(found) > _LARGEST_OCTETS:
        raise ConfigError(f"{path} has more than {_LARGEST_OCTETS} octets: it is not what its name says")
    return found


def _certificate(path: Path) -> Certificate:
    try:
        return Certificate.from_octets(_octets(path))
    except (CodecError, ValueError) as error:
        raise ConfigError(f"{path} is no certificate that is read here: {error}") from error


def _key(path: Path) -> PrivateKey:
    octets = _octets(path)
    if stat.S_IMODE(path.stat().st_mode) & 0o077:
        raise ConfigError(f"others than its user may read {path}: chmod 600 {path}")
    if len(octets) != SECRET_OCTETS:
        raise ConfigError(f"{path} must have {SECRET_OCTETS} octets, it has {len(octets)}")
    try:
        return PrivateKey(int.from_bytes(octets, "big"))
    except ValueError as error:
        raise ConfigError(f"{path} holds no key of P-256: {error}") from error


def _drawn(random: Callable[[int], bytes]) -> PrivateKey:
    return PrivateKey.from_random(random(SEED_OCTETS))


def _write_pair(folder: Path, name: str, key: PrivateKey, certificate: Certificate) -> None:
    folder.mkdir(mode=0o700, exist_ok=True)
    (folder / f"{name}.cert").write_bytes(certificate.octets)
    opened = os.open(folder / f"{name}.key", os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    with os.fdopen(opened, "wb") as file:
        file.write(key.secret.to_bytes(SECRET_OCTETS, "big"))

"""Claims about a folder of credentials: what is made is read, and what is wrong is told with its remedy."""

import os
from collections.abc import Callable
from pathlib import Path

import pytest

from modelcast.core.exceptions import ConfigError
from modelcast.node.credentials import Credentials, make_credentials, read_authority, read_credentials

START_S = 700_000_000


def made(folder: Path, *, authority: Path | None = None, count: int = 3) -> Credentials:
    return make_credentials(
        folder, count=count, start_s=START_S, duration_s=7 * 86_400, random=os.urandom, authority=authority
    )


def test_what_is_made_is_read_and_for_the_eyes_of_its_user_alone(tmp_path: Path) -> None:
    found = made(tmp_path / "a")
    assert read_credentials(tmp_path / "a") == found
    assert len({one.certificate.digest for one in found.own}) == 3
    keys = list((tmp_path / "a").rglob("*.key"))
    assert len(keys) == 4
    assert {one.stat().st_mode & 0o777 for one in keys} == {0o600}
    assert (tmp_path / "a" / "own").stat().st_mode & 0o777 == 0o700
    assert found.good_until_s(START_S + 1.0) == START_S + 7 * 86_400
    assert found.good_until_s(START_S - 1.0) == START_S - 1.0


def test_another_node_may_have_the_same_authority(tmp_path: Path) -> None:
    first = made(tmp_path / "a")
    second = made(tmp_path / "b", authority=tmp_path / "a" / "authority")
    assert second.trusted == first.trusted
    assert not (tmp_path / "b" / "authority").exists()
    assert read_authority(tmp_path / "a" / "authority").certificate == first.trusted[0]


def _shared(folder: Path) -> None:
    (folder / "own" / "0001.key").chmod(0o640)


def _swapped(folder: Path) -> None:
    (folder / "own" / "0001.key").write_bytes((folder / "own" / "0002.key").read_bytes())


def _short(folder: Path) -> None:
    (folder / "own" / "0001.key").write_bytes(b"few")


def _zero(folder: Path) -> None:
    (folder / "own" / "0001.key").write_bytes(bytes(32))


def _missing(folder: Path) -> None:
    (folder / "own" / "0001.key").unlink()


def _garbled(folder: Path) -> None:
    (folder / "own" / "0001.cert").write_bytes(b"\x80\x03\x00garbled")


def _long(folder: Path) -> None:
    (folder / "own" / "0001.cert").write_bytes(bytes(5000))


def _misplaced(folder: Path) -> None:
    (folder / "own" / "0000.cert").write_bytes((folder / "trusted" / "authority.cert").read_bytes())


def _nobody(folder: Path) -> None:
    (folder / "trusted" / "authority.cert").unlink()


@pytest.mark.parametrize(
    ("spoil", "told"),
    [
        (_shared, "chmod 600 .*0001.key"),
        (_swapped, "0001.key is not the key of 0001.cert"),
        (_short, "0001.key must have 32 octets, it has 3"),
        (_zero, "0001.key holds no key"),
        (_missing, "0001.key: No such file"),
        (_garbled, "0001.cert is no certificate that is read here"),
        (_long, "0001.cert has more than 1024 octets"),
        (_misplaced, "authority's certificate: it belongs into .*trusted"),
        (_nobody, r"trusted holds no \*.cert: make credentials"),
    ],
)
def test_what_is_wrong_is_told_with_file_and_remedy(
    tmp_path: Path, spoil: Callable[[Path], None], told: str
) -> None:
    made(tmp_path / "a")
    spoil(tmp_path / "a")
    with pytest.raises(ConfigError, match=told):
        read_credentials(tmp_path / "a")


def test_nothing_is_written_over_and_numbers_are_checked(tmp_path: Path) -> None:
    made(tmp_path / "a")
    with pytest.raises(ConfigError, match="not an empty folder"):
        made(tmp_path / "a")
    with pytest.raises(ConfigError, match="count must be from 1 to 1000"):
        made(tmp_path / "b", count=0)
    with pytest.raises(ConfigError, match="modelcast credentials new"):
        read_credentials(tmp_path / "c")
    with pytest.raises(ConfigError, match=r"authority.cert"):
        made(tmp_path / "d", authority=tmp_path / "c")

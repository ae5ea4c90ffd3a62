"""Claims: who may look, and what every answer says, whoever asks."""

import hmac

import pytest

from modelcast.dashboard.gate import COOKIE, Gate, is_loopback
from modelcast.dashboard.server import listen

TOKEN = "a-token-of-some-length"  # noqa: S105 - of this test


@pytest.mark.parametrize(
    ("host", "good"),
    [
        ("127.0.0.1", True),
        ("127.0.0.1:8700", True),
        ("192.168.1.7:80", True),
        ("[::1]:8700", True),
        ("localhost:1", True),
        ("LOCALHOST", True),
        ("car.example", True),
        ("Car.Example:8700", True),
        ("evil.example", False),
        ("127.0.0.1.evil.example", False),
        ("localhost.evil.example", False),
        ("evil.example@127.0.0.1", False),
        ("127.0.0.1/evil.example", False),
        ("127.0.0.1:many", False),
        ("[::1", False),
        ("", False),
    ],
)
def test_a_host_head_names_an_address_or_a_name_that_was_given(host: str, *, good: bool) -> None:
    assert Gate(names=("car.example",)).names_here(host) is good


@pytest.mark.parametrize(
    ("origin", "good"),
    [
        (None, True),
        ("http://127.0.0.1:8700", True),
        ("https://127.0.0.1:8700", True),
        ("http://127.0.0.1", False),
        ("http://evil.example", False),
        ("null", False),
    ],
)
def test_a_socket_is_opened_by_this_page_alone(origin: str | None, *, good: bool) -> None:
    assert Gate().same_page(origin, "127.0.0.1:8700") is good


def test_a_token_opens_and_nothing_near_it_does() -> None:
    gate = Gate(TOKEN)
    assert gate.admits(TOKEN)
    for shown in (None, "", TOKEN[:-1], TOKEN + "x", TOKEN.upper(), "é" * 20):
        assert not gate.admits(shown)


def test_a_cookie_opens_among_others() -> None:
    gate = Gate(TOKEN)
    assert gate.admits_cookies([f"a=b; {COOKIE}={TOKEN}"])
    assert gate.admits_cookies(["a=b", f"{COOKIE}={TOKEN}"])
    for heads in ([], [f"{COOKIE}=x"], [f"{COOKIE}"], ["\x00;=;"], [f"other={TOKEN}"]):
        assert not gate.admits_cookies(heads)


def test_a_gate_without_token_opens_to_all() -> None:
    assert Gate().admits(None)
    assert Gate().admits_cookies([])


def test_a_short_token_is_refused() -> None:
    with pytest.raises(ValueError, match="at least 16"):
        Gate("guess")


def test_a_server_that_others_reach_needs_a_token() -> None:
    with pytest.raises(ValueError, match="a token is needed"):
        listen("0.0.0.0", 0, Gate())  # noqa: S104 - the claim
    with listen("127.0.0.1", 0, Gate()) as place:
        assert is_loopback(place.getsockname()[0])


def test_a_token_is_asked_for_in_a_time_that_does_not_depend_on_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every comparison goes through the one that is made for it."""
    asked: list[tuple[bytes, bytes]] = []

    def compare(one: bytes, other: bytes) -> bool:
        asked.append((one, other))
        return False

    monkeypatch.setattr(hmac, "compare_digest", compare)
    assert not Gate(TOKEN).admits(TOKEN)
    assert asked == [(TOKEN.encode(), TOKEN.encode())]

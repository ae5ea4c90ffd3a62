"""Who may look: the address asked for, the page that asks, and a token. Pure functions of a request's heads.

A page of another site can make a browser ask this server, under a name of that site that points here (DNS
rebinding). So the name asked for must be an address or one that was given; and a page that opens a socket
must be this one.
"""

import hmac
import ipaddress
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from http.cookies import CookieError, SimpleCookie
from urllib.parse import urlsplit

__all__ = ["COOKIE", "HEADERS", "Gate", "is_loopback"]

COOKIE = "modelcast-token"

HEADERS: Mapping[str, str] = {
    "Content-Security-Policy": (
        "default-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'; object-src 'none'"
    ),
    "Cache-Control": "no-store",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}
"""Of every answer: nothing from elsewhere is loaded, nothing is kept, and the address is not passed on."""


@dataclass(frozen=True, slots=True)
class Gate:
    """The rules of one server.

    Parameters
    ----------
    token
        What a browser must show; empty for none, which is for a server that only this machine reaches.
    names
        Names by which it may be asked for, beside addresses and ``localhost``.

    Raises
    ------
    ValueError
        Where a token is given that can be guessed: shorter than 16 characters.
    """

    token: str = ""
    names: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if self.token and len(self.token) < 16:
            raise ValueError("token must have at least 16 characters")

    def names_here(self, host: str) -> bool:
        """Whether a ``Host`` head names this server: an address, ``localhost`` or a name given.

        Parameters
        ----------
        host
            The head, with or without a port.

        Examples
        --------
        >>> [Gate().names_here(host) for host in ("127.0.0.1:8700", "[::1]:80", "localhost", "evil.example")]
        [True, True, True, False]
        """
        try:
            parts = urlsplit(f"//{host}")
            name, _ = parts.hostname, parts.port
        except ValueError:
            return False
        if not name or parts.path or parts.query or parts.fragment or "@" in host:
            return False
        return name == "localhost" or _is_address(name) or name in {one.lower() for one in self.names}

    def same_page(self, origin: str | None, host: str) -> bool:
        """Whether a socket is opened by this page: its ``Origin`` names the ``Host``, or it is no browser.

        Parameters
        ----------
        origin, host
            The heads; None where there is no origin.
        """
        return origin is None or origin.lower() in {f"http://{host.lower()}", f"https://{host.lower()}"}

    def admits(self, shown: str | None) -> bool:
        """Whether a token opens; compared in constant time.

        Parameters
        ----------
        shown
            As it came, None for none.
        """
        return not self.token or (
            shown is not None and hmac.compare_digest(shown.encode(), self.token.encode())
        )

    def admits_cookies(self, cookies: Iterable[str]) -> bool:
        """Whether one of the ``Cookie`` heads carries a token that opens.

        Parameters
        ----------
        cookies
            The heads.
        """
        if not self.token:
            return True
        for head in cookies:
            try:
                found = SimpleCookie(head).get(COOKIE)
            except CookieError:
                continue
            if found is not None and self.admits(found.value):
                return True
        return False


def is_loopback(host: str) -> bool:
    """Whether only this machine reaches a server that listens there.

    Parameters
    ----------
    host
        Address or name.

    Examples
    --------
    >>> [is_loopback(host) for host in ("127.0.0.1", "::1", "localhost", "0.0.0.0", "car.example")]
    [True, True, True, False, False]
    """
    return host == "localhost" or (_is_address(host) and ipaddress.ip_address(host).is_loopback)


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True

"""Who may come in: by the name under which the server is asked for, by the page that asks, and by a token."""

import ipaddress
import secrets
import socket
from collections.abc import Mapping
from dataclasses import dataclass
from http.cookies import CookieError, SimpleCookie
from typing import Final
from urllib.parse import urlsplit

from protocols import InputError

SHORTEST_TOKEN: Final = 16
"""Characters that a token has at least."""


@dataclass(frozen=True)
class Refusal:
    """Why somebody does not come in."""

    status: int
    """HTTP status: 400, 401 or 403."""

    reason: str
    """A sentence."""


class Gate:
    """Decides from the heads of a request alone.

    * ``Host`` must be an address, or a name of this machine: a page whose name was made to point here (DNS rebinding)
      has another.
    * ``Origin``, which browsers send with every websocket and with whatever scripts of another page ask for, must be our own; and
      ``Sec-Fetch-Site`` must not say that another page asks for a part of ours.
    * Where there is a token, it must be known: from a cookie that the page got for it, or as ``Authorization: Bearer``.
    """

    def __init__(self, host: str, port: int, token: str | None = None) -> None:
        """Guard one server.

        Args:
            host: the address that it is bound to.
            port: the port that it is bound to.
            token: what a viewer must know; None asks for nothing, which is allowed on this machine's own address alone.

        Raises:
            InputError: another address without a token, or a token that is too short.
        """
        if token is None and not is_loopback(host):
            raise InputError(
                saw=f"--host {host} without a token: everybody who reaches this machine would see the bench",
                expected="a token for every address but 127.0.0.1",
                remedy="set KINOPIX_TOKEN to a secret of 16 characters or more, or leave --host out and use an SSH tunnel",
            )
        if token is not None and (len(token) < SHORTEST_TOKEN or not token.isascii() or not token.isprintable()):
            raise InputError(
                saw=f"a token of {len(token)} characters",
                expected=f"at least {SHORTEST_TOKEN} plain characters",
                remedy='make one: python -c "import secrets; print(secrets.token_urlsafe())"',
            )
        self.host, self.port, self.token = host, port, token
        self.cookie = f"kinopix-{port}"
        """Name of the cookie: two servers on one machine keep theirs apart."""
        self.ticket = secrets.token_urlsafe(32)
        """What the cookie holds: not the token, and worth nothing after the server has ended."""

    def refusal(self, headers: Mapping[str, str], *, websocket: bool = False) -> Refusal | None:
        """Tell why a request is refused; None for one that comes in.

        Args:
            headers: by their names in lower case.
            websocket: whether it asks for a websocket.
        """
        host = headers.get("host", "")
        if not self._is_ours(host):
            return Refusal(400, f"this server is not called {host!r}: ask for it by its address")
        origin = headers.get("origin")
        if origin is not None and (urlsplit(origin).scheme != "http" or urlsplit(origin).netloc != host):
            return Refusal(403, "a page from elsewhere may not ask for this")
        site, mode = headers.get("sec-fetch-site", "none"), headers.get("sec-fetch-mode", "navigate")
        if site not in {"same-origin", "none"} and (websocket or mode != "navigate"):
            return Refusal(403, "a page from elsewhere may not ask for this")
        if self.token is not None and not self._is_known(headers):
            return Refusal(401, "the token is missing or wrong")
        return None

    def opens(self, token: str) -> bool:
        """Tell whether this is the token."""
        return self.token is not None and secrets.compare_digest(token.encode(), self.token.encode())

    def _is_known(self, headers: Mapping[str, str]) -> bool:
        kind, _, shown = headers.get("authorization", "").partition(" ")
        if kind.lower() == "bearer" and self.opens(shown.strip()):
            return True
        try:
            cookie = SimpleCookie(headers.get("cookie", "")).get(self.cookie)
        except CookieError:
            return False
        return cookie is not None and secrets.compare_digest(cookie.value.encode(), self.ticket.encode())

    def _is_ours(self, host: str) -> bool:
        """Tell whether a ``Host`` names this server: by an address, or as this machine calls itself."""
        try:
            parts = urlsplit(f"//{host}")
            name, port = parts.hostname or "", parts.port or 80
        except ValueError:
            return False
        if port != self.port or parts.username is not None or parts.path:
            return False
        if is_loopback(self.host):
            return is_loopback(name)
        mine = socket.gethostname().lower()
        return is_loopback(name) or _address(name) is not None or name in {mine, f"{mine}.local"}


def is_loopback(host: str) -> bool:
    """Tell whether an address or a name is this machine's own, which no other machine reaches."""
    address = _address(host)
    return host == "localhost" if address is None else address.is_loopback


def _address(host: str) -> ipaddress.IPv4Address | ipaddress.IPv6Address | None:
    try:
        return ipaddress.ip_address(host.strip("[]"))
    except ValueError:
        return None

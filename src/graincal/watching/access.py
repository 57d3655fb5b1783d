"""Who may look at the page: whoever has the printed link, by a name of this machine."""

from __future__ import annotations

import hmac
import ipaddress
import re
import secrets
import socket
from http.cookies import CookieError, SimpleCookie

LOOPBACK = ("127.0.0.1", "localhost", "::1")
"""The names of this machine to itself; `ssh -L` leads to them too, from whatever port."""

_HOST = re.compile(r"(?:\[(?P<six>[0-9A-Fa-f:.]+)\]|(?P<name>[A-Za-z0-9._-]+))(?::[0-9]{1,5})?")


class Access:
    """The token of the printed link, and the cookie that it is turned into. host: the address that the server listens at."""

    def __init__(self, host: str) -> None:
        self.token, self._session = secrets.token_urlsafe(32), secrets.token_urlsafe(32)
        # Browsers keep cookies by host, whatever the port: the pages of two campaigns are not to take each other's.
        self._cookie = f"graincal-{secrets.token_hex(4)}"
        self._any_address = host in ("", "0.0.0.0", "::")
        own = {socket.gethostname().lower(), socket.getfqdn().lower()} if self._any_address else {host.lower()}
        self._hosts = {*LOOPBACK, *(own if host not in LOOPBACK else ())}

    @property
    def set_cookie(self) -> str:
        """The header that gives a browser the cookie. No script can read it, and no other site can have it sent."""
        return f"{self._cookie}={self._session}; Path=/; HttpOnly; SameSite=Strict"

    def knows_token(self, token: str) -> bool:
        """Whether this is the token."""
        return _same(token, self.token)

    def knows_cookie(self, header: str | None) -> bool:
        """Whether a request's Cookie header has the cookie."""
        try:
            cookie = SimpleCookie(header or "").get(self._cookie)
        except CookieError:
            return False
        return cookie is not None and _same(cookie.value, self._session)

    def knows_host(self, headers: list[str]) -> bool:
        """Whether a request names this machine in its only Host header: another site's name that leads here is refused, for its page would share the address with this one."""
        found = _HOST.fullmatch(headers[0]) if len(headers) == 1 else None
        if found is None:
            return False
        name = (found["six"] or found["name"]).lower()
        # A name may lead anywhere, an address only to itself.
        return name in self._hosts or (self._any_address and _is_address(name))


def _same(one: str, other: str) -> bool:
    """In a time that says nothing of where they differ."""
    return hmac.compare_digest(one.encode("utf-8", "replace"), other.encode())


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True

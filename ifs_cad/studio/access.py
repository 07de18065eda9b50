"""Who may talk to the studio: only pages that it served itself, to whoever has its key.

Terms
-----
host : what a browser believes to speak to. A page of another site whose name was made to lead to
    this machine (DNS rebinding) still names its own site here.
origin : the page that opens a connection. Browsers always send it with a websocket and no page
    can change it, but websockets are open to every origin unless the server looks.
key : a secret in the address that the command prints. The page gets it as a cookie, so that other
    users of this machine, who see the port too, cannot come in.
"""

from __future__ import annotations

import secrets
from collections.abc import Callable
from dataclasses import dataclass, field
from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qs, urlsplit

LOOPBACK = "127.0.0.1"
NAMES = (LOOPBACK, "localhost")
KEY = "key"

Headers = Callable[[str], list[str]]
"""Gives all values of a header, none when it is missing."""

__all__ = ["LOOPBACK", "Gate"]


@dataclass(frozen=True)
class Gate:
    """Decides on requests.

    Parameters
    ----------
    port : int
        Where the studio listens.
    key : str, optional
        A new one by default.
    """

    port: int
    key: str = field(default_factory=lambda: secrets.token_urlsafe(24), repr=False)

    @property
    def address(self) -> str:
        """What the user opens."""
        return f"http://{LOOPBACK}:{self.port}/?{KEY}={self.key}"

    @property
    def hosts(self) -> tuple[str, ...]:
        """The names under which pages are served."""
        return tuple(f"{name}:{self.port}" for name in NAMES)

    @property
    def origins(self) -> tuple[str, ...]:
        """The origins of our own pages."""
        return tuple(f"http://{host}" for host in self.hosts)

    def refusal(self, path: str, headers: Headers) -> str | None:
        """Return why a request is refused, None when it is not.

        Parameters
        ----------
        path : str
            With its query.
        headers : callable
        """
        host, origin = headers("Host"), headers("Origin")
        if len(host) != 1 or host[0].lower() not in self.hosts:
            return f"The studio is only served as {' or '.join(self.hosts)}."
        is_websocket = bool(headers("Upgrade"))
        if (origin or is_websocket) and (len(origin) != 1 or origin[0] not in self.origins):
            return "Another page may not speak to the studio."
        if not (self._has_cookie(headers) or (not is_websocket and self.has_key(path))):
            return "Open the address that ifs-cad studio printed; it ends with a key."
        return None

    def has_key(self, path: str) -> bool:
        """Tell whether the address of a page holds the key."""
        given = parse_qs(urlsplit(path).query).get(KEY, [])
        return len(given) == 1 and self._is_key(given[0])

    def page_headers(self, path: str) -> dict[str, str]:
        """Return what a page is sent with: the cookie, and that no other page may show it."""
        headers = {
            "Content-Security-Policy": "frame-ancestors 'none'",
            "Cross-Origin-Resource-Policy": "same-origin",
            "Referrer-Policy": "no-referrer",
            "X-Content-Type-Options": "nosniff",
            "X-Frame-Options": "DENY",
        }
        if self.has_key(path):
            value = f"{self._cookie}={self.key}; Path=/; HttpOnly; SameSite=Strict"
            headers["Set-Cookie"] = value
        return headers

    @property
    def _cookie(self) -> str:
        return f"ifs_cad_studio_{self.port}"  # browsers do not keep the cookies of ports apart

    def _has_cookie(self, headers: Headers) -> bool:
        for text in headers("Cookie"):
            try:
                found = SimpleCookie(text).get(self._cookie)
            except CookieError:
                continue
            if found is not None and self._is_key(found.value):
                return True
        return False

    def _is_key(self, given: str) -> bool:
        return secrets.compare_digest(given.encode(), self.key.encode())

"""Who may speak to the server: the page in this machine's browser that came by a link of the terminal.

A link holds a code that counts once.  The page exchanges it at once for the key, keeps that for its tab alone, and
sends it as a header with every request.  A browser sends no header of its own accord, neither to this server for
another page nor to another port of this machine.  What a browser loads without a header, files and reports, has a
ticket in its address, for that address and for once.
"""

from __future__ import annotations

import secrets
from hmac import compare_digest
from typing import TYPE_CHECKING
from urllib.parse import unquote

from starlette.datastructures import MutableHeaders
from starlette.requests import Request
from starlette.responses import JSONResponse, PlainTextResponse, Response

if TYPE_CHECKING:
    from starlette.types import ASGIApp, Message, Receive, Scope, Send

LOOPBACK = "127.0.0.1"
NAMES = (LOOPBACK, "localhost")
"""Names by which a browser may call the server: any other is another site's name that points to this machine."""
SAFE = ("GET", "HEAD")
KEY, CODES, TICKETS = "/api/key", "/api/codes", "/api/tickets"
"""Addresses at which the key, a code for another tab, and a ticket are had."""
OWN_PAGE = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
    "form-action 'none'; base-uri 'none'; frame-ancestors 'none'"
)
"""Content security policy of the page: nothing from elsewhere, no script or style within the markup."""
HEADERS = {
    "cache-control": "no-store",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "referrer-policy": "no-referrer",
    "x-content-type-options": "nosniff",
}
REFUSED = "Open the link that the terminal shows; Enter in the terminal shows a new one."
USED = "This link was used already, or is another server's. Press Enter in the terminal for a new one."
USED_TICKET = "This address worked once. Open it from the page again."


class Keys:
    """The key of a server, codes that are exchanged for it, and tickets for single addresses."""

    def __init__(self) -> None:
        self._key = secrets.token_urlsafe(24)
        self._codes: set[str] = set()
        self._tickets: dict[str, str] = {}

    def code(self) -> str:
        """A new code."""
        code = secrets.token_urlsafe(24)
        self._codes.add(code)
        return code

    def exchanged(self, code: str) -> str | None:
        """The key for a code that was not used yet; else None."""
        if code not in self._codes:
            return None
        self._codes.remove(code)
        return self._key

    def ticket(self, path: str) -> str:
        """A new ticket for a path."""
        ticket = secrets.token_urlsafe(24)
        self._tickets[ticket] = path
        return ticket

    def admits(self, ticket: str, path: str) -> bool:
        """Whether a ticket is for this path and was not used yet."""
        return self._tickets.pop(ticket, None) == path

    def is_key(self, text: str) -> bool:
        """Whether a text is the key."""
        return compare_digest(text.encode(), self._key.encode())


class Guard:
    """Lets through requests of the own page only, and sets the headers of every answer.

    Parameters
    ----------
    app : the application behind.
    port : of the server.
    """

    def __init__(self, app: ASGIApp, port: int) -> None:
        self._app, self.keys = app, Keys()
        self._hosts = {f"{name}:{port}" for name in NAMES}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request, or hand it on."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        if scope["type"] != "http":
            return

        async def with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                for name, value in HEADERS.items():
                    headers[name] = value
                headers.setdefault("content-security-policy", OWN_PAGE)
            await send(message)

        answer = self._answer(Request(scope)) or self._app
        await answer(scope, receive, with_headers)

    def _answer(self, request: Request) -> Response | None:
        """What a request gets that is not handed on; None: it is."""
        host = request.headers.get("host", "")
        if host not in self._hosts:
            return PlainTextResponse("This server answers to 127.0.0.1 only.\n", 421)
        path = request.scope["path"]
        if not self._from_own_page(request, path, host):
            return PlainTextResponse("Another page may not use this server.\n", 403)
        if path == "/" or path.startswith("/assets/"):
            return None
        scheme, _, given = request.headers.get("authorization", "").partition(" ")
        given = given if scheme == "Bearer" else ""
        if (request.method, path) == ("POST", KEY):
            key = self.keys.exchanged(given)
            return _refused(USED) if key is None else JSONResponse({"key": key})
        ticket = request.query_params.get("ticket")
        if request.method == "GET" and ticket is not None:
            return None if self.keys.admits(ticket, path) else _refused(USED_TICKET)
        return self._new_pass(request, path) if self.keys.is_key(given) else _refused(REFUSED)

    def _new_pass(self, request: Request, path: str) -> Response | None:
        """The answer to a page that asks for a code or a ticket; None where it asks for something else."""
        if (request.method, path) == ("POST", CODES):
            return JSONResponse({"code": self.keys.code()})
        if (request.method, path) == ("POST", TICKETS):
            return JSONResponse({"ticket": self.keys.ticket(unquote(request.query_params.get("path", "")))})
        return None

    def _from_own_page(self, request: Request, path: str, host: str) -> bool:
        """Whether the request is not another page's: a change must say that it comes from the own page."""
        origin = request.headers.get("origin")
        if origin is None:
            site = request.headers.get("sec-fetch-site", "none")
            return request.method in SAFE and (site in ("none", "same-origin") or path == "/")
        return origin == f"http://{host}"


def _refused(why: str) -> Response:
    return JSONResponse({"error": why}, 403)

"""Who may speak to the server: this machine's browser, with the token of the address that the terminal shows."""

from __future__ import annotations

from hmac import compare_digest
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

from starlette.datastructures import MutableHeaders
from starlette.requests import Request
from starlette.responses import PlainTextResponse, RedirectResponse, Response

if TYPE_CHECKING:
    from starlette.types import ASGIApp, Message, Receive, Scope, Send

LOOPBACK = "127.0.0.1"
NAMES = (LOOPBACK, "localhost")
"""Names by which a browser may call the server: any other is another site's name that points to this machine."""
SAFE = ("GET", "HEAD")
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
REFUSED = "Open the address that the terminal shows: it holds the key to this page.\n"


class Guard:
    """Lets through requests of the own page only, and sets the headers of every answer.

    Parameters
    ----------
    app : the application behind.
    token : what the address of the terminal holds; a browser that brings it gets a cookie.
    port : of the server.
    """

    def __init__(self, app: ASGIApp, token: str, port: int) -> None:
        self._app, self._token = app, token
        self._hosts = {f"{name}:{port}" for name in NAMES}
        self._cookie = f"helmbench-{port}"

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
        """What a request gets that is not let through; None: it is."""
        host = request.headers.get("host", "")
        if host not in self._hosts:
            return PlainTextResponse("This server answers to 127.0.0.1 only.\n", 421)
        if not self._from_own_page(request, host):
            return PlainTextResponse("Another page may not use this server.\n", 403)
        given = request.query_params.get("token")
        if given is not None and request.method in SAFE and _equal(given, self._token):
            return self._admitted(request)
        if not _equal(request.cookies.get(self._cookie, ""), self._token):
            return PlainTextResponse(REFUSED, 403)
        return None

    def _from_own_page(self, request: Request, host: str) -> bool:
        """Whether the request is not another page's: a change must say that it comes from the own page."""
        origin = request.headers.get("origin")
        if origin is None:
            site = request.headers.get("sec-fetch-site", "none")
            return request.method in SAFE and (site in ("none", "same-origin") or request.url.path == "/")
        parts = urlsplit(origin)
        return parts.scheme == "http" and parts.netloc == host

    def _admitted(self, request: Request) -> Response:
        """The same address without the token, and the cookie."""
        answer = RedirectResponse(request.url.path, 303)
        answer.set_cookie(self._cookie, self._token, httponly=True, samesite="strict", path="/")
        return answer


def _equal(one: str, other: str) -> bool:
    return compare_digest(one.encode(), other.encode())

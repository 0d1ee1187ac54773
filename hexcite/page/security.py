"""Who may use the page, and what a browser may do with it: token, host, origin, policies, one root folder."""

import hmac
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from starlette.requests import Request
from starlette.responses import PlainTextResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

MOST_FORM = 256 * 1024  # bytes of a form
MOST_UPLOAD = 2 * 2**30  # bytes of a recording
OWN = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
    "frame-src 'self'; form-action 'self'; base-uri 'none'; frame-ancestors 'none'"
)
"""Policy of the page itself: scripts and styles from files of its own, nothing from elsewhere, nothing evaluated."""
REPORT = (
    "sandbox allow-scripts; default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src data: blob:; frame-ancestors 'self'"
)
"""Policy of a report in a frame: an origin of its own, so that its script reaches neither the page nor a network."""
PICTURE = "sandbox; default-src 'none'; style-src 'unsafe-inline'; img-src data:"
CHANGING = ("POST", "PUT", "DELETE", "PATCH")
_PART = re.compile(r"[^/\\\x00-\x1f\x7f]{1,200}")


class Guard:
    """ASGI middleware: what does not come from this page's own browser window is refused before anything is read.

    Args:
        hosts: values of the header Host that are this server's, such as 127.0.0.1:8765.
        token: the secret of the address; a cookie has it afterwards.
        cookie: name of that cookie, of each port its own.
    """

    def __init__(self, app: ASGIApp, hosts: frozenset[str], token: str, cookie: str) -> None:
        self.app, self.hosts, self.token, self.cookie = app, hosts, token, cookie

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answers a request, or passes it on."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        refusal = self._refusal(Request(scope))

        async def with_policies(message: Message) -> None:
            if message["type"] == "http.response.start":
                names = {name for name, _ in message["headers"]}
                defaults = {
                    b"content-security-policy": OWN.encode(),
                    b"x-content-type-options": b"nosniff",
                    b"referrer-policy": b"same-origin",
                    b"cross-origin-opener-policy": b"same-origin",
                    b"cross-origin-resource-policy": b"same-origin",
                    b"cache-control": b"no-store",
                }
                message["headers"] = [*message["headers"], *((k, v) for k, v in defaults.items() if k not in names)]
            await send(message)

        await (self.app if refusal is None else refusal)(scope, receive, with_policies)

    def _refusal(self, request: Request) -> Response | None:
        if request.headers.get("host", "").lower() not in self.hosts:
            return PlainTextResponse("This page answers at its own address only.", 421)
        if request.method in CHANGING and not self._of_this_page(request.headers):
            return PlainTextResponse("This comes from another page.", 403)
        token = request.query_params.get("token")
        if token is not None and request.method == "GET" and _same(token, self.token):
            answer = RedirectResponse(request.url.path, 303)
            answer.set_cookie(self.cookie, self.token, httponly=True, samesite="strict", path="/")
            return answer
        if not _same(request.cookies.get(self.cookie, ""), self.token):
            return PlainTextResponse("Open the address that the terminal shows; it has the token.", 403)
        return None

    def _of_this_page(self, headers: Mapping[str, str]) -> bool:
        """Whether a browser says that a request was sent by this page; one that says nothing is refused."""
        site, origin = headers.get("sec-fetch-site"), headers.get("origin")
        if site is not None and site != "same-origin":
            return False
        if origin is None:
            return site == "same-origin"
        return origin.lower() in {f"http://{host}" for host in self.hosts}


def _same(given: str, token: str) -> bool:
    return hmac.compare_digest(given.encode(), token.encode())


class Outside(ValueError):
    """A path that a browser may not name."""


def inside(root: Path, *parts: str) -> Path:
    """A path below the root folder, its links resolved; raises Outside for any other, and for hidden ones."""
    for part in parts:
        if not _PART.fullmatch(part) or part.startswith("."):
            raise Outside(part)
    path = root.joinpath(*parts).resolve()
    if not path.is_relative_to(root):
        raise Outside(str(path))
    return path


def file_name(name: str) -> str:
    """A name of an uploaded file that is safe on every system; raises Outside where nothing is left of it."""
    cleaned = re.sub(r"[^\w.+-]+", "-", name.replace("\\", "/").rpartition("/")[2]).strip("-.")[-120:]
    if not cleaned:
        raise Outside(name)
    return cleaned


async def form_of(request: Request) -> dict[str, list[str]]:
    """The fields of a form, as a browser encodes them by default; raises Outside where it is too long."""
    from urllib.parse import parse_qs

    body = bytearray()
    async for chunk in request.stream():
        body += chunk
        if len(body) > MOST_FORM:
            raise Outside("the form is too long")
    fields: Any = parse_qs(body.decode("utf-8", "replace"), keep_blank_values=True, max_num_fields=2000)
    return dict(fields)

"""The server of the page: it answers whoever has the link, reads the campaign alone, and takes no path from anybody."""

from __future__ import annotations

import html
import re
import socket
from functools import cache
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib.resources import files
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, urlsplit

from graincal.campaign.stored.store import Store
from graincal.data import InputError
from graincal.watching.access import Access
from graincal.watching.board import Board, Full
from graincal.watching.evaluations import printed
from graincal.watching.following import follow, under_way

POLICY = "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src data: blob:; connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
"""A browser enforces it: no script but the server's own files, and nothing from elsewhere. Plotly puts styles into its figures."""

HEARTBEAT = 10.0
"""Seconds after which a stream without news says that it is there, and finds out whether anybody is."""

_PRINTED = re.compile("/printed/([0-9]{1,9})/([0-9]{1,4})")
_ASSETS = {
    "/": ("watching", "watch.html", "text/html"),
    "/watch.js": ("watching", "watch.js", "text/javascript"),
    "/watch.css": ("watching", "watch.css", "text/css"),
    "/page.css": ("report", "page.css", "text/css"),
}
# A redirection would be the navigation of whichever site the link stands on, and a strict cookie is not sent on that.
_ENTER = '<!doctype html><html lang="en"><head><meta charset="utf-8"><meta http-equiv="refresh" content="0;url=/"><title>graincal</title></head><body><p><a href="/">Go on</a></p></body></html>'


class Server(ThreadingHTTPServer):
    """Serves the page of a campaign. Raises OSError where it cannot listen there."""

    daemon_threads = True

    def __init__(self, folder: Path, host: str = "127.0.0.1", port: int = 0) -> None:
        self.folder, self.access, self.board = folder, Access(host), Board()
        self.address_family = socket.AF_INET6 if ":" in host else socket.AF_INET
        super().__init__((host, port), Handler)
        follow(folder, self.board)

    @property
    def link(self) -> str:
        """The address to open, with the token: where every address of this machine is listened at, by its name, which others have to know."""
        host, port = str(self.server_address[0]), self.server_address[1]
        host = socket.gethostname() if host in ("0.0.0.0", "::") else host
        return f"http://{f'[{host}]' if ':' in host else host}:{port}/?token={self.access.token}"

    def server_close(self) -> None:
        """End the streams, and listen no more."""
        self.board.end()
        super().server_close()

    def handle_error(self, request: Any, client_address: Any) -> None:
        """A browser that goes away in the middle of an answer is nothing to report."""


class Handler(BaseHTTPRequestHandler):
    """Answers one request."""

    server: Server
    server_version, sys_version = "graincal", ""
    timeout = 30

    def parse_request(self) -> bool:
        """Refuse what is no matter for this server before anything is looked at."""
        if not super().parse_request():
            return False
        if self.command not in ("GET", "HEAD"):
            self._answer(HTTPStatus.METHOD_NOT_ALLOWED, "Only GET and HEAD are answered here.", headers={"Allow": "GET, HEAD"})
            return False
        if not self.server.access.knows_host(self.headers.get_all("Host") or []):
            self._answer(HTTPStatus.FORBIDDEN, "This page is served to localhost, 127.0.0.1 and [::1] alone, or to the address given by --host.")
            return False
        return True

    def do_GET(self) -> None:
        """Let in whoever has the token, and answer whoever is in."""
        target, access = urlsplit(self.path), self.server.access
        token = parse_qs(target.query).get("token", [""])[0]
        if target.path == "/" and token and access.knows_token(token):
            self._answer(HTTPStatus.OK, _ENTER, "text/html", {"Set-Cookie": access.set_cookie})
        elif not access.knows_cookie(self.headers.get("Cookie")):
            self._answer(HTTPStatus.FORBIDDEN, "Open the link that graincal watch printed: it has the token that this page needs.")
        elif target.path in _ASSETS:
            package, name, kind = _ASSETS[target.path]
            self._answer(HTTPStatus.OK, _asset(package, name), kind)
        elif target.path == "/plotly.js":
            self._answer(HTTPStatus.OK, _plotly(), "text/javascript", {"Cache-Control": "private, max-age=3600"})
        elif target.path == "/events":
            self._stream()
        elif found := _PRINTED.fullmatch(target.path):
            self._printed(*map(int, found.groups()))
        else:
            self._answer(HTTPStatus.NOT_FOUND, "There is nothing here.")

    do_HEAD = do_GET

    def log_message(self, format: str, *arguments: Any) -> None:
        """Nothing: the first request has the token in it."""

    def _printed(self, sample: int, experiment: int) -> None:
        try:
            text = printed(Store.open(under_way(self.server.folder)), sample, experiment)
        except InputError as error:
            self._answer(HTTPStatus.INTERNAL_SERVER_ERROR, str(error))
            return
        if text is None:
            self._answer(HTTPStatus.NOT_FOUND, "Nothing is kept of what this evaluation printed.")
            return
        head = f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>Sample {sample}</title><link rel="stylesheet" href="/page.css"></head>'
        self._answer(HTTPStatus.OK, f"{head}<body><main><h1>What sample {sample} printed</h1><pre>{html.escape(text)}</pre></main></body></html>", "text/html")

    def _stream(self) -> None:
        if self.command == "HEAD":
            self._begin(HTTPStatus.OK, "text/event-stream", {})
            return
        try:
            with self.server.board.stream():
                self._begin(HTTPStatus.OK, "text/event-stream", {})
                self._send_news()
        except Full:
            self._answer(HTTPStatus.SERVICE_UNAVAILABLE, "As many pages follow this campaign as may: close one.", headers={"Retry-After": "10"})
        except OSError:
            # The page was closed.
            self.close_connection = True

    def _send_news(self) -> None:
        version, board = 0, self.server.board
        while not board.ended:
            version, news = board.since(version, HEARTBEAT)
            lines = [f"event: {kind.partition(' ')[0]}\ndata: {text}\n\n" for kind, text in news] or [": still there\n\n"]
            self.wfile.write("".join(lines).encode())
            self.wfile.flush()

    def _answer(self, code: HTTPStatus, text: str, kind: str = "text/plain", headers: dict[str, str] | None = None) -> None:
        data = text.encode("utf-8", errors="backslashreplace")
        self._begin(code, kind, {"Content-Length": str(len(data)), **(headers or {})})
        if self.command != "HEAD":
            self.wfile.write(data)

    def _begin(self, code: HTTPStatus, kind: str, headers: dict[str, str]) -> None:
        always = {
            "Content-Type": f"{kind}; charset=utf-8",
            "Content-Security-Policy": POLICY,
            "X-Content-Type-Options": "nosniff",
            "Referrer-Policy": "no-referrer",
            "Cross-Origin-Resource-Policy": "same-origin",
            "Cache-Control": "no-store",
        }
        self.send_response(code)
        for name, value in (always | headers).items():
            self.send_header(name, value)
        self.end_headers()


@cache
def _asset(package: str, name: str) -> str:
    return (files(f"graincal.{package}") / name).read_text(encoding="utf-8")


@cache
def _plotly() -> str:
    from plotly.offline import get_plotlyjs

    return get_plotlyjs()

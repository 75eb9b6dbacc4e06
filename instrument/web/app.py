"""What the server answers: the page, what it shows, past recordings, and the websocket."""

import asyncio
from collections.abc import Mapping
from importlib.resources import files
from typing import Final

from starlette.applications import Starlette
from starlette.requests import HTTPConnection, Request
from starlette.responses import FileResponse, HTMLResponse, RedirectResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocket, WebSocketDisconnect

from instrument.storage import json_text
from instrument.web.board import Board
from instrument.web.desk import Desk
from instrument.web.gate import Gate, Refusal
from instrument.web.shelf import Shelf
from instrument.web.viewer import Viewer

MOST_VIEWERS: Final = 32
"""Viewers at one time."""

_POLICY: Final = 1008  # of websockets: the page did what it may not
_TRY_LATER: Final = 1013

_PARTS: Final = {
    "page.css": "text/css",
    "page.js": "text/javascript",
    "wire.js": "text/javascript",
    "draw.js": "text/javascript",
    "past.js": "text/javascript",
    "icon.svg": "image/svg+xml",
}
"""Files of the page, by name, with their type."""

_HEADERS: Final = {
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self'; "
    "form-action 'self'; base-uri 'none'; frame-ancestors 'none'",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Cache-Control": "no-store",
}
"""Of every answer: nothing from elsewhere is loaded, nobody frames the page, nothing of it is kept."""


class Page:
    """The application. Its viewers are woken by the board."""

    def __init__(self, board: Board, desk: Desk, shelf: Shelf | None = None) -> None:
        """Serve a board, and past recordings if there is a shelf."""
        self._board, self._desk, self._shelf = board, desk, shelf
        self._viewers: set[Viewer] = set()
        self._loop: asyncio.AbstractEventLoop | None = None

    def guarded(self, gate: Gate) -> ASGIApp:
        """Give the application behind a gate."""
        app = Starlette(
            routes=[
                Route("/", _page),
                Route("/api/recordings", self._recordings),
                Route("/api/recordings/{name}", self._recording),
                Route("/api/recordings/{name}/{picture}.png", self._picture),
                Route("/page/{name}", _part),
                WebSocketRoute("/live", self._live),
            ]
        )
        return _Guarded(app, gate)

    @property
    def viewers(self) -> int:
        """Viewers that look on now."""
        return len(self._viewers)

    @property
    def all_up_to_date(self) -> bool:
        """Whether every viewer has been sent all that there is."""
        return all(viewer.up_to_date for viewer in tuple(self._viewers))

    def woken_by(self, loop: asyncio.AbstractEventLoop) -> None:
        """Wake the viewers, which live in that loop, at each change of the board."""
        self._loop = loop
        self._board.listen(self._wake)

    def _wake(self) -> None:
        loop = self._loop
        if loop is not None and self._viewers and not loop.is_closed():
            loop.call_soon_threadsafe(self._wake_viewers)

    def _wake_viewers(self) -> None:
        for viewer in self._viewers:
            viewer.wake()

    async def _live(self, socket: WebSocket) -> None:
        await socket.accept()
        if len(self._viewers) >= MOST_VIEWERS:
            await socket.close(_TRY_LATER, f"{MOST_VIEWERS} pages look on already")
            return
        viewer = Viewer(self._board, self._desk)
        self._viewers.add(viewer)
        sending = asyncio.create_task(viewer.send_all(socket.send_text, socket.send_bytes))
        try:
            while True:
                listening = asyncio.create_task(socket.receive_text())
                await asyncio.wait({listening, sending}, return_when=asyncio.FIRST_COMPLETED)
                if sending.done():
                    listening.cancel()
                    sending.result()
                wrong = viewer.take(await listening)
                if wrong is not None:
                    await socket.close(_POLICY, wrong)
                    return
        except (WebSocketDisconnect, OSError, RuntimeError, KeyError):
            return  # the page has gone, or speaks in bytes
        finally:
            self._viewers.discard(viewer)
            sending.cancel()

    def _recordings(self, _request: Request) -> Response:
        if self._shelf is None:
            return _json({"folder": None, "recordings": []})
        return _json({"folder": str(self._shelf.folder), "recordings": self._shelf.recordings()})

    def _recording(self, request: Request) -> Response:
        found = None if self._shelf is None else self._shelf.recording(request.path_params["name"])
        return _json(found) if found is not None else _json({"error": "no such recording"}, 404)

    def _picture(self, request: Request) -> Response:
        names = request.path_params
        found = None if self._shelf is None else self._shelf.picture(names["name"], names["picture"])
        return FileResponse(found, media_type="image/png") if found is not None else Response(status_code=404)


def page_part(name: str) -> bytes:
    """Give a file of the page."""
    return (files("instrument.web") / "page" / name).read_bytes()


def _page(_request: Request) -> Response:
    return HTMLResponse(page_part("index.html"))


def _part(request: Request) -> Response:
    name: str = request.path_params["name"]
    if name not in _PARTS:
        return Response(status_code=404)
    return Response(page_part(name), media_type=_PARTS[name])


class _Guarded:
    """Lets in whom the gate lets in, and puts the page's heads on every answer."""

    def __init__(self, app: ASGIApp, gate: Gate) -> None:
        self._app, self._gate = app, gate

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] not in {"http", "websocket"}:
            return

        async def send_with_heads(message: Message) -> None:
            if message["type"] in {"http.response.start", "websocket.http.response.start"}:
                heads = [(name.lower().encode(), value.encode()) for name, value in _HEADERS.items()]
                message = {**message, "headers": [*message.get("headers", ()), *heads]}
            await send(message)

        connection = HTTPConnection(scope)
        headers: Mapping[str, str] = {name.lower(): value for name, value in connection.headers.items()}
        refusal = self._gate.refusal(headers, websocket=scope["type"] == "websocket")
        if refusal is not None and refusal.status == 401 and scope["type"] == "http" and scope["path"] == "/":
            await self._asked(Request(scope))(scope, receive, send_with_heads)
        elif refusal is not None and scope["type"] == "websocket":
            await WebSocket(scope, receive, send_with_heads).send_denial_response(_no(refusal))
        elif refusal is not None:
            await _no(refusal)(scope, receive, send_with_heads)
        else:
            await self._app(scope, receive, send_with_heads)

    def _asked(self, request: Request) -> Response:
        """Take the token of a link, and give a cookie for it; or ask for the token."""
        token = request.query_params.get("token")
        if token is not None and self._gate.opens(token):
            answer = RedirectResponse("/", 303)
            answer.set_cookie(self._gate.cookie, self._gate.ticket, httponly=True, samesite="strict")
            return answer
        return HTMLResponse(page_part("token.html"), 401)


def _no(refusal: Refusal) -> Response:
    return _json({"error": refusal.reason}, refusal.status)


def _json(figures: Mapping[str, object], status: int = 200) -> Response:
    """Answer with figures; those that are not finite as null."""
    return Response(json_text(figures), status, media_type="application/json")

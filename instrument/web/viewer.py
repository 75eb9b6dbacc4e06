"""One viewer: what it is sent, and when. It has one slot: the newest image goes into it, and those that it missed are counted."""

import json
import time
from asyncio import Event, wait_for
from collections.abc import Awaitable, Callable
from typing import Any, Final, TypeAlias

from instrument.web.board import Board
from instrument.web.desk import WISHES, Desk
from instrument.web.frames import IMAGE, PATH, frame, path_body

SendText: TypeAlias = Callable[[str], Awaitable[None]]
SendBytes: TypeAlias = Callable[[bytes], Awaitable[None]]

UNSEEN: Final = 4
"""Images that may be on their way to a viewer which has not said that it has drawn them."""

STATE_INTERVAL_S: Final = 0.1
"""Shortest time from one state to the next."""

_REST_S: Final = 1.0  # a state now and then, so that a page knows that the server lives


class Viewer:
    """Sends what is new, as fast as the page takes it, and takes what the page says.

    Nothing queues up: while the page has drawn too little of what it was sent, only the board changes.
    """

    def __init__(self, board: Board, desk: Desk) -> None:
        """Nothing has been sent yet."""
        self._board = board
        self._desk = desk
        self._wake = Event()
        self._image = 0
        self._seen = 0
        self._sent = 0
        self.skipped = 0
        """Images that it missed because newer ones came."""
        self._generation: int | None = None
        self._points = 0
        self._state_version = -1
        self._state_sent_s = -float("inf")
        self.up_to_date = False
        """Whether it has been sent all that there is."""

    def wake(self) -> None:
        """Look again; from the server's own thread."""
        self.up_to_date = False
        self._wake.set()

    def take(self, text: str) -> str | None:
        """Take what the page says: that it has drawn an image, or a wish.

        Returns:
            None if it is understood and allowed; otherwise why the page is shown the door.
        """
        try:
            said: Any = json.loads(text)
        except ValueError:
            return "no JSON"
        match said:
            case {"seen": int(sequence)}:
                self._seen = max(self._seen, min(sequence, self._sent))
                self._wake.set()
                return None
            case {"wish": str(wish)} if wish in WISHES:
                return self._wish(wish)
            case _:
                return "nothing that this server understands"

    def _wish(self, wish: Any) -> str | None:
        if not self._board.control:
            return "this page may only look on"
        if not self._desk.ask(wish):
            self._board.say(notice="too many wishes at once; this one was not taken")
        return None

    async def send_all(self, send_text: SendText, send_bytes: SendBytes) -> None:
        """Send what is new for as long as the page is there."""
        while True:
            self._wake.clear()
            rest_s = await self._send_news(send_text, send_bytes)
            try:
                await wait_for(self._wake.wait(), rest_s)
            except TimeoutError:
                continue

    async def _send_news(self, send_text: SendText, send_bytes: SendBytes) -> float:
        """Send what is new now, and give the time after which to look again."""
        image = self._board.image
        if image is not None and image.sequence != self._image and self._sent - self._seen < UNSEEN:
            self.skipped += image.sequence - self._image - 1 if self._image else 0
            self._image = image.sequence
            self._sent += 1
            await send_bytes(self._frame(IMAGE, self._sent, image.body, image.made_s))
        await self._send_path(send_bytes)
        now_s = time.monotonic()
        version = self._board.version
        due_s = self._state_sent_s + (STATE_INTERVAL_S if version != self._state_version else _REST_S)
        if now_s >= due_s:
            self._state_version, self._state_sent_s = version, now_s
            await send_text(self._board.state.model_dump_json())
            due_s = now_s + _REST_S
        image = self._board.image
        seen = image is None or image.sequence == self._image
        self.up_to_date = seen and self._state_version == self._board.version
        return max(0.0, due_s - now_s)

    async def _send_path(self, send_bytes: SendBytes) -> None:
        path = self._board.path
        if path.generation != self._generation:
            self._generation, self._points = path.generation, 0
        elif len(path.points) == self._points:
            return
        first, self._points = self._points, len(path.points)
        body = path_body(first, path.points[first:])
        await send_bytes(self._frame(PATH, path.generation, body, 0.0))

    def _frame(self, kind: int, sequence: int, body: bytes, made_s: float) -> bytes:
        return frame(kind, sequence, body, skipped=self.skipped, sent_s=time.time(), made_s=made_s)

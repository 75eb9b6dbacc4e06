"""What one viewer is sent: the newest image, the path as it grows, the state; and what it may say."""

import asyncio
import json
import struct
from collections.abc import Awaitable, Callable

import numpy as np
import pytest

from instrument.session import ImageEvent, TrackingEvent
from instrument.web import Board, Desk
from instrument.web.viewer import UNSEEN, Viewer


class Page:
    """Takes what a viewer is sent."""

    def __init__(self) -> None:
        self.texts: list[str] = []
        self.frames: list[bytes] = []

    async def text(self, text: str) -> None:
        self.texts.append(text)

    async def binary(self, frame: bytes) -> None:
        self.frames.append(frame)

    @property
    def images(self) -> list[tuple[int, int, int]]:
        """Sequence, images missed and frames of each image."""
        found = [struct.unpack_from("<IIddHHI", frame, 8) for frame in self.frames if frame[6] == 1]
        return [(head[0], head[1], head[6]) for head in found]

    @property
    def points(self) -> list[tuple[int, int, int]]:
        """Generation, first point and number of points of each part of the path."""
        parts = [frame for frame in self.frames if frame[6] == 2]
        return [(*struct.unpack_from("<I", f, 8), *struct.unpack_from("<I", f, 32), (len(f) - 36) // 20) for f in parts]


def looked_at(board: Board, script: Callable[[Viewer, Page], Awaitable[None]], *, desk: Desk | None = None) -> Page:
    """Let a viewer look at a board while a script goes on in the same loop."""

    async def both() -> Page:
        page, viewer = Page(), Viewer(board, desk or Desk())
        board.listen(viewer.wake)
        sending = asyncio.create_task(viewer.send_all(page.text, page.binary))
        await settle()
        await script(viewer, page)
        await settle()
        sending.cancel()
        return page

    return asyncio.run(both())


async def settle() -> None:
    for _ in range(10):
        await asyncio.sleep(0)


def show(board: Board, frames: int) -> None:
    board(ImageEvent(frame=frames, image=np.eye(2)))


def test_images_that_a_viewer_is_too_late_for_are_missed_and_counted() -> None:
    """Four are on their way unseen; of the six that come then, the last is sent when one has been seen, and five are missed."""
    board = Board("a bench")

    async def script(viewer: Viewer, page: Page) -> None:
        for frames in range(1, 11):
            show(board, frames)
            await settle()
        assert [frames for _, _, frames in page.images] == [1, 2, 3, 4]
        assert not viewer.up_to_date
        viewer.take('{"seen": 1}')
        await settle()
        assert viewer.skipped == 5

    page = looked_at(board, script)
    assert page.images[-1] == (5, 5, 10)


def test_a_viewer_that_says_it_saw_what_was_never_sent_gains_nothing() -> None:
    board = Board("a bench")

    async def script(viewer: Viewer, page: Page) -> None:
        viewer.take('{"seen": 1000}')
        for frames in range(1, 11):
            show(board, frames)
            await settle()
        assert len(page.images) == UNSEEN

    looked_at(board, script)


def test_the_path_is_sent_once_and_anew_when_its_first_points_changed() -> None:
    board = Board("a bench")

    async def script(_viewer: Viewer, page: Page) -> None:
        for first, n in ((0, 3), (3, 2), (5, 2043), (2048, 2)):
            board(TrackingEvent(frame=first + n, displacement_px=np.zeros((n, 2))))
            await settle()
        assert page.points == [(0, 0, 0), (0, 0, 3), (0, 3, 2), (0, 5, 2043), (1, 0, 1025)]

    looked_at(board, script)


def test_the_state_is_sent_at_once_and_then_ten_times_a_second_at_most() -> None:
    board = Board("a bench")

    async def script(viewer: Viewer, page: Page) -> None:
        for k in range(20):
            board.say(f"at {k}")
            await settle()
        assert [json.loads(text)["doing"] for text in page.texts] == ["at rest"]
        assert not viewer.up_to_date
        await asyncio.sleep(0.15)
        assert [json.loads(text)["doing"] for text in page.texts] == ["at rest", "at 19"]
        assert viewer.up_to_date

    looked_at(board, script)


@pytest.mark.parametrize(
    ("said", "why"),
    [
        ("{", "no JSON"),
        ("[]", "nothing that this server understands"),
        ('{"wish": "dance"}', "nothing that this server understands"),
        ('{"seen": "1"}', "nothing that this server understands"),
        ('{"seen": 0}', None),
    ],
)
def test_what_is_not_understood_ends_the_connection(said: str, why: str | None) -> None:
    assert Viewer(Board("a bench", control=True), Desk()).take(said) == why


def test_a_wish_reaches_the_desk_where_the_page_may_steer_and_no_other() -> None:
    desk = Desk()
    assert Viewer(Board("a bench"), desk).take('{"wish": "start"}') == "this page may only look on"
    assert desk.take(0.0) is None
    board = Board("a bench", control=True)
    viewer = Viewer(board, desk)
    assert [viewer.take('{"wish": "start"}') for _ in range(9)] == [None] * 9
    assert board.state.notice == "too many wishes at once; this one was not taken"
    assert desk.take(0.0) == "start"

"""The server as others meet it: by HTTP and by websocket, well and badly behaved."""

import http.client
import json
import socket
import time
from collections.abc import Generator
from contextlib import ExitStack
from pathlib import Path
from threading import Thread
from typing import Any

import numpy as np
import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.frames import Close
from websockets.sync.client import ClientConnection, connect

from instrument.live import LiveAnalysis
from instrument.session import ImageEvent, Instrument, RunAborted
from instrument.storage import open_recording
from instrument.web import Board, Desk, PageServer, RunPage, Shelf, serve_bench
from instrument.web import server as server_module
from protocols import Floats, InputError
from tests.support.benches import SMALL, bench_toml
from tests.support.held import HeldCounter

TOKEN = "sixteen-letters!"  # noqa: S105


def get(port: int, path: str = "/", **heads: str) -> tuple[int, dict[str, str], bytes]:
    """Ask by HTTP; ``_`` in a head's name is ``-``."""
    line = http.client.HTTPConnection("127.0.0.1", port, timeout=10)
    line.request("GET", path, headers={name.replace("_", "-"): value for name, value in heads.items()})
    answer = line.getresponse()
    found = answer.status, {name.lower(): value for name, value in answer.getheaders()}, answer.read()
    line.close()
    return found


def look(port: int, **heads: str) -> ClientConnection:
    return connect(
        f"ws://127.0.0.1:{port}/live",
        additional_headers=heads,
        open_timeout=10,
        close_timeout=1,
        max_size=None,
        compression=None,
        proxy=None,
    )


def frozen(port: int) -> socket.socket:
    """Ask for a websocket, and then take nothing."""
    line = socket.create_connection(("127.0.0.1", port))
    line.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    line.sendall(
        f"GET /live HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n".encode()
    )
    return line


def state_of(viewer: ClientConnection) -> dict[str, Any]:
    """The next state."""
    while True:
        said = viewer.recv(timeout=10)
        if isinstance(said, str):
            state: dict[str, Any] = json.loads(said)
            return state


def end_of(viewer: ClientConnection) -> Close:
    """How the server ends the connection."""
    while True:
        try:
            viewer.recv(timeout=10)
        except ConnectionClosed as closed:
            return closed.rcvd or Close(1006, "")


@pytest.fixture(scope="module")
def open_to_all(tmp_path_factory: pytest.TempPathFactory) -> Generator[PageServer]:
    """A server that nobody needs a token for."""
    with PageServer(Board("here"), shelf=Shelf(tmp_path_factory.mktemp("empty")), port=0) as server:
        yield server


@pytest.fixture(scope="module")
def locked() -> Generator[PageServer]:
    """A server that asks for a token."""
    with PageServer(Board("there"), port=0, token=TOKEN) as server:
        yield server


@pytest.mark.parametrize(
    ("path", "kind"),
    [
        ("/", "text/html"),
        ("/page/page.css", "text/css"),
        ("/page/page.js", "text/javascript"),
        ("/page/wire.js", "text/javascript"),
        ("/page/draw.js", "text/javascript"),
        ("/page/past.js", "text/javascript"),
        ("/page/icon.svg", "image/svg+xml"),
        ("/api/recordings", "application/json"),
    ],
)
def test_the_page_is_there_and_loads_nothing_from_elsewhere(open_to_all: PageServer, path: str, kind: str) -> None:
    status, heads, body = get(open_to_all.port, path)
    assert (status, heads["content-type"].split(";")[0]) == (200, kind)
    assert heads["content-security-policy"].startswith("default-src 'none'; script-src 'self'")
    assert (heads["x-frame-options"], heads["cross-origin-resource-policy"]) == ("DENY", "same-origin")
    text = body.decode().replace("http://www.w3.org/2000/svg", "")
    assert [word for word in ("http:", "https:", "//cdn") if word in text] == []


@pytest.mark.parametrize(
    "path",
    [
        "/page/token.html",
        "/page/..%2fapp.py",
        "/page/../app.py",
        "/nothing",
        "/api/recordings/x.h5",
        "/api/recordings/..%2fx/summary.png",
    ],
)
def test_what_is_not_there_is_not_found(open_to_all: PageServer, path: str) -> None:
    assert get(open_to_all.port, path)[0] == 404


def test_another_origin_and_another_name_are_refused_by_http(open_to_all: PageServer) -> None:
    port = open_to_all.port
    assert get(port, "/api/recordings", Origin="http://evil.example")[0] == 403
    assert get(port, "/api/recordings", Sec_Fetch_Site="cross-site", Sec_Fetch_Mode="no-cors")[0] == 403
    assert get(port, "/", Host=f"evil.example:{port}")[0] == 400
    assert get(port, "/api/recordings", Origin=f"http://127.0.0.1:{port}")[0] == 200


def test_another_origin_and_another_name_are_refused_by_websocket(open_to_all: PageServer) -> None:
    port = open_to_all.port
    for heads, status in (({"Origin": "http://evil.example"}, 403), ({"Host": f"evil.example:{port}"}, 400)):
        with pytest.raises(InvalidStatus) as refused:
            look(port, **heads)
        assert refused.value.response.status_code == status
    with look(port, Origin=f"http://127.0.0.1:{port}") as viewer:
        assert state_of(viewer)["title"] == "here"


def test_a_missing_or_a_wrong_token_is_refused(locked: PageServer) -> None:
    port = locked.port
    for heads in ({}, {"Authorization": "Bearer wrong"}, {"Cookie": f"kinopix-{port}=wrong"}):
        assert get(port, "/api/recordings", **heads)[0] == 401
        with pytest.raises(InvalidStatus) as refused:
            look(port, **heads)
        assert refused.value.response.status_code == 401
    for path in ("/", "/?token=wrong"):
        status, _, body = get(port, path)
        assert (status, b"This page asks for a token" in body) == (401, True)
    with look(port, Authorization=f"Bearer {TOKEN}") as viewer:
        assert state_of(viewer)["title"] == "there"


def test_the_link_with_the_token_gives_a_cookie_and_takes_the_token_out_of_the_address(locked: PageServer) -> None:
    assert locked.address == f"http://127.0.0.1:{locked.port}/?token={TOKEN}"
    status, heads, _ = get(locked.port, f"/?token={TOKEN}")
    assert (status, heads["location"]) == (303, "/")
    assert "HttpOnly" in heads["set-cookie"]
    assert "SameSite=strict" in heads["set-cookie"]
    assert TOKEN not in heads["set-cookie"]
    assert get(locked.port, "/", Cookie=heads["set-cookie"].split(";")[0])[0] == 200


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "192.0.2.1"])  # noqa: S104
def test_another_address_without_a_token_is_refused_before_the_port_is_taken(host: str) -> None:
    with pytest.raises(InputError, match="without a token"):
        PageServer(Board("far"), host=host, port=0)


def test_a_port_that_is_taken_is_told(open_to_all: PageServer) -> None:
    with pytest.raises(InputError, match=f"port {open_to_all.port} of 127.0.0.1 refused"):
        PageServer(Board("second"), port=open_to_all.port)


def test_connections_send_at_once_what_they_are_given() -> None:
    """Nagle's algorithm would hold each path and the image behind it for 40 ms."""
    with ExitStack() as opened:
        listening = opened.enter_context(server_module._bound("127.0.0.1", 0))  # pyright: ignore[reportPrivateUsage]
        opened.enter_context(socket.create_connection(listening.getsockname()))
        connection = opened.enter_context(listening.accept()[0])
        assert connection.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)


def test_a_page_that_may_only_look_on_is_shown_the_door_when_it_asks(open_to_all: PageServer) -> None:
    with look(open_to_all.port) as viewer:
        viewer.send('{"wish": "start"}')
        closed = end_of(viewer)
    assert (closed.code, closed.reason) == (1008, "this page may only look on")


def test_a_viewer_that_sends_too_much_or_bytes_is_let_go_and_others_stay(open_to_all: PageServer) -> None:
    with look(open_to_all.port) as well_behaved:
        for said in ("x" * 5000, b"bytes"):
            with look(open_to_all.port) as viewer:
                viewer.send(said)
                end_of(viewer)
        well_behaved.send('{"seen": 0}')
        assert state_of(well_behaved)["title"] == "here"


def test_the_33rd_viewer_is_asked_to_come_later(open_to_all: PageServer) -> None:
    with ExitStack() as others:
        for _ in range(32):
            state_of(others.enter_context(look(open_to_all.port)))
        with look(open_to_all.port) as late:
            assert end_of(late).code == 1013


def test_the_server_is_gone_within_two_seconds_though_a_viewer_hangs() -> None:
    board = Board("here")
    with ExitStack() as opened:
        server = opened.enter_context(PageServer(board, port=0))
        opened.enter_context(frozen(server.port))
        viewer = opened.enter_context(look(server.port))
        state_of(viewer)
        big = ImageEvent(frame=1, image=np.eye(1500))
        for _ in range(4):  # 9 million pixels, more than a socket takes
            board(big)
            viewer.recv(timeout=10)
        begun_s = time.monotonic()
        server.__exit__()
        took_s = time.monotonic() - begun_s
    assert took_s < 2.0
    with pytest.raises(OSError):
        socket.create_connection(("127.0.0.1", server.port), timeout=1)


def recorded(folder: Path, name: str, viewers: int, hung: int) -> Floats:
    """The values of a run of 400 frames that so many look on."""
    plan = SMALL.model_copy(update={"frames": 400})
    bench = bench_toml(folder, 'object = "letter-B"\nnoise = { kind = "poisson", seed = 3 }')
    page = RunPage(Board("here"), Desk())
    with (
        PageServer(page.board, page.desk, port=0) as server,
        Instrument.from_toml(bench) as instrument,
        ExitStack() as opened,
    ):
        for _ in range(hung):
            opened.enter_context(frozen(server.port))
        pages = [opened.enter_context(look(server.port)) for _ in range(viewers)]
        for each in pages:
            state_of(each)
        board = page.begins(instrument, plan)
        with instrument.start(plan, folder / name, listeners=[LiveAnalysis(plan), board]) as run:
            page.attend(run)
            run.wait()
            run.wait_for_listeners(20)
        for each in pages:
            while (now := state_of(each)["run"]) is None or not now["finished"]:
                pass
    return open_recording(folder / name).values


def test_the_recording_is_the_same_to_the_bit_whoever_looks_on(tmp_path: Path) -> None:
    alone = recorded(tmp_path, "0.h5", 0, 0)
    assert np.array_equal(recorded(tmp_path, "1.h5", 1, 0), alone)
    assert np.array_equal(recorded(tmp_path, "5.h5", 4, 1), alone)


def test_a_page_that_may_steer_stops_a_run_as_ctrl_c_does(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The first 1,000 patterns are kept, the recording says why it is partial, and the bench can do the next run."""
    plan = SMALL.model_copy(update={"frames": 1000})
    page = RunPage(Board("here", control=True), Desk())
    with PageServer(page.board, page.desk, port=0) as server, Instrument.from_toml(bench_toml(tmp_path)) as instrument:
        held = HeldCounter(instrument, monkeypatch)
        board = page.begins(instrument, plan)
        with look(server.port) as viewer, instrument.start(plan, tmp_path / "run.h5", listeners=[board]) as run:
            attending = Thread(target=page.attend, args=(run,))
            attending.start()
            assert held.there.wait(20)
            while state_of(viewer)["offers"] != ["stop"]:
                pass
            viewer.send('{"wish": "stop"}')
            while state_of(viewer)["doing"] != "stopping":
                pass
            held.go.set()
            attending.join(20)
            with pytest.raises(RunAborted, match="stopped from the page"):
                run.wait()
            while not (last := state_of(viewer))["run"]["finished"]:
                pass
        assert (last["run"]["state"], last["run"]["finished"]["verdict"]) == ("aborted", "partial")
        assert 1000 <= last["run"]["patterns_done"] < 6000
        assert len(open_recording(tmp_path / "run.h5")) >= 166
        assert len(instrument.run(SMALL, tmp_path / "next.h5")) == 40


class ScriptedDesk(Desk):
    """Wishes in a row, and Ctrl-C at the end; each is taken when the bench is at rest."""

    def __init__(self, board: Board, *wishes: Any) -> None:
        super().__init__()
        self._board, self._script = board, list(wishes)

    def take(self, timeout_s: float) -> Any:
        if self._board.state.doing != "at rest":
            return super().take(timeout_s)
        if not self._script:
            raise KeyboardInterrupt
        return self._script.pop(0)


def test_a_bench_at_rest_does_what_pages_wish_until_ctrl_c(tmp_path: Path) -> None:
    board, told = Board("here", control=True), list[str]()
    page = RunPage(board, ScriptedDesk(board, "check", "home", "stop", "start"))
    with (
        pytest.raises(KeyboardInterrupt),
        Instrument.from_toml(bench_toml(tmp_path, 'object = "letter-B"')) as instrument,
    ):
        serve_bench(instrument, SMALL.model_copy(update={"frames": 100}), tmp_path, page, told.append)
    assert told[0] == "checked: nothing stands against the run"
    assert told[1] == "the stage is at its origin, 0.0000 mm"
    assert told[2] == "nothing goes on that could be stopped"
    (recorded,) = tmp_path.glob("run-*.h5")
    assert told[3:] == [f"recorded in {recorded}"]
    assert len(open_recording(recorded)) == 100


def test_an_error_of_a_wish_is_shown_and_the_bench_goes_on(tmp_path: Path) -> None:
    plan = SMALL.model_copy(update={"pattern_rate_hz": 40_000.0})
    board, told = Board("here", control=True), list[str]()
    page = RunPage(board, ScriptedDesk(board, "check", "start", "home"))
    with pytest.raises(KeyboardInterrupt), Instrument.from_toml(bench_toml(tmp_path)) as instrument:
        serve_bench(instrument, plan, tmp_path, page, told.append)
    assert told[0] == "checked: the plan cannot be carried out"
    assert told[1].startswith("modulator: saw a picture time of 25 us")
    assert told[2].startswith("the stage is at its origin")
    assert page.board.state.notice == told[2]
    assert {check.name: check.outcome for check in page.board.state.checks}["picture time"] == "error"


def test_without_a_plan_nothing_can_be_started(tmp_path: Path) -> None:
    board, told = Board("here", control=True), list[str]()
    page = RunPage(board, ScriptedDesk(board, "start", "check"))
    with pytest.raises(KeyboardInterrupt), Instrument.from_toml(bench_toml(tmp_path)) as instrument:
        serve_bench(instrument, None, tmp_path, page, told.append)
    assert told == ["start is not offered here", "check is not offered here"]
    assert page.board.state.offers == ("home",)

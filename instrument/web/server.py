"""The thread that serves the page. It owns no device, and is gone within two seconds, whatever its viewers do."""

import asyncio
import logging
import socket
import time
from importlib.util import find_spec
from threading import Event, Thread
from typing import TYPE_CHECKING, Final, Self

from instrument.web.board import Board
from instrument.web.desk import Desk
from instrument.web.gate import Gate
from instrument.web.shelf import Shelf
from protocols import InputError

if TYPE_CHECKING:
    from uvicorn import Server

    from instrument.web.app import Page

PORT: Final = 8470
"""Where pages are served unless somebody says otherwise."""

_LAST_S: Final = 0.3
"""How long viewers have to take the last news."""

_GONE_S: Final = 1.5
_START_S: Final = 10.0
_LOOK_S: Final = 0.02


class PageServer:
    """Serves a board from when it is entered until it is left.

    The port is taken when it is made, so that one in use is told before anything else happens.
    """

    def __init__(
        self,
        board: Board,
        desk: Desk | None = None,
        shelf: Shelf | None = None,
        *,
        host: str = "127.0.0.1",
        port: int = PORT,
        token: str | None = None,
    ) -> None:
        """Take the port; nobody is served yet.

        Args:
            board: what is shown.
            desk: where wishes go.
            shelf: past recordings.
            host: address to listen at.
            port: port to listen at; 0 takes a free one.
            token: what viewers must know; see ``Gate``.

        Raises:
            InputError: no library for it, an address without a token, or a port that is taken.
        """
        refuse_no_library()
        Gate(host, port, token)  # refused before the port is taken
        self._socket = _bound(host, port)
        self.port: int = self._socket.getsockname()[1]
        """The port."""
        self._host, self._token = host, token
        self._gate = Gate(host, self.port, token)
        self._parts = (board, desk or Desk(), shelf)
        self._page: Page | None = None
        self._server: Server | None = None
        self._serving = Event()
        self._thread = Thread(target=self._serve, name="kinopix-page", daemon=True)

    @property
    def address(self) -> str:
        """Where a browser on this machine finds it, with the token where there is one."""
        name = {"0.0.0.0": "127.0.0.1", "::": "[::1]"}.get(self._host, self._host)  # noqa: S104 - looked for, not bound
        name = f"[{name}]" if ":" in name.strip("[]") and not name.startswith("[") else name
        return f"http://{name}:{self.port}/" + ("" if self._token is None else f"?token={self._token}")

    @property
    def viewers(self) -> int:
        """Pages that look on now."""
        return 0 if self._page is None else self._page.viewers

    def wait_shown(self, timeout_s: float = 1.0) -> bool:
        """Wait until every page has been sent all that there is, and tell whether it has; for the end of a run."""
        end_s, pause = time.monotonic() + timeout_s, Event()
        while self._page is not None and not self._page.all_up_to_date:
            if time.monotonic() > end_s:
                return False
            pause.wait(_LOOK_S)
        return True

    def __enter__(self) -> Self:
        """Start to serve."""
        self._thread.start()
        self._serving.wait(_START_S)
        return self

    def __exit__(self, *_: object) -> None:
        """End; viewers that hang are left behind."""
        self.wait_shown(_LAST_S)
        if self._server is not None:
            self._server.should_exit = True
        self._thread.join(_GONE_S)
        if self._thread.is_alive() and self._server is not None:
            self._server.force_exit = True
        self._socket.close()

    def _serve(self) -> None:
        import uvicorn  # noqa: PLC0415 - loaded by the thread that needs it

        from instrument.web.app import Page  # noqa: PLC0415

        self._page = page = Page(*self._parts)
        logging.getLogger("uvicorn").addHandler(
            logging.NullHandler()
        )  # its troubles are for a log, not for the terminal
        config = uvicorn.Config(
            page.guarded(self._gate),
            log_config=None,
            access_log=False,
            lifespan="off",
            ws="websockets-sansio",
            ws_max_size=4096,
            ws_per_message_deflate=False,
            server_header=False,
            timeout_graceful_shutdown=1,  # seconds; uvicorn takes whole ones
            limit_concurrency=200,
        )
        self._server = server = uvicorn.Server(config)

        async def serve() -> None:
            page.woken_by(asyncio.get_running_loop())
            serving = asyncio.create_task(server.serve(sockets=[self._socket]))
            while not (server.started or serving.done()):  # noqa: ASYNC110 - uvicorn offers nothing to wait for
                await asyncio.sleep(_LOOK_S)
            self._serving.set()
            await serving
            for left in list(server.server_state.connections):
                left.transport.abort()  # of viewers that hang
            await asyncio.sleep(0)

        try:
            asyncio.run(serve())
        finally:
            self._serving.set()


def refuse_no_library() -> None:
    """Refuse to serve without the libraries for it.

    Raises:
        InputError: names those that are missing.
    """
    missing = [name for name in ("starlette", "uvicorn", "websockets") if find_spec(name) is None]
    if missing:
        raise InputError(
            saw=f"no library {', '.join(missing)}, by which pages are served",
            expected="Kinopix with what its page needs",
            remedy="pip install 'kinopix[web]'",
        )


def _bound(host: str, port: int) -> socket.socket:
    """Take the port."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        taken = socket.create_server((host.strip("[]"), port), family=family)
    except (OSError, OverflowError) as error:
        raise InputError(
            saw=f"port {port} of {host} refused: {error}",
            expected="an address of this machine, and a port that is free",
            remedy="choose another with --port, or 0 for any that is free",
        ) from error
    # A path follows each image in a packet of its own. Nagle's algorithm would hold it, and the next image behind it, until the
    # browser acknowledges the first, which it puts off for 40 ms. Connections inherit this from the socket that listens.
    taken.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return taken

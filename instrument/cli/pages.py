"""What ``run --web`` and ``serve`` share: the options of a page, and the server behind them."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final, TypeAlias

import typer

if TYPE_CHECKING:
    from instrument.web import Board, Desk, PageServer

PORT: Final = 8470

HostOption: TypeAlias = Annotated[
    str, typer.Option("--host", help="Address to serve the page at; another than this machine's own needs a token.")
]
PortOption: TypeAlias = Annotated[
    int, typer.Option("--port", min=0, max=65535, help="Port to serve the page at; 0 takes a free one.")
]
TokenOption: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--token",
        envvar="KINOPIX_TOKEN",
        show_envvar=True,
        help="Secret that viewers must know, of 16 characters or more. Others on this machine can read what stands on a "
        "command line: better set the variable.",
    ),
]
ControlOption: TypeAlias = Annotated[
    bool,
    typer.Option(
        "--control", help="Let the page steer, not only look on. Without a token one is made up, and printed."
    ),
]


@dataclass(frozen=True)
class PageOptions:
    """How a page is served."""

    host: str = "127.0.0.1"
    """Address."""
    port: int = PORT
    """Port."""
    token: str | None = None
    """What viewers must know."""
    control: bool = False
    """Whether the page may steer."""

    def server(self, board: "Board", desk: "Desk", folder: Path | None) -> "PageServer":
        """Give a server that has its port, and serves when it is entered.

        Raises:
            InputError: as ``PageServer`` and ``Shelf``.
        """
        import secrets

        from instrument.web import PageServer, Shelf

        token = self.token
        if token is None and self.control and self.host in {"127.0.0.1", "localhost", "::1"}:
            token = secrets.token_urlsafe(16)  # whoever else works on this machine must not move the stage
        shelf = None if folder is None else Shelf(folder, lambda: board.over)
        return PageServer(board, desk, shelf, host=self.host, port=self.port, token=token)


def say_where(server: "PageServer") -> None:
    """Tell where the page is, on standard error: standard output may be JSON."""
    from instrument.views import ERR, plain

    ERR.print(plain(f"page: {server.address}", "bold"), soft_wrap=True)

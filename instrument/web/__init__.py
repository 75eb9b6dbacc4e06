"""A page in the browser: the bench, the run as it goes on, and what was recorded before.

``Board`` is what is shown, ``Desk`` where wishes from the page wait for whoever holds the bench, ``PageServer`` the thread that
serves both. The server's thread owns no device. Starlette, uvicorn and websockets come with ``pip install 'kinopix[web]'``;
nothing of them is loaded before a ``PageServer`` is made.
"""

from instrument.web.attending import RunPage, serve_bench
from instrument.web.board import Board
from instrument.web.desk import Desk, Wish
from instrument.web.gate import Gate
from instrument.web.server import PageServer
from instrument.web.shelf import Shelf
from instrument.web.state import PageState

__all__ = ["Board", "Desk", "Gate", "PageServer", "PageState", "RunPage", "Shelf", "Wish", "serve_bench"]

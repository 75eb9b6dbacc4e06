"""Work that goes on in a thread, as a RunEngine wants to know of it."""

from collections.abc import Callable
from concurrent.futures import CancelledError, Future
from concurrent.futures import TimeoutError as NotYet
from threading import Thread

from bluesky.protocols import Status


class WorkStatus(Status):
    """``bluesky.protocols.Status`` of a function that a thread of its own runs: done when it returns, failed when it raises.

    Callbacks come on that thread, or at once where the work is over.
    """

    def __init__(self, work: Callable[[], object], name: str) -> None:
        """Begin the work.

        Args:
            work: what to do.
            name: of the thread.
        """
        self._future: Future[None] = Future()
        self._future.set_running_or_notify_cancel()
        self._work = work
        # A daemon: the bench, which waits for its runs, keeps the program from ending too early.
        Thread(target=self._do, name=name, daemon=True).start()

    def add_callback(self, callback: Callable[[Status], None]) -> None:
        """Call a function with this status when the work is over."""
        self._future.add_done_callback(lambda _future: callback(self))

    def exception(self, timeout: float | None = 0.0) -> BaseException | None:
        """Give what the work raised, or None.

        Args:
            timeout: so many seconds are waited for its end; None waits as long as it takes.

        Raises:
            TimeoutError: it goes on.
        """
        try:
            return self._future.exception(timeout)
        except (NotYet, CancelledError) as error:
            raise TimeoutError("the work goes on") from error

    @property
    def done(self) -> bool:
        """Whether the work is over."""
        return self._future.done()

    @property
    def success(self) -> bool:
        """Whether it is over and has not failed."""
        return self.done and self._future.exception() is None

    def wait(self, timeout: float | None = None) -> None:
        """Wait for the end, outside of a RunEngine, and raise what the work raised."""
        self._future.result(timeout)

    def _do(self) -> None:
        try:
            self._work()
        except BaseException as error:  # noqa: BLE001 - it is told to whoever waits
            self._future.set_exception(error)
        else:
            self._future.set_result(None)

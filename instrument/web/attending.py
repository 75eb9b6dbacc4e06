"""What the thread that holds the bench does while pages look on: it takes up their wishes, one after the other."""

from collections.abc import Callable
from pathlib import Path
from typing import Final, NoReturn

from instrument.live import LiveAnalysis
from instrument.plan import Plan
from instrument.session import Instrument, Run, next_name
from instrument.web.board import Board
from instrument.web.desk import Desk, Wish
from protocols import KinopixError, SafeStateFailed

_POLISH_S: Final = 60.0
_STEP_S: Final = 0.1

STOPPED: Final = "stopped from the page"
"""Why a run ended that was stopped there, as its recording says."""

_LOOK_S: Final = 0.2  # Windows lets no Ctrl-C through while it waits


class RunPage:
    """A run that pages look on, and may stop: in the way of Ctrl-C, from the thread that holds the bench."""

    def __init__(self, board: Board, desk: Desk) -> None:
        """Show runs on a board, and take wishes from a desk."""
        self.board, self.desk = board, desk

    def begins(self, instrument: Instrument, plan: Plan) -> Board:
        """Show bench and plan before a run; give the listener that the run is started with."""
        self.board.prepare()
        self.board.show_bench(instrument)
        self.board.show_plan(plan, instrument.check(plan))
        self.board.say("preparing", offers=())
        return self.board

    def attend(self, run: Run) -> None:
        """Wait for the end of a run, however it ends, and abort it when a page wishes so. ``run.wait`` raises what ended it."""
        board = self.board
        board.show_run(run)
        board.say("recording", offers=("stop",))
        while not run.done:
            wish = self.desk.take(_LOOK_S)
            if wish == "stop" and not run.done:
                board.say("stopping", notice=STOPPED, offers=())
                run.abort(STOPPED)
            elif wish is not None:
                board.say(notice=f"a run goes on: {wish} was not done")
        board.say("the run is over", offers=())


def serve_bench(
    instrument: Instrument, plan: Plan | None, folder: Path, page: RunPage, tell: Callable[[str], object]
) -> NoReturn:
    """Hold a bench for pages to look at, and do what they wish, until somebody presses Ctrl-C.

    Args:
        instrument: the open bench.
        plan: what ``check`` and ``start`` are about; None offers neither.
        folder: where recordings go, ``run-<date>-<time>.h5``.
        page: what is shown, and where wishes are.
        tell: told in a line what was done, for the terminal.

    Raises:
        SafeStateFailed: the bench could not be made safe; all other errors are shown on the page.
        KeyboardInterrupt: after a run that went on was ended.
    """
    bench, board = _Bench(instrument, plan, folder, page), page.board
    board.show_bench(instrument)
    if plan is not None:
        board.show_plan(plan, instrument.check(plan))
    while True:
        board.say("at rest", offers=bench.offers)
        wish = page.desk.take(_LOOK_S)
        if wish is None:
            continue
        try:
            done = bench.grant(wish)
        except SafeStateFailed:
            raise
        except (KinopixError, OSError) as error:
            done = f"{wish}: {error}"
        board.say(notice=done)
        tell(done)


class _Bench:
    """What can be wished for at rest."""

    def __init__(self, instrument: Instrument, plan: Plan | None, folder: Path, page: RunPage) -> None:
        self._instrument, self._plan, self._folder = instrument, plan, folder
        self._page, self._board = page, page.board
        home: tuple[Wish, ...] = ("home",) if "stage" in instrument.devices.by_role else ()
        self.offers: tuple[Wish, ...] = ("check", "start", *home) if plan is not None else home
        """What a page may wish for at rest."""

    def grant(self, wish: Wish) -> str:
        """Do what is wished, and say what was done."""
        if wish == "stop":
            return "nothing goes on that could be stopped"
        if wish not in self.offers:
            return f"{wish} is not offered here"
        return {"check": self._check, "start": self._start, "home": self._home}[wish]()

    def _check(self) -> str:
        plan = self._planned()
        self._board.say("checking the plan", offers=())
        report = self._instrument.check(plan)
        self._board.show_plan(plan, report)
        return "checked: " + ("nothing stands against the run" if report.ok else "the plan cannot be carried out")

    def _start(self) -> str:
        plan, page = self._planned(), self._page
        out = next_name(self._folder)
        board = page.begins(self._instrument, plan)
        try:
            with self._instrument.start(plan, out, listeners=[LiveAnalysis(plan), board]) as run:
                page.attend(run)
                run.wait()
                run.wait_for_listeners(_POLISH_S)
        except SafeStateFailed:
            raise
        except KinopixError as error:
            return "; ".join([str(error), *getattr(error, "__notes__", ())])
        return f"recorded in {out}"

    def _home(self) -> str:
        self._board.say("looking for the stage's origin", offers=("stop",))
        stage, clock = self._instrument.stage, self._instrument.devices.clock
        motion = stage.home()
        while not motion.done and clock.now_s() < stage.stands_by_s:
            clock.sleep_s(_STEP_S)
            if self._page.desk.take(0.0) == "stop":
                self._board.say("stopping", offers=())
                motion.stop()
                break
        motion.wait()  # raises where the stage was stopped on its way
        return f"the stage is at its origin, {stage.position().reported_mm:.4f} mm"

    def _planned(self) -> Plan:
        assert self._plan is not None  # noqa: S101 - offered with a plan alone
        return self._plan

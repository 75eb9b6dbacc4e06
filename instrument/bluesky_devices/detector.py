"""Modulator and counter as one detector that flies: one plan, one run, one file."""

import asyncio
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from bluesky.protocols import (
    Collectable,
    Configurable,
    Flyable,
    Hints,
    Pausable,
    Preparable,
    Reading,
    Stageable,
    Stoppable,
    StreamAsset,
    WritesStreamAssets,
)
from event_model.documents import DataKey

from instrument.bluesky_devices.audit import KinopixAudit
from instrument.bluesky_devices.documents import Rows, configuration, values_key
from instrument.bluesky_devices.named import Named
from instrument.bluesky_devices.status import WorkStatus
from instrument.plan import Plan
from instrument.session import FinishedEvent, Instrument, PhaseEvent, Run, RunAborted
from protocols import WrongState


class KinopixDetector(
    Named, Flyable, Preparable, Collectable, WritesStreamAssets, Configurable[Any], Stageable, Stoppable, Pausable
):
    """What shows patterns and counts, on one bench.

    ``prepare`` with a plan checks everything, and moves nothing. ``kickoff`` begins the run, which moves the stage where the plan
    has a motion, and is done when the counter is armed. ``complete`` is done when the run is over: devices at rest, file closed.
    ``collect`` tells of the values at any time, as far as they are in the file; which of the frames to trust is known at the end,
    and told by ``audit``. A run is timed by hardware and cannot stand still: ``pause`` breaks it off, makes the
    bench safe and keeps what was counted in its file; after ``resume`` the RunEngine repeats the run from its checkpoint, in a
    new one.
    """

    def __init__(
        self,
        bench: Instrument,
        folder: str | Path | Callable[[], Path],
        name: str = "kinopix",
    ) -> None:
        """Wrap an open bench.

        Args:
            bench: open; whoever opened it closes it.
            folder: of the recordings, which are called ``<name>-0001.h5`` and so on, by the next number that is free; or a
                function that gives the path of each.
            name: of the device in documents.
        """
        super().__init__(name)
        self.audit = KinopixAudit(self, lambda: self._run)
        """Tells which frames are valid, in a stream of its own, when a run is over."""
        self._bench = bench
        self._next = folder if callable(folder) else _numbered(Path(folder), name)
        self._plan: Plan | None = None
        self._run: Run | None = None
        self._broken_off_well = False
        self._values: Rows | None = None  # of the last run, from its first frame on
        self._since = time.time()

    @property
    def hints(self) -> Hints:
        """Nothing of it is drawn by itself."""
        return {"fields": []}

    @property
    def run(self) -> Run | None:
        """Handle of the run that goes on, or of the last one; None before the first."""
        return self._run

    def prepare(self, value: Plan | Mapping[str, Any]) -> WorkStatus:
        """Take a plan for the next ``kickoff``, after every check; nothing moves.

        Args:
            value: the plan, or its tables as plan.toml has them, as a queue server sends them.

        Raises:
            WrongState: a run goes on.
        """
        self._refuse_while_running("prepare")

        def check() -> None:
            plan = value if isinstance(value, Plan) else Plan.model_validate(value)
            self._bench.check(plan).passed()
            self._plan, self._since = plan, time.time()

        return WorkStatus(check, f"{self.name}-prepare")

    def kickoff(self) -> WorkStatus:
        """Begin a run of the plan; done when the counter is armed. It may be repeated: each run has a file of its own.

        Raises:
            WrongState: a run goes on, or no plan was prepared.
            PlanError: the bench cannot carry it out any more.
        """
        self._refuse_while_running("kickoff")
        plan = self._prepared()
        run = self._run = self._bench.start(plan, self._next())
        self._broken_off_well, self._values = False, None

        def armed() -> None:
            for event in run.events():
                if isinstance(event, PhaseEvent) and event.phase in {"running up", "counting", "coming to rest"}:
                    return
                if isinstance(event, FinishedEvent):
                    self._wait(run)

        return WorkStatus(armed, f"{self.name}-kickoff")

    def complete(self) -> WorkStatus:
        """Wait for the end of the run. The status fails as the run does: a lost sync edge, a device, an abort.

        Raises:
            WrongState: no run was begun.
        """
        run = self._run
        if run is None:
            raise _wrong_order(self.name, "complete", "kickoff")
        return WorkStatus(lambda: self._wait(run), f"{self.name}-complete")

    def describe_collect(self) -> dict[str, DataKey]:
        """Say what ``collect`` tells of: the values of each frame, in the file.

        Raises:
            WrongState: no plan was prepared.
        """
        return values_key(self._key, self._prepared())

    def get_index(self) -> int:
        """Give the number of frames that can be read: whole ones while the run goes on; all when its file is closed."""
        run = self._run
        if run is None:
            return 0
        if run.done:
            return 0 if run.recording is None else len(run.recording)
        return 0 if run.written is None else run.written.frames

    def collect_asset_docs(self, index: int | None = None) -> Iterator[StreamAsset]:
        """Tell of the frames that have come into the file since it was told of last; it can be read while it is written (SWMR).

        Args:
            index: frames that all detectors of a stream have; None for all.
        """
        run, frames = self._run, self.get_index()
        if run is None or not frames:
            return
        if self._values is None:
            path = run.written.path if run.written is not None else Path(run.snapshot.path)
            self._values = Rows.of_values(self._key, path, self._prepared())
        yield from self._values.up_to(frames if index is None else min(index, frames))

    @property
    def _key(self) -> str:
        return f"{self.name}-values"

    def read_configuration(self) -> dict[str, Reading[Any]]:
        """Tell what tells runs apart: scheme, frames, rate, motion."""
        readings, _ = configuration(self.name, self._prepared())
        return {key: {**reading, "timestamp": self._since} for key, reading in readings.items()}

    def describe_configuration(self) -> dict[str, DataKey]:
        """Say what ``read_configuration`` gives."""
        _, keys = configuration(self.name, self._prepared())
        return keys

    def stage(self) -> list[Any]:
        """Nothing is to be made ready; a plan that stages the detector has it made safe at its end."""
        return [self]

    def unstage(self) -> WorkStatus:
        """Break off a run that goes on, and wait until the bench is safe."""
        return WorkStatus(lambda: self._break_off("the plan has ended"), f"{self.name}-unstage")

    async def stop(self, success: bool = True) -> None:  # noqa: FBT001, FBT002 - as bluesky calls it
        """Break off a run that goes on; when this returns the bench is safe and the file is closed.

        Args:
            success: whether the run counts as well done; otherwise its status fails.
        """
        self._broken_off_well = success
        await asyncio.to_thread(self._break_off, "the plan was stopped")

    async def pause(self) -> None:
        """Break off a run that goes on; when this returns the bench is safe and the file is closed."""
        self._broken_off_well = True
        await asyncio.to_thread(self._break_off, "the plan was paused")

    def resume(self) -> None:
        """The RunEngine repeats what came after its checkpoint."""

    def _break_off(self, why: str) -> None:
        run = self._run
        if run is not None and not run.done:
            run.settle(why)

    def _wait(self, run: Run) -> None:
        try:
            run.wait()
        except RunAborted:
            if not self._broken_off_well:
                raise

    def _prepared(self) -> Plan:
        if self._plan is None:
            raise _wrong_order(self.name, "kickoff", "prepare")
        return self._plan

    def _refuse_while_running(self, what: str) -> None:
        if self._run is not None and not self._run.done:
            raise WrongState(
                device=self.name,
                saw=f"{what} while a run is {self._run.state}",
                expected="the end of that run",
                remedy="wait for complete, or stop the detector",
            )


def _wrong_order(name: str, what: str, before: str) -> WrongState:
    return WrongState(
        device=name,
        saw=f"{what} without {before}",
        expected="prepare with a plan, then kickoff, then complete",
        remedy="use the plan instrument.bluesky_devices.record, or keep its order",
    )


def _numbered(folder: Path, name: str) -> Callable[[], Path]:
    """Give a function that gives the next path in a folder that is free."""

    def free() -> Path:
        folder.mkdir(parents=True, exist_ok=True)
        number = 1
        while (path := folder / f"{name}-{number:04d}.h5").exists():
            number += 1
        return path

    return free

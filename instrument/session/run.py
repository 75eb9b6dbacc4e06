"""The handle of a run that goes on."""

import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from threading import Lock, Thread
from types import TracebackType
from typing import Final, Never, Self

from instrument.recording import Recording
from instrument.session.aborting import AbortRequest
from instrument.session.bell import Bell
from instrument.session.channel import GRACE_S, Channel, Listener, Subscription
from instrument.session.errors import RunAborted, RunNotOver
from instrument.session.events import Event, FinishedEvent
from instrument.session.feed import MAX_PATTERNS, Feed
from instrument.session.safety import stop_at_once
from instrument.session.snapshot import RunState, Snapshot
from instrument.session.work import Ending, Job, carry_out
from instrument.storage import RecordingWriter, open_recording
from protocols import InputError, SafeStateFailed

SETTLE_S: Final = 10.0
"""So long further interrupts are put off while an interrupted run makes the bench safe and closes its file."""

_LOOK_S: Final = 0.2  # Windows lets no Ctrl-C through while it waits


@dataclass(frozen=True)
class Written:
    """How much of a recording is in its file."""

    path: Path
    """The file."""

    frames: int
    """Whole frames in it; there are never fewer later."""


class Run:
    """A run, from its start to its end, for any thread. ``Instrument.start`` gives it.

    The run itself goes on in a thread of its own. As a context manager it aborts a run that is not over when the block is left,
    waits for its end, and adds to the error that left the block what is kept.
    """

    def __init__(self, job: Job, listeners: tuple[Listener, ...] = ()) -> None:
        """Prepare; ``begin`` begins. Everything must be checked already."""
        self._job = job
        self._snapshot = Snapshot(patterns_total=job.sequence.n_patterns, path=str(job.path))
        self._channel = Channel(self._take_note)
        self._abort = AbortRequest(lambda: stop_at_once(job.devices, job.on_abort))
        self._ending: Ending | None = None
        self._is_over = False
        self._over = Bell()
        self._reading = Lock()
        self._recording: Recording | None = None
        self._writer: RecordingWriter | None = None
        for listener in listeners:
            self._channel.subscribe(listener)
        # Not a daemon: the program does not end before the bench is safe.
        self._thread = Thread(target=self._work, name="kinopix-run")

    def begin(self) -> None:
        """Begin to carry out the plan, once."""
        self._thread.start()

    @property
    def state(self) -> RunState:
        """What the run is about, coarsely; ``snapshot.phase`` says it finely."""
        return self._snapshot.state

    @property
    def done(self) -> bool:
        """Whether the run is over, however it ended: the devices are at rest and the file is closed."""
        return self._is_over or self._thread.ident is None

    @property
    def snapshot(self) -> Snapshot:
        """Where the run stands."""
        return self._snapshot.model_copy(
            update={
                "listener_failures": self._channel.failures,
                "blocks_dropped": self._channel.blocks_dropped,
            }
        )

    @property
    def written(self) -> Written | None:
        """What others can read of the recording by now, in this process and any other; None before its first block."""
        writer = self._writer
        return Written(writer.path, writer.frames) if writer is not None and writer.frames else None

    @property
    def recording(self) -> Recording | None:
        """The recording, whole or partial; None before the end, or where nothing was kept.

        Raises:
            InputError: the file has gone, or is damaged.
        """
        ending = self._ending
        if ending is None or ending.path is None:
            return None
        with self._reading:
            if self._recording is None:
                self._recording = open_recording(ending.path)
            return self._recording

    def wait(self, timeout_s: float | None = None, **unknown: Never) -> Recording:
        """Wait for the end and give the recording.

        Args:
            timeout_s: by the host's clock; None waits as long as it takes.
            unknown: there are no others, and who writes ``timeout`` is told.

        Raises:
            InputError: another argument, or a ``timeout_s`` that is no number.
            RunNotOver: a ``TimeoutError``: the run goes on.
            RunAborted: somebody aborted it. The notes say what is kept, as with every error here.
            SafeStateFailed: names each device that could not be made safe.
            KinopixError: what else ended the run early.
        """
        _refuse_unknown(timeout_s, unknown)
        if not self._wait_over(timeout_s):
            now = self._snapshot
            raise RunNotOver(
                waited_s=timeout_s or 0.0,
                state=now.state,
                patterns_done=now.patterns_done,
                patterns_total=now.patterns_total,
            )
        if self._ending is not None and self._ending.error is not None:
            raise self._ending.error
        recording = self.recording
        if recording is None:  # a good run has recorded all its patterns
            raise RunAborted("nothing was recorded")
        return recording

    def abort(self, why: str = "abort() was called") -> None:
        """End the run early and return at once; ``wait`` then raises ``RunAborted``. From any thread, any number of times.

        Stage and modulator are stopped before this returns (a stage with ``on_abort = "hold"`` is let go on). The run's thread
        disarms the counter, makes everything safe, and closes the file as a partial recording. A run that is over, or about to
        be, ends as it would have.

        Args:
            why: kept in the recording.
        """
        self._abort.ask(why)

    def events(self) -> Feed:
        """Give all events from now on, to iterate over; the finished event is the last. Whoever comes late gets that one."""
        return self._channel.feed()

    def subscribe(self, listener: Listener, *, max_patterns: int = MAX_PATTERNS) -> Subscription:
        """Tell one more listener of all events from now on, on a thread of its own.

        Args:
            listener: a function, or a ``Follower``.
            max_patterns: how many patterns may wait for it; beyond, the oldest blocks are dropped and counted.
        """
        return self._channel.subscribe(listener, max_patterns=max_patterns)

    def wait_for_listeners(self, timeout_s: float | None = None) -> bool:
        """Wait until the listeners of a run that is over have taken everything, and tell whether they have."""
        return self._channel.join(timeout_s)

    def settle(self, why: str) -> str:
        """Abort the run unless it is over, wait until the bench is safe, and say what is kept.

        Interrupts (Ctrl-C) are put off meanwhile, for ``SETTLE_S`` at most: a second one must not leave the bench half safe.
        """
        end_s = time.monotonic() + SETTLE_S
        while True:
            try:
                self.abort(why)
                self._wait_over(None)
                self._channel.join(GRACE_S)
            except KeyboardInterrupt:
                if time.monotonic() > end_s:
                    raise
            else:
                return self._ending.kept if self._ending is not None else ""

    def __enter__(self) -> Self:
        """Give the run."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Let no run go on behind the block's back, and give listeners a moment to take what is left."""
        kept = self.settle("Ctrl-C" if isinstance(error, KeyboardInterrupt) else "its block was left")
        ended_by = None if self._ending is None else self._ending.error
        if error is None or error is ended_by:
            return
        if isinstance(ended_by, SafeStateFailed):
            raise ended_by from error
        error.add_note(kept)

    def _wait_over(self, timeout_s: float | None) -> bool:
        end_s = None if timeout_s is None else time.monotonic() + timeout_s
        while not self.done:
            left_s = _LOOK_S if end_s is None else min(_LOOK_S, end_s - time.monotonic())
            if left_s <= 0:
                return False
            self._over.wait(left_s)
        self._over.ring()  # for others who wait
        return True

    def _take_note(self, event: Event) -> None:
        self._snapshot = self._snapshot.after(event)

    def _begin_file(self, writer: RecordingWriter) -> None:
        self._writer = writer

    def _work(self) -> None:
        try:
            ending = carry_out(self._job, self._channel.publish, self._abort, self._begin_file)
        except BaseException as error:  # noqa: BLE001 - a mistake of ours; whoever waits must be told, whatever it is
            self._abort.close()
            stop_at_once(self._job.devices)
            ending = Ending(error, "nothing is known of what was recorded")
        self._ending = ending
        self._channel.publish(self._finished(ending))
        self._is_over = True
        self._over.ring()

    def _finished(self, ending: Ending) -> FinishedEvent:
        error = ending.error
        failures = tuple(f"{f.listener} ended early: {f.error}" for f in self._channel.failures)
        dropped = self._channel.blocks_dropped
        return FinishedEvent(
            outcome="done" if error is None else "aborted" if isinstance(error, RunAborted) else "failed",
            path=None if ending.path is None else str(ending.path),
            verdict=None if ending.report is None else ending.report.verdict,
            error=None if error is None else str(error) or type(error).__name__,
            notes=(ending.kept, *failures, *([f"listeners missed {dropped} blocks"] if dropped else [])),
        )


def _refuse_unknown(timeout_s: object, unknown: Mapping[str, object]) -> None:
    asked = ", ".join(f"{name}={value!r}" for name, value in unknown.items())
    number = isinstance(timeout_s, int | float) and not isinstance(timeout_s, bool)
    if unknown or not (timeout_s is None or number):
        raise InputError(
            saw=f"wait({asked or repr(timeout_s)})",
            expected="seconds by the name of timeout_s, or nothing",
            remedy="call wait(timeout_s=10.0), or wait() for as long as it takes",
        )

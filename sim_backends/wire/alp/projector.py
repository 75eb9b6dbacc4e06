"""What the board projects: from a sequence to pictures and edges on the optical bench, and how far it has come."""

import math
from collections import deque
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from protocols import Bytes, Integers
from sim_backends.bench import OpticalBench, Projection
from sim_backends.wire.alp.codes import (
    FLUT_NONE,
    LEVEL_HIGH,
    LEVEL_LOW,
    PROJ_ACTIVE,
    PROJ_IDLE,
    SEQUENCE_QUEUE,
    SLAVE,
    Code,
    Proj,
    Seq,
    require,
)
from sim_backends.wire.alp.flut import FrameTable, hold, repeat, within
from sim_backends.wire.alp.planes import Geometry, View, mirrors_of
from sim_backends.wire.alp.sequence import Sequence
from sim_backends.wire.alp.settings import AlpEmulatorSettings, LostFrames, WrongRows


@dataclass(frozen=True)
class Running:
    """A projection under way."""

    queue_id: int
    sequence_id: int
    sequence: Sequence
    picture_s: float
    start_s: float
    end_s: float
    pictures: int
    """Number of pictures in one iteration."""
    iterations: int | None
    """Number of iterations; None: endless."""
    aborted: bool = False
    """Whether ``end_s`` was brought forward."""


@dataclass(frozen=True)
class Waiting:
    """A sequence that begins when those before it have ended."""

    sequence_id: int
    sequence: Sequence
    endless: bool


class Projector:
    """Master of the pictures: starts, counts down, halts."""

    def __init__(self, settings: AlpEmulatorSettings, bench: OpticalBench, geometry: Geometry) -> None:
        """Begin idle and dark."""
        self._settings = settings
        self._bench = bench
        self._geometry = geometry
        self._waiting: deque[Waiting] = deque()
        self._queue_ids = 0
        self._polarity = LEVEL_HIGH
        self._projection: Projection | None = None
        self.table = FrameTable(settings)
        self.controls: dict[int, int] = {
            Proj.MODE: 2301,
            Proj.INVERSION: 0,
            Proj.UPSIDE_DOWN: 0,
            Proj.LEFT_RIGHT_FLIP: 0,
            Proj.QUEUE_MODE: 0,
            Proj.WAIT_UNTIL: 0,
            Proj.STEP: 0,
        }
        self.running: Running | None = None

    def settle(self) -> None:
        """Take note of what has ended by now, and start what waited for it."""
        while self.running is not None and self._bench.clock.now_s() >= self.end_s:
            ended, self.running = self.running, None
            if self._waiting:
                self._begin(self._waiting.popleft(), ended.end_s)

    @property
    def end_s(self) -> float:
        """When the running projection is over: infinite for an endless or a stalled one, the past for none."""
        running = self.running
        if running is None:
            return -math.inf
        stalled = self._bench.shown_until_s == math.inf and not running.aborted
        return math.inf if stalled else running.end_s

    def uses(self, sequence: Sequence) -> bool:
        """Whether the sequence is shown, or waits for it."""
        shown = self.running is not None and self.running.sequence is sequence
        return shown or any(waiting.sequence is sequence for waiting in self._waiting)

    def start(self, sequence_id: int, sequence: Sequence, synch_polarity: int, *, endless: bool) -> None:
        """AlpProjStart or AlpProjStartCont: at once, or after the running one.

        In legacy mode there is one waiting position, which the last start takes, and an endless projection ends after its
        running iteration when something waits for it. In queue mode all wait in order, an endless one until it is aborted.

        Raises:
            Refused: grey values, which the optical bench cannot show (1021); a full queue.
        """
        require(sequence.mode.bits == 1, Code.CONFIG_MISMATCH)
        self._polarity = synch_polarity
        starting = Waiting(sequence_id, sequence, endless)
        if self.running is None:
            self._begin(starting, None)
        elif self._queues:
            require(len(self._waiting) < self._positions, self._settings.full_queue_code)
            self._waiting.append(starting)
        else:
            self._waiting.clear()
            self._waiting.append(starting)
            if self.running.iterations is None:
                self._end_after(self.running.pictures)

    @property
    def _queues(self) -> bool:
        return self.controls[Proj.QUEUE_MODE] == SEQUENCE_QUEUE

    @property
    def _positions(self) -> int:
        return self._settings.queue_positions if self._queues else 1

    def _begin(self, starting: Waiting, edge_s: float | None) -> None:
        sequence_id, sequence, endless = starting.sequence_id, starting.sequence, starting.endless
        settings, timing = self._settings, sequence.timing
        first_edge_s = self._bench.clock.now_s() + settings.start_latency_us * 1e-6 if edge_s is None else edge_s
        picture_s, order = timing.picture_us * 1e-6, self._order(sequence)
        iterations = None if endless else sequence.controls[Seq.REPEAT]
        duration_s = math.inf if iterations is None else iterations * len(order) * picture_s
        self._queue_ids += 1
        start_s = first_edge_s + timing.synch_delay_us * 1e-6
        if self.controls[Proj.MODE] == SLAVE:
            # Nothing is connected to the trigger input of this bench, so the first picture never comes.
            self._bench.dark()
            self._projection = None
            duration_s = math.inf
        else:
            many = settings.endless_pictures if iterations is None else iterations
            self._show(sequence, repeat(order, many, settings.endless_pictures), start_s, picture_s)
        self.running = Running(
            self._queue_ids, sequence_id, sequence, picture_s, start_s, start_s + duration_s, len(order), iterations
        )

    def _order(self, sequence: Sequence) -> Integers:
        """Planes of one iteration."""
        controls = sequence.controls
        if controls[Seq.FLUT_MODE] == FLUT_NONE:
            pictures = np.arange(controls[Seq.FIRSTFRAME], controls[Seq.LASTFRAME] + 1)
        else:
            pictures = self.table.order(
                controls[Seq.FLUT_MODE], controls[Seq.FLUT_OFFSET9], controls[Seq.FLUT_ENTRIES9]
            )
        return within(pictures, sequence.pictures, sequence.bit_planes)

    def _show(self, sequence: Sequence, order: Integers, start_s: float, picture_s: float) -> None:
        settings, timing = self._settings, sequence.timing
        if settings.first_synch == "extra":
            order, start_s = np.concatenate([[-1], order]), start_s - picture_s
        elif settings.first_synch == "missing":
            # A counter that has seen no edge counts nothing, so picture 0 may as well not be shown.
            order, start_s = order[1:], start_s + picture_s
        silent = self._lost(len(order), "pass")
        # On an active-low line the edge that rises is the end of the pulse.
        late_us = timing.synch_pulse_us if self._polarity == LEVEL_LOW else 0
        self._projection = Projection(
            start_s=start_s,
            picture_time_s=picture_s,
            mirrors=mirrors_of(tuple(sequence.planes), self._geometry, self._view(sequence), self._empty()),
            play_order=np.delete(hold(order, silent), self._lost(len(order), "close-up")),
            sync_delay_s=(timing.synch_delay_us - late_us) * 1e-6,
            silent=silent,
        )
        self._bench.show(self._projection)

    def _lost(self, pictures: int, slots: Literal["pass", "close-up"]) -> tuple[int, ...]:
        """Places of the lost pictures of one kind."""
        faults = [fault for fault in self._settings.faults if isinstance(fault, LostFrames) and fault.slots == slots]
        return tuple(k for fault in faults for k in range(fault.first, min(fault.first + fault.count, pictures)))

    def _view(self, sequence: Sequence) -> View:
        controls, lines = self.controls, sequence.lines
        return View(
            inverted=controls[Proj.INVERSION] != 0,
            upside_down=controls[Proj.UPSIDE_DOWN] != 0,
            mirrored=controls[Proj.LEFT_RIGHT_FLIP] != 0,
            lines=None if lines == (0, self._geometry.rows) else lines,
            shift_rows=sum(fault.rows for fault in self._settings.faults if isinstance(fault, WrongRows)),
        )

    def _empty(self) -> Bytes:
        value = 0x00 if self._settings.uploads_cleared else 0xAA
        return np.full((self._geometry.rows, self._geometry.columns // 8), value, np.uint8)

    def wait(self) -> None:
        """AlpProjWait: let time pass until the projection is over.

        Raises:
            Refused: an endless projection (1005), or one that did not end in ``patience_s`` (1999).
        """
        clock = self._bench.clock
        give_up_s = clock.now_s() + self._settings.patience_s
        while (running := self.running) is not None:
            require(running.iterations is not None)
            require(clock.now_s() < give_up_s, Code.ERROR_UNKNOWN)
            # In short steps, so that a halt from another thread is seen on a clock that really waits.
            clock.advance_to(max(clock.now_s(), min(self.end_s, clock.now_s() + 0.1, give_up_s)))
            self.settle()

    def request_halt(self) -> None:
        """AlpProjHalt: forget what waits, and let the running iteration play to its end."""
        self._waiting.clear()
        if self.controls[Proj.MODE] == SLAVE:
            self.halt()  # without triggers its iteration would never end
        elif self.running is not None:
            self._end_after(self.running.pictures)

    def halt(self) -> None:
        """Show nothing from now on, forget what waits."""
        self._waiting.clear()
        if self.running is not None:
            self.running = None
        self._bench.dark()

    def abort(self, control: int) -> None:
        """ABORT_SEQUENCE, ABORT_FRAME, ABORT_ASYNC: end after the iteration, the picture, or at once."""
        if self.running is None:
            return
        if control == Proj.ABORT_ASYNC:
            self.halt()
            return
        self._end_after(self.running.pictures if control == Proj.ABORT_SEQUENCE else 1)

    def _end_after(self, unit: int) -> None:
        """End the running projection when ``unit`` pictures, or a multiple of them, are over."""
        running, now_s = self.running, self._bench.clock.now_s()
        if running is None:
            return
        begun = math.ceil((now_s - running.start_s) / (unit * running.picture_s))
        shown = unit * max(1, begun)
        end_s = min(running.end_s, running.start_s + shown * running.picture_s)
        self.running = replace(running, end_s=end_s, aborted=True)
        if self._projection is not None:
            # The same pictures and edges again, but no more of them.
            self._bench.show(replace(self._projection, play_order=self._projection.play_order[:shown]))

    def inquire(self, kind: int) -> int:
        """AlpProjInquire.

        Raises:
            Refused: an inquiry that is not known here.
        """
        values = {
            **self.controls,
            Proj.QUEUE_ID: self._queue_ids or 0xFFFFFFFF,
            Proj.QUEUE_MAX_AVAIL: self._positions,
            Proj.QUEUE_AVAIL: self._positions - len(self._waiting),
            Proj.STATE: PROJ_IDLE if self.running is None else PROJ_ACTIVE,
        }
        if self.table.slots:
            values[Proj.FLUT_MAX_ENTRIES9] = self.table.slots
        require(kind in values)
        return values[kind]

    def progress(self) -> tuple[int, ...]:
        """The nine words of tAlpProjProgress; its counters count down (dlp7000.md 3.7)."""
        running, waiting = self.running, len(self._waiting)
        if running is None:
            return (0xFFFFFFFF, 0xFFFFFFFF, waiting, 0, 0, 0, 0, 0, 1)
        elapsed_s = max(0.0, self._bench.clock.now_s() - running.start_s)
        if self.controls[Proj.MODE] == SLAVE:
            elapsed_s = 0.0
        iteration, picture = divmod(int(elapsed_s / running.picture_s), running.pictures)
        left = 0 if running.iterations is None else max(0, running.iterations - iteration)
        flags = 4 if running.iterations is None else 0
        time_us = round(running.picture_s * 1e6)
        ids = (running.queue_id, running.sequence_id)
        return (*ids, waiting, left, 0, running.pictures - picture, time_us, running.pictures, flags)

    def forget_waiting(self) -> None:
        """ALP_PROJ_RESET_QUEUE: the running one is not affected."""
        self._waiting.clear()

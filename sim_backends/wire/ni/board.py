"""The board and its driver behind the remote calls: tasks, reservations, waits on the bench's clock, and faults."""

import math
import threading
from collections import Counter

import numpy as np
from numpy.typing import NDArray

from sim_backends.bench import OpticalBench
from sim_backends.wire.ni import constants as c
from sim_backends.wire.ni.acquisition import Acquisition
from sim_backends.wire.ni.errors import (
    ABORTED,
    ATTRIBUTE_NOT_SUPPORTED,
    DUPLICATE_TASK,
    INVALID_ATTRIBUTE_VALUE,
    INVALID_DEVICE_ID,
    INVALID_TASK,
    RESOURCE_RESERVED,
    SAMPLES_NO_LONGER_AVAILABLE,
    SAMPLES_NOT_YET_AVAILABLE,
    SAMPLES_WILL_NEVER_BE_AVAILABLE,
    WAIT_IS_OVER,
    NiError,
    ServerGone,
)
from sim_backends.wire.ni.settings import BUSES, CallFault, Held, NiEmulatorSettings, ShortRead
from sim_backends.wire.ni.task import EveryN, State, Task, Value
from sim_backends.wire.ni.terminals import Terminals

Samples = NDArray[np.uint32]

_STILL_ALLOWED = ("ClearTask", "UnregisterEveryNSamplesEvent", "GetErrorString", "GetSystemInfoAttributeUInt32")


class EmulatedNiBoard:
    """NI-DAQmx with one or more X-series boards of one kind. Safe to call from many threads."""

    def __init__(self, settings: NiEmulatorSettings, bench: OpticalBench) -> None:
        self.settings = settings
        self._bench = bench
        self._lock = threading.RLock()
        self._terminals = Terminals(settings)
        self._tasks: dict[str, Task] = {}
        self._holders: dict[str, str] = {}
        self._calls: Counter[str] = Counter()
        self._gone_code = 0
        self._server_gone = False
        self._unnamed = 0

    def called(self, rpc: str) -> None:
        """Note a call before it is carried out, and let it fail or be late where a fault says so.

        Raises:
            NiError: the call fails.
            ServerGone: nobody is there.
        """
        with self._lock:
            self._calls[rpc] += 1
            nth = self._calls[rpc]
            if self._server_gone:
                raise ServerGone
            if self._gone_code and rpc not in _STILL_ALLOWED:
                raise NiError(self._gone_code)
        for fault in self.settings.faults:
            if isinstance(fault, CallFault) and (fault.rpc, fault.nth) == (rpc, nth):
                self._bench.clock.sleep_s(fault.delay_s)
                if fault.code:
                    raise NiError(fault.code)

    # Queries

    def system(self, attribute: int) -> Value:
        """Tell a system attribute."""
        major, minor, update = self.settings.driver_version
        told: dict[int, Value] = {
            c.SYS_MAJOR: major,
            c.SYS_MINOR: minor,
            c.SYS_UPDATE: update,
            c.SYS_DEVICES: ", ".join(self.settings.devices),
        }
        if attribute not in told:
            raise NiError(ATTRIBUTE_NOT_SUPPORTED)
        return told[attribute]

    def device(self, name: str, attribute: int) -> Value | tuple[int, ...]:
        """Tell a device attribute."""
        if name not in self.settings.devices:
            raise NiError(INVALID_DEVICE_ID)
        settings = self.settings
        arm_start = c.TRIG_ARM_START_BIT if settings.arm_start_supported else 0
        told: dict[int, Value | tuple[int, ...]] = {
            c.DEV_PRODUCT_TYPE: settings.product_type,
            c.DEV_SERIAL: 0x01E240 + settings.devices.index(name),
            c.DEV_IS_SIMULATED: settings.is_simulated,
            c.DEV_SAMP_CLK: settings.ci_samp_clk_supported,
            c.DEV_MAX_SIZE: settings.ci_max_size,
            c.DEV_MAX_TIMEBASE: settings.ci_max_timebase_hz,
            c.DEV_TRIG_USAGE: c.TRIG_PAUSE_BIT | arm_start,
            c.DEV_MEAS_TYPES: (c.COUNT_EDGES,),
            c.DEV_SAMP_MODES: (c.FINITE, c.CONTINUOUS),
            c.DEV_TERMINALS: ", ".join(self._terminals.of(name)),
            c.DEV_BUS_TYPE: BUSES[settings.bus][0],
            c.DEV_CATEGORY: settings.product_category,
            c.DEV_NUMBER: settings.product_number,
            c.DEV_CI_CHANNELS: ", ".join(self._terminals.counters(name)),
        }
        if attribute not in told:
            raise NiError(ATTRIBUTE_NOT_SUPPORTED)
        return told[attribute]

    # Tasks

    def create(self, name: str) -> str:
        """Make a task and give its name."""
        with self._lock:
            if name in self._tasks:
                raise NiError(DUPLICATE_TASK)
            if not name:
                name = f"_unnamedTask<{self._unnamed}>"
                self._unnamed += 1
            self._tasks[name] = Task(name, self.settings, self._terminals)
            return name

    def _task(self, name: str) -> Task:
        if name not in self._tasks:
            raise NiError(INVALID_TASK)
        return self._tasks[name]

    def add_counter(self, task: str, counter: str, name: str, *, edge: int, initial: int, direction: int) -> None:
        """Give a task its counter."""
        with self._lock:
            device, short = self._terminals.counter(counter)
            self._task(task).add_counter(device, short, name, edge=edge, initial=initial, direction=direction)

    def clock(self, task: str, source: str, rate_hz: float, *, edge: int, mode: int, samples: int) -> None:
        """Give a task its sample clock."""
        with self._lock:
            self._task(task).clock(source, rate_hz, edge=edge, mode=mode, samples=samples)

    def get(self, task: str, group: str, attribute: int) -> Value:
        """Tell an attribute of a task."""
        with self._lock:
            subject = self._look(task)
            return subject.get(group, attribute, self._bench.clock.now_s())

    def set(self, task: str, group: str, attribute: int, value: Value) -> None:
        """Set an attribute of a task."""
        with self._lock:
            self._task(task).set(group, attribute, value)

    def reset(self, task: str, group: str, attribute: int) -> None:
        """Give an attribute of a task its default again."""
        with self._lock:
            self._task(task).reset(group, attribute)

    def control(self, task: str, action: int) -> None:
        """Carry out ``Task.control``.

        Raises:
            NiError: an unknown action, or a configuration or a resource that cannot be had.
        """
        goals: dict[int, State] = {c.TASK_VERIFY: "verified", c.TASK_RESERVE: "reserved", c.TASK_COMMIT: "committed"}
        if action == c.TASK_START:
            self.start(task)
        elif action in (c.TASK_STOP, c.TASK_ABORT, c.TASK_UNRESERVE):
            self.stop(task, wholly=action != c.TASK_STOP)
        elif action in goals:
            with self._lock:
                subject = self._task(task)
                subject.plan()
                if goals[action] != "verified":
                    self._reserve(subject)
                subject.rise(goals[action])
        else:
            raise NiError(INVALID_ATTRIBUTE_VALUE)

    def start(self, task: str) -> None:
        """Start a task; one that runs goes on."""
        with self._lock:
            subject = self._task(task)
            if subject.state == "running":
                return
            plan = subject.plan()
            self._reserve(subject)
            subject.run(Acquisition(self.settings, self._bench, plan, self._bench.clock.now_s()))

    def stop(self, task: str, *, wholly: bool = False) -> None:
        """Stop a task; ``wholly`` lets go of its counter too."""
        with self._lock:
            subject = self._look(task)
            subject.stop()
            if wholly:
                subject.state = "verified" if subject.reaches("verified") else "unverified"
            if not subject.reaches("reserved"):
                self._release(subject)

    def clear(self, task: str) -> None:
        """Forget a task. Allowed in every state."""
        with self._lock:
            subject = self._tasks.pop(task, None)
            if subject is not None:
                subject.end_events()
                self._release(subject)

    def _reserve(self, task: Task) -> None:
        counter = f"{task.device}/{task.counter}"
        for fault in self.settings.faults:
            if isinstance(fault, Held) and fault.counter == task.counter:
                raise NiError(fault.code)
        if self._holders.setdefault(counter, task.name) != task.name:
            raise NiError(RESOURCE_RESERVED)

    def _release(self, task: Task) -> None:
        self._holders = {counter: holder for counter, holder in self._holders.items() if holder != task.name}

    # Samples

    def _look(self, name: str) -> Task:
        """Give a task that knows what happened until now; one that finds the board gone says so."""
        task = self._task(name)
        task.look(self._bench.clock.now_s())
        broken = task.acquisition.broken if task.acquisition else None
        if broken and broken.gone == "board":
            self._gone_code = broken.code
        if broken and broken.gone == "server":
            self._server_gone = True
            for each in self._tasks.values():
                each.end_events()
        return task

    def _deadline_s(self, timeout_s: float) -> float:
        return self._bench.clock.now_s() + (self.settings.patience_s if timeout_s < 0 else timeout_s)

    def _wait(self, name: str, want: float, timeout_s: float) -> Task:
        """Let time pass until ``want`` samples can be read, none will come any more, or the time is over.

        Raises:
            NiError: the task was stopped meanwhile.
        """
        deadline_s, clock = self._deadline_s(timeout_s), self._bench.clock
        while True:
            with self._lock:
                task = self._look(name)
                run = task.acquisition
                if run is None:
                    raise NiError(ABORTED)
                left = math.inf if run.plan.samples is None else run.plan.samples - run.acquired
                missing = min(want - run.available, left)
                if missing <= 0 or run.ended or clock.now_s() >= deadline_s:
                    return task
                # An endless wish is granted sample by sample until the acquisition breaks or the time is over.
                at_s = run.time_of(int(missing), deadline_s) if math.isfinite(missing) else None
            clock.advance_to(deadline_s if at_s is None else at_s)

    def read(self, name: str, n: int, timeout_s: float) -> tuple[Samples, int]:
        """Read ``n`` samples (-1: what READ_ALL_AVAILABLE means), and the status that goes with them.

        Raises:
            NiError: nothing can be read.
            ServerGone: the server dies.
        """
        with self._lock:
            if not self._task(name).buffered:
                return np.array([self.count_now(name)], np.uint32), 0
            self.start(name)
            if n < 0:
                n = self._look(name).all_samples()
        self._wait(name, n, timeout_s)
        with self._lock:
            return self._hand_over(self._task(name), n)

    def _hand_over(self, task: Task, n: int) -> tuple[Samples, int]:
        run = task.acquisition
        if run is None:
            raise NiError(ABORTED)
        if run.overwritten:
            raise NiError(SAMPLES_NO_LONGER_AVAILABLE, manner="metadata")
        held_back = self._short_read(task, run, n)
        if held_back is not None:
            return run.read(held_back), SAMPLES_NOT_YET_AVAILABLE
        if run.available >= n:
            return run.read(n), 0
        if run.broken is not None:
            if run.broken.gone == "server":
                raise ServerGone
            if run.broken.manner == "status":
                return run.read(run.available), run.broken.code
            raise NiError(run.broken.code, manner=run.broken.manner)
        if run.finished:
            raise NiError(SAMPLES_WILL_NEVER_BE_AVAILABLE, manner="metadata")
        return run.read(run.available), SAMPLES_NOT_YET_AVAILABLE

    def _short_read(self, task: Task, run: Acquisition, n: int) -> int | None:
        """How many samples a short read gives, where a fault cuts this one short."""
        for fault in self.settings.faults:
            if (
                isinstance(fault, ShortRead)
                and fault.counter in (None, task.counter)
                and fault.at not in task.short_reads_done
                and 0 <= fault.at - run.position < min(n, run.available)
            ):
                task.short_reads_done.add(fault.at)
                return fault.at - run.position
        return None

    def count_now(self, name: str) -> int:
        """The live register of a task, which is started for it."""
        with self._lock:
            self.start(name)
            return int(self.get(name, "Chan", c.CH_COUNT))

    def is_done(self, name: str) -> bool:
        """Whether a task does not run, or will sample no more."""
        with self._lock:
            run = self._look(name).acquisition
            return run is None or run.ended

    def wait_until_done(self, name: str, timeout_s: float) -> None:
        """Wait for the end of a finite task.

        Raises:
            NiError: it did not end in time, or it broke.
        """
        with self._lock:
            run = self._look(name).acquisition
            if run is None:
                return
            unread = run.available
            left = math.inf if run.plan.samples is None else run.plan.samples - run.acquired
        task = self._wait(name, unread + left, timeout_s)
        run = task.acquisition
        if run is not None and run.broken is not None and run.broken.gone != "server":
            raise NiError(run.broken.code)
        if run is not None and not run.finished:
            raise NiError(WAIT_IS_OVER)

    # Events

    def every_n(self, name: str, n: int) -> EveryN:
        """Wait for each ``n`` samples of a task."""
        with self._lock:
            event = EveryN(n)
            self._task(name).events.append(event)
            return event

    def no_events(self, name: str) -> None:
        """End the event streams of a task."""
        with self._lock:
            if name in self._tasks:
                self._tasks[name].end_events()

    def close(self) -> None:
        """Forget everything."""
        with self._lock:
            for name in list(self._tasks):
                self.clear(name)

"""One DAQmx task: its attributes, its states, and the acquisition that it starts (h10682-daq.md 4.1, 4.2, 4.5)."""

from collections.abc import Callable
from queue import SimpleQueue
from typing import Literal, TypeAlias

from sim_backends.wire.ni import constants as c
from sim_backends.wire.ni.acquisition import Acquisition, Plan
from sim_backends.wire.ni.errors import (
    ATTRIBUTE_NOT_SUPPORTED,
    EXT_SAMP_CLK_SRC_NOT_SPECIFIED,
    INVALID_ATTRIBUTE_VALUE,
    MULTIPLE_COUNTER_INPUT_TASK,
    NO_CHANNELS,
    PAUSE_TRIGGER_AND_SAMPLE_CLOCK,
    TASK_IS_RUNNING,
    NiError,
)
from sim_backends.wire.ni.settings import BUSES, NiEmulatorSettings
from sim_backends.wire.ni.terminals import Terminals

Value: TypeAlias = int | float | bool | str
State: TypeAlias = Literal["unverified", "verified", "reserved", "committed", "running"]
STATES: tuple[State, ...] = ("unverified", "verified", "reserved", "committed", "running")

_FIXED_WHILE_RUNNING = ("Chan", "Timing", "Trig", "Buffer")


class EveryN:
    """A client that waits for each N samples."""

    def __init__(self, n: int) -> None:
        self.n = n
        self.queue: SimpleQueue[bool] = SimpleQueue()

    def grown(self, before: int, now: int) -> None:
        """Tell the client once for each N samples that are complete now."""
        for _ in range(now // self.n - before // self.n):
            self.queue.put(True)

    def close(self) -> None:
        """End the client's stream."""
        self.queue.put(False)


class Task:
    """A task as the driver keeps it. Not safe on its own: the board's lock is held round every call."""

    def __init__(self, name: str, settings: NiEmulatorSettings, terminals: Terminals) -> None:
        self.name = name
        self.state: State = "unverified"
        self.device = ""
        self.counter = ""
        self.channel = ""
        self.acquisition: Acquisition | None = None
        self.events: list[EveryN] = []
        self._settings = settings
        self._terminals = terminals
        self._values: dict[tuple[str, int], Value] = {}
        self._back_to: State = "unverified"
        self.short_reads_done: set[int] = set()

    # Configuration

    def add_counter(self, device: str, counter: str, name: str, *, edge: int, initial: int, direction: int) -> None:
        """Take a counter as the task's channel."""
        if self.counter:
            raise NiError(MULTIPLE_COUNTER_INPUT_TASK)
        if direction not in (c.COUNT_UP, c.COUNT_DOWN):
            raise NiError(INVALID_ATTRIBUTE_VALUE)
        self.device, self.counter = device, counter
        self.channel = name or f"{device}/{counter}"
        self._values |= {
            ("Chan", c.CH_EDGE): edge,
            ("Chan", c.CH_INITIAL): initial,
            ("Chan", c.CH_DIRECTION): direction,
        }

    def clock(self, source: str, rate_hz: float, *, edge: int, mode: int, samples: int) -> None:
        """Take samples on an external clock.

        Raises:
            NiError: the board's counters take no sample clock, or a mode that they do not know.
        """
        self._fixed_while_running("Timing")
        if not self._settings.ci_samp_clk_supported or mode not in (c.FINITE, c.CONTINUOUS) or samples < 1:
            raise NiError(INVALID_ATTRIBUTE_VALUE)
        self._values |= {
            ("Timing", c.TIM_TYPE): c.SAMPLE_CLOCK,
            ("Timing", c.TIM_SOURCE): source,
            ("Timing", c.TIM_RATE): rate_hz,
            ("Timing", c.TIM_EDGE): edge,
            ("Timing", c.TIM_MODE): mode,
            ("Timing", c.TIM_SAMPLES): samples,
        }

    def set(self, group: str, attribute: int, value: Value) -> None:
        """Set an attribute."""
        self._fixed_while_running(group)
        if attribute == c.CH_PRESCALER and ("Chan", c.CH_DUP) not in self._values:
            self._values["Chan", c.CH_DUP] = False
        self._values[group, attribute] = value

    def reset(self, group: str, attribute: int) -> None:
        """Give an attribute its default again."""
        self._fixed_while_running(group)
        self._values.pop((group, attribute), None)

    def _fixed_while_running(self, group: str) -> None:
        if self.state == "running" and group in _FIXED_WHILE_RUNNING:
            raise NiError(TASK_IS_RUNNING)

    # What it tells

    def get(self, group: str, attribute: int, now_s: float) -> Value:
        """Tell an attribute: live, set, or default.

        Raises:
            NiError: one that this task does not have.
        """
        live = self._live(now_s).get((group, attribute))
        if live is not None:
            return live()
        value = self._values.get((group, attribute), self._defaults().get((group, attribute)))
        if value is None:
            raise NiError(ATTRIBUTE_NOT_SUPPORTED)
        return value

    def _live(self, now_s: float) -> dict[tuple[str, int], Callable[[], Value]]:
        run = self.acquisition
        return {
            ("Task", c.TASK_NAME): lambda: self.name,
            ("Task", c.TASK_CHANNELS): lambda: self.channel,
            ("Task", c.TASK_DEVICES): lambda: self.device,
            ("Task", c.TASK_NUM_DEVICES): lambda: int(bool(self.device)),
            ("Task", c.TASK_NUM_CHANS): lambda: int(bool(self.counter)),
            ("Read", c.READ_CHANNELS): lambda: self.channel,
            ("Read", c.READ_NUM_CHANS): lambda: int(bool(self.counter)),
            ("Read", c.READ_AVAILABLE): lambda: run.available if run else 0,
            ("Read", c.READ_TOTAL): lambda: run.acquired if run else 0,
            ("Read", c.READ_POSITION): lambda: run.position if run else 0,
            ("Read", c.READ_DEFAULT_N): self.all_samples,
            ("Chan", c.CH_TYPE): lambda: c.COUNTER_INPUT,
            ("Chan", c.CH_MEAS_TYPE): lambda: c.COUNT_EDGES,
            ("Chan", c.CH_PHYSICAL): lambda: f"{self.device}/{self.counter}",
            ("Chan", c.CH_COUNT): lambda: run.count_now(now_s) if run else self._int("Chan", c.CH_INITIAL),
            ("Chan", c.CH_TC_REACHED): lambda: run.wrapped(now_s) if run else False,
            ("Chan", c.CH_INVALID): lambda: self._settings.possibly_invalid_samples,
        }

    def _defaults(self) -> dict[tuple[str, int], Value]:
        return {
            ("Chan", c.CH_TERM): f"/{self.device}/{self._terminals.default_source(self.counter)}"
            if self.counter
            else "",
            ("Chan", c.CH_DUP): self._settings.dup_count_prevention,
            ("Chan", c.CH_PRESCALER): 1,
            ("Chan", c.CH_FILTER): False,
            ("Chan", c.CH_FILTER_S): 0.0,
            ("Timing", c.TIM_TYPE): c.ON_DEMAND,
            ("Timing", c.TIM_MODE): c.FINITE,
            ("Timing", c.TIM_SAMPLES): 1000,
            ("Timing", c.TIM_RATE): 1000.0,
            ("Timing", c.TIM_SOURCE): "",
            ("Timing", c.TIM_EDGE): c.RISING,
            ("Timing", c.TIM_FILTER): False,
            ("Timing", c.TIM_FILTER_S): 0.0,
            ("Trig", c.ARM_TYPE): c.NO_TRIGGER,
            ("Trig", c.ARM_SOURCE): "",
            ("Trig", c.ARM_EDGE): c.RISING,
            ("Trig", c.PAUSE_TYPE): c.NO_TRIGGER,
            ("Buffer", c.BUF_INPUT): self._default_buffer(),
            ("Chan", c.CH_XFER): BUSES[self._settings.bus][1],
            ("Read", c.READ_OVERWRITE): c.DO_NOT_OVERWRITE,
            ("Read", c.READ_ALL): False,
        }

    def _value(self, group: str, attribute: int) -> Value:
        key = (group, attribute)
        return self._values[key] if key in self._values else self._defaults()[key]

    def _int(self, group: str, attribute: int) -> int:
        return int(self._value(group, attribute))

    def _default_buffer(self) -> int:
        samples = int(self._values.get(("Timing", c.TIM_SAMPLES), 1000))
        if self._values.get(("Timing", c.TIM_MODE), c.FINITE) == c.FINITE:
            return samples
        rate_hz = float(self._values.get(("Timing", c.TIM_RATE), 1000.0))
        usual = next((size for up_to_hz, size in self._settings.default_buffers if rate_hz <= up_to_hz), 1_000_000)
        return max(samples, usual)

    @property
    def buffered(self) -> bool:
        """Whether the task has a sample clock."""
        return ("Timing", c.TIM_TYPE) in self._values

    @property
    def continuous(self) -> bool:
        """Whether the task samples until it is stopped."""
        return self._int("Timing", c.TIM_MODE) == c.CONTINUOUS

    def all_samples(self) -> int:
        """What READ_ALL_AVAILABLE means now: all that were asked for, or all that are there."""
        if self.continuous or bool(self._value("Read", c.READ_ALL)):
            return self.acquisition.available if self.acquisition else 0
        return self._int("Timing", c.TIM_SAMPLES)

    # States

    def plan(self) -> Plan:
        """Check the configuration and say what a start would do.

        Raises:
            NiError: what is wrong with it.
        """
        if not self.counter:
            raise NiError(NO_CHANNELS)
        source = self._terminal("Chan", c.CH_TERM)
        paused = self._value("Trig", c.PAUSE_TYPE) != c.NO_TRIGGER
        if self.buffered and paused:
            raise NiError(PAUSE_TRIGGER_AND_SAMPLE_CLOCK)
        initial = self._int("Chan", c.CH_INITIAL)
        finite = self.buffered and not self.continuous
        return Plan(
            counter=self.counter,
            tick_hz=self._terminals.timebases_hz.get(source),
            photons=self._terminals.is_line(source, self._settings.photon_line) and self._pulse_passes(),
            clocked=self.buffered and self._clock_passes(),
            arm=self._arming(),
            initial=initial,
            down=self._value("Chan", c.CH_DIRECTION) == c.COUNT_DOWN,
            keeps_duplicates=bool(self._value("Chan", c.CH_DUP)),
            samples=self._int("Timing", c.TIM_SAMPLES) if finite else None,
            capacity=self._int("Buffer", c.BUF_INPUT),
            overwrite=self._value("Read", c.READ_OVERWRITE) == c.OVERWRITE,
        )

    def _terminal(self, group: str, attribute: int) -> str:
        return self._terminals.resolve(str(self._value(group, attribute)), self.device)

    def _pulse_passes(self) -> bool:
        """Whether the source counts a pulse as narrow as the head's, with the input filter that is set."""
        settings, least_s = self._settings, self._settings.min_source_pulse_s
        if self._value("Chan", c.CH_FILTER):
            least_s = max(least_s, float(self._value("Chan", c.CH_FILTER_S)))
        return settings.photon_pulse_s >= least_s

    def _clock_passes(self) -> bool:
        """Whether the modulator's edges reach the sample clock."""
        if (
            not str(self._value("Timing", c.TIM_SOURCE)).strip()
            or self._value("Timing", c.TIM_SOURCE) == "OnboardClock"
        ):
            raise NiError(EXT_SAMP_CLK_SRC_NOT_SPECIFIED)
        line = self._terminal("Timing", c.TIM_SOURCE)
        filtered_s = float(self._value("Timing", c.TIM_FILTER_S)) if self._value("Timing", c.TIM_FILTER) else 0.0
        return self._terminals.is_line(line, self._settings.sync_line) and filtered_s <= self._settings.sync_pulse_s

    def _arming(self) -> Literal["now", "edge", "sequence", "never"]:
        if self._value("Trig", c.ARM_TYPE) == c.NO_TRIGGER:
            return "now"
        if not self._settings.arm_start_supported or self._value("Trig", c.ARM_TYPE) != c.DIGITAL_EDGE:
            raise NiError(INVALID_ATTRIBUTE_VALUE)
        line = self._terminal("Trig", c.ARM_SOURCE)
        if self._settings.start_line is not None and self._terminals.is_line(line, self._settings.start_line):
            return "sequence"
        return "edge" if self._terminals.is_line(line, self._settings.sync_line) else "never"

    def reaches(self, state: State) -> bool:
        """Whether the task is in ``state`` or beyond."""
        return STATES.index(self.state) >= STATES.index(state)

    def rise(self, state: State) -> None:
        """Go up to ``state``, never down."""
        if not self.reaches(state):
            self.state = state

    def run(self, acquisition: Acquisition) -> None:
        """Go to the running state."""
        self._back_to = "verified" if self.state == "unverified" else self.state
        self.acquisition = acquisition
        self.short_reads_done.clear()
        self.state = "running"

    def stop(self) -> None:
        """Go back to where the task was before it started; its samples are gone."""
        if self.state == "running":
            self.state = self._back_to
            self.acquisition = None

    def look(self, now_s: float) -> None:
        """Take in what happened until now, and tell those who wait for samples."""
        if self.acquisition is not None:
            before = self.acquisition.acquired
            self.acquisition.look(now_s)
            for event in self.events:
                event.grown(before, self.acquisition.acquired)

    def end_events(self) -> None:
        """Close every event stream."""
        for event in self.events:
            event.close()
        self.events.clear()

"""Walks through states, actions, faults and interrupts, chosen by Hypothesis: however a session goes, it ends safe.

A walk is a bench with a fault, or none, and a few actions on it, some of which begin a run that is aborted, interrupted or
meddled with at some event. All time is virtual. At the end of each walk the stage stands, the modulator shows nothing, the
counter is disarmed, and every file is a recording that can be read, or is not there.
"""

import os
import signal
import tempfile
from collections.abc import Callable, Generator
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any, Final

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from instrument.config import BenchConfig, bench_of_tables
from instrument.plan import MotionPlan, Plan
from instrument.session import Event, Instrument
from instrument.storage import open_recording
from protocols import CounterRun, KinopixError, MotionProfile, WrongState

IN_MEMORY: Final = "/dev/shm" if os.path.isdir("/dev/shm") else None  # noqa: PTH112 - a folder of its own is made there
"""Where walks record: no claim is about the disk, which is synced several times a walk."""

PLAN = Plan(
    frames=4,
    image_size=8,
    pattern_rate_hz=1000,
    motion=MotionPlan(start_mm=1.0, velocity_mm_s=25.0, acceleration_mm_s2=200.0, field="may-leave"),
)
"""24 patterns of 1 ms."""

RESTING = Plan(frames=4, image_size=8, pattern_rate_hz=1000)
"""The same, with the stage at rest."""

FAULTS: Final[list[dict[str, Any]]] = [
    {},
    {"scene": {"faults": [{"kind": "drop-edge", "picture": 5}]}},
    {"scene": {"faults": [{"kind": "double-edge", "picture": 0}]}},
    {"scene": {"faults": [{"kind": "stall", "picture": 9}]}},
    {"scene": {"faults": [{"kind": "surplus-edges", "edges": 3}]}},
    {"counter": {"edge_times": False}},
    {"counter": {"overrun_at_bin": 7}},
    {"counter": {"unplugged_at_bin": 0}},
    {"counter": {"lost_block_at_bin": 3}},
    {"modulator": {"unique_patterns": 3}},
    {"stage": {"on_abort": "hold"}},
    {"stage": {"on_abort": "home"}},
    {"stage": {"travel_mm": [0.0, 2.0]}},
]
"""What is wrong with the bench, in its tables."""

_SLOW: Final = MotionProfile(velocity_mm_s=2.0, acceleration_mm_s2=50.0)

ALONE: Final[dict[str, Callable[[Instrument], object]]] = {
    "move": lambda bench: bench.stage.move_to(1.5, _SLOW),
    "home": lambda bench: bench.stage.home(),
    "stop": lambda bench: bench.stage.stop(),
    "arm": lambda bench: bench.counter.arm(CounterRun(n_bins=4, period_s=1e-3)),
    "disarm": lambda bench: bench.counter.disarm(),
    "start modulator": lambda bench: bench.modulator.start(),
    "halt": lambda bench: bench.modulator.halt(),
    "check": lambda bench: bench.check(PLAN),
    "wait": lambda bench: bench.devices.clock.sleep_s(0.3),
}
"""What a script may do between runs. Where the state does not allow it, it is refused in words."""


def abort(bench: Any) -> None:
    """Abort the run that goes on, by the handle that ``start`` gives."""
    bench._run.abort("the walk")


def interrupt(times: int) -> None:
    """Press Ctrl-C."""
    for _ in range(times):
        os.kill(os.getpid(), signal.SIGINT)


MEDDLING: Final[dict[str, Callable[[Instrument], object]]] = {
    "nothing": lambda _bench: None,
    "abort": abort,
    "interrupt": lambda _bench: interrupt(1),
    "two interrupts": lambda _bench: interrupt(2),
    "halt": ALONE["halt"],
    "stop": ALONE["stop"],
    "move": ALONE["move"],
    "disarm": ALONE["disarm"],
    "a second run": lambda bench: bench.start(PLAN),
    "close": lambda bench: bench.close(),
}
"""What may happen in the midst of a run, from another thread."""

RUN = st.tuples(st.just("run"), st.sampled_from([PLAN, RESTING]), st.sampled_from(sorted(MEDDLING)), st.integers(0, 12))
ACTION = st.one_of(st.tuples(st.just("alone"), st.sampled_from(sorted(ALONE))), RUN)


class Broken(BaseException):
    """What a script of a lab may raise within the block, whatever it is."""


@pytest.fixture(autouse=True)
def _no_hang() -> Generator[None]:
    """Ctrl-C is as Python has it, though a job in the background inherits an ignored one; and no walk lasts for ever."""

    def give_up(*_: object) -> None:
        raise TimeoutError("a walk hangs")

    before = signal.signal(signal.SIGINT, signal.default_int_handler), signal.signal(signal.SIGALRM, give_up)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGINT, before[0])
    signal.signal(signal.SIGALRM, before[1])


def walk(fault: int, actions: list[Any], *, breaks: bool) -> None:
    signal.alarm(20)
    with tempfile.TemporaryDirectory(dir=IN_MEMORY) as name:
        folder, bench = Path(name), Instrument.from_config(config_of(fault))
        read: set[Path] = set()
        with suppress(KinopixError, KeyboardInterrupt, Broken), bench:
            for turn, action in enumerate(actions):
                taken(bench, action, folder / f"{turn}.h5", read)
            if breaks:
                raise Broken
        try:
            assert_ends_safe(bench, folder, read)
        except KeyboardInterrupt:  # of a listener that is a second late
            assert_ends_safe(bench, folder, read)


# Python can raise nothing out of a destructor or a weak reference's end: an interrupt there is told and lost.
pytestmark = [
    pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning"),
    pytest.mark.skipif(not hasattr(signal, "SIGALRM"), reason="it breaks a hang by SIGALRM"),
]


def walks(count: int) -> settings:
    """Settings for so many walks of up to two actions, of some 30 ms each."""
    return settings(
        max_examples=count,
        deadline=None,
        derandomize=True,
        database=None,
        suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
    )


ANY = {
    "fault": st.integers(0, len(FAULTS) - 1),
    "actions": st.lists(ACTION, min_size=1, max_size=2),
    "breaks": st.booleans(),
}


@walks(200)
@given(**ANY)
def test_every_walk_ends_safe(fault: int, actions: list[Any], breaks: bool) -> None:  # noqa: FBT001
    walk(fault, actions, breaks=breaks)


@pytest.mark.thorough
@walks(1000)
@given(**ANY)
def test_a_thousand_walks_end_safe(fault: int, actions: list[Any], breaks: bool) -> None:  # noqa: FBT001
    walk(fault, actions, breaks=breaks)


@cache
def config_of(fault: int) -> BenchConfig:
    """A bench in virtual time, with the fault in its tables, checked once."""
    tables: dict[str, Any] = {name: {"driver": "simulated"} for name in ("modulator", "counter", "stage")}
    tables["scene"] = {"noise": {"kind": "poisson", "peak_counts": 200, "seed": 1}}
    for name, keys in FAULTS[fault].items():
        tables[name] = {**tables[name], **keys}
    return bench_of_tables(tables, "walk")


def taken(bench: Instrument, action: Any, out: Path, read: set[Path]) -> None:
    """Take one action; what it is answered with is told in words, or is the interrupt. ``read`` gets a file that was read."""
    with suppress(KinopixError):
        if action[0] == "alone":
            ALONE[action[1]](bench)
            return
        _, plan, meddling, moment = action
        recording = bench.run(plan, out, listeners=[heard(bench, meddling, moment)])
        assert len(recording) <= PLAN.frames
        read.add(out)  # a run that ends well gives what it has read back from the closed file


def heard(bench: Instrument, meddling: str, moment: int) -> Callable[[Event], None]:
    """A listener that meddles at the event of that number."""
    count = iter(range(10**6))

    def listen(_event: Event) -> None:
        if next(count) == moment:
            with suppress(KinopixError):
                MEDDLING[meddling](bench)

    return listen


def assert_ends_safe(bench: Instrument, folder: Path, read: set[Path]) -> None:
    """Asked of the scene and of the devices' insides: they are closed. Each file that was not read yet is read."""
    devices: Any = bench.devices
    clock = devices.clock
    assert devices.scene.shown_until_s <= clock.now_s(), "the modulator shows pictures"
    assert devices.stage._motion.move.end_s <= clock.now_s(), "the stage moves"
    assert devices.counter._armed is None, "the counter is armed"
    with pytest.raises(WrongState):
        devices.counter.arm(CounterRun(n_bins=4, period_s=1e-3))
    for path in folder.iterdir():
        assert path.suffix == ".h5", f"{path.name} is left behind"
        assert path in read or len(open_recording(path)) <= PLAN.frames

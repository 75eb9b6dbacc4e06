"""What a suite needs beside the driver: how to open it, its clock, and, where there is one, a second pair of eyes.

A rig factory is a function without arguments that gives a context manager of a rig, annotated with what it gives::

    @contextmanager
    def stage_rig() -> Generator[StageRig]:
        clock = MonotonicClock()
        yield StageRig(open=lambda: MyStage("/dev/ttyUSB0", clock), clock=clock)

It is called anew for each test. ``open`` is called once a test, or more often, never while the device before is still open.
"""

from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import TypeAlias, TypeVar

from protocols.clock import Clock
from protocols.counter import PhotonCounter
from protocols.modulator import PatternModulator
from protocols.stage import LinearStage
from protocols.values import Floats


@dataclass(frozen=True)
class ModulatorRig:
    """A modulator under test."""

    open: Callable[[], PatternModulator]
    """Function that opens the device."""

    clock: Clock
    """The clock that the device was given."""

    sync_edges: Callable[[], Floats] | None = None
    """Function that gives the times ``(n,)`` in seconds, on any clock, of all edges since the last ``start``, as something on
    the sync line saw them. None: nobody looks, and tests that count edges are skipped."""


@dataclass(frozen=True)
class CounterRig:
    """A counter under test."""

    open: Callable[[], PhotonCounter]
    """Function that opens the device."""

    clock: Clock
    """The clock that the device was given."""

    play: Callable[[int, float], None] | None = None
    """``play(n, period_s)``: put ``n`` edges on the sync line, ``period_s`` apart, the first about ``period_s`` from now,
    and return at once. None: there is no source, and tests that need edges are skipped."""

    bright_first: bool = False
    """Whether ``play`` gives light from its first edge to its second, none to the third, and so on in turns. It shows a
    counter that is one bin off."""


@dataclass(frozen=True)
class StageRig:
    """A stage under test.

    Without ``span_mm`` it must be free to move 6 mm (or a tenth of its travel) to both sides of where it stands. It is brought
    back there after each test. Homing, where it may, goes to its origin and comes back.
    """

    open: Callable[[], LinearStage]
    """Function that opens the device."""

    clock: Clock
    """The clock that the device was given."""

    tolerance_mm: float = 0.01
    """Distance by which a position may differ from what it should be, in millimetres: some steps of the motor."""

    carriage_mm: Callable[[], float] | None = None
    """Function that gives the carriage's true position by other means than the driver's. None: what needs it is skipped."""

    may_home: bool = True
    """Whether the stage may be homed now: it then goes to its origin, whatever ``span_mm`` says."""

    span_mm: tuple[float, float] | None = None
    """Lowest and highest position that the tests may go to, in millimetres; the stage must stand between them. None: 6 mm (or
    a tenth of the travel) to both sides of where it stands."""

    begun_mm: float | None = None
    """Where the stage stood before the test, in millimetres. The suite fills it in."""


Rig: TypeAlias = ModulatorRig | CounterRig | StageRig
"""Rig of any of the three kinds."""

RigT_co = TypeVar("RigT_co", ModulatorRig, CounterRig, StageRig, covariant=True)

RigFactory: TypeAlias = Callable[[], AbstractContextManager[RigT_co]]
"""Sets up what the device stands on, and clears it away."""

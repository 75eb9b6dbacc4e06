"""The optical bench: one scene, one clock, one light path, shared by every simulated device and wire emulator."""

import math
import threading
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from protocols import BenchContext, Bytes, Counts, Floats, InputError, Integers, PixelGrid, Truth, WrongState
from sim_backends.bench.clock import BenchClock, RealTimeClock, VirtualClock
from sim_backends.bench.files import load_object, load_trajectory
from sim_backends.bench.image import AreaImage
from sim_backends.bench.light import LightPath, Optics
from sim_backends.bench.motion import Displacement, Position, StageMotion, Trajectory
from sim_backends.bench.noise import measure
from sim_backends.bench.objects import BUILT_INS
from sim_backends.bench.settings import DroppedEdge, PhotonNoise, SceneSettings
from sim_backends.bench.sync import SyncLine, overlap, sync_line

_STRETCH = 512
"""Bins that are worked out together, once, when the first of them is asked for."""

_NAME = "bench"


@dataclass(frozen=True, eq=False)
class Projection:
    """What a modulator is about to show."""

    start_s: float
    """Start of the first picture on the bench's clock."""

    picture_time_s: float
    """Time from the start of one picture to the start of the next, in seconds."""

    mirrors: Callable[[int], Bytes]
    """Unique plane index to ``(rows, columns / 8)`` packed mirrors, as ``PatternSequence.mirror_plane`` gives them."""

    play_order: Integers
    """``(pictures,)`` plane of each picture, the guard included."""

    sync_delay_s: float = 0.0
    """Time from a sync edge to the picture that it announces, in seconds."""

    silent: tuple[int, ...] = ()
    """Indices of the pictures that give no edge."""


@dataclass(frozen=True, eq=False)
class Edges:
    """Sync edges as a counter sees them."""

    time_s: Floats
    """``(n,)`` times of the edges on the bench's clock, in seconds."""

    index: Integers
    """``(n,)`` index of each edge among all seen edges of the projection, from 0."""

    finished: bool
    """True when the projection is over and no edge will follow these. A stalled projection is never over."""

    def __len__(self) -> int:
        """Edges here."""
        return len(self.time_s)


@dataclass(frozen=True, eq=False)
class _Run:
    """A projection with everything that depends on it alone."""

    projection: Projection
    scene: AreaImage
    image_size: int
    sync: SyncLine
    edge_s: Floats
    path: LightPath
    first_edge_s: float
    counts_per_light: float
    counts: Counts
    known: set[int]


class OpticalBench:
    """The scene in front of the modulator and the light behind it (``protocols.Scene``). Safe to use from many threads.

    The stage says how it carries the object (``carry``), the modulator what it shows (``show``, ``dark``), the counter
    asks for edges and counts. Light is worked out when it is asked for, some 500 bins at a time, and never twice.
    """

    def __init__(self, settings: SceneSettings, folder: Path = Path()) -> None:
        """Load the object, the background and the trajectory.

        Args:
            settings: the ``[scene]`` table.
            folder: what paths in it are relative to.

        Raises:
            InputError: a file that cannot be used.
        """
        self.settings = settings
        self._folder = folder
        self._clock: BenchClock = RealTimeClock() if settings.realtime else VirtualClock()
        self._lock = threading.RLock()
        self._carried: list[tuple[float, Position]] = []
        self._origin_mm = settings.object_at_mm
        self._run: _Run | None = None
        self._dark_s = math.inf
        self._trajectory = load_trajectory(folder / settings.trajectory) if settings.trajectory else None
        self.use_grid(PixelGrid(image_size=128, superpixel=2))

    @property
    def clock(self) -> BenchClock:
        """The time of every device on this bench."""
        return self._clock

    def use_grid(self, grid: PixelGrid) -> None:
        """Put the object on another image grid. Scales that the settings leave open follow ``image_size``."""
        settings, size = self.settings, grid.image_size
        with self._lock:
            self._grid = grid
            self._scene = load_object(
                settings.object,
                self._folder,
                key="object",
                image_size=size,
                height_px=settings.object_height_px,
                centre_px=settings.start_px,
            ).without_dark_borders()
            self._optics = Optics(
                settings.light_level,
                settings.led_drift_per_s,
                settings.edge_loss,
                self._background(size),
                settings.background_level,
                settings.object_level,
            )

    def _background(self, image_size: int) -> AreaImage | None:
        settings = self.settings
        if settings.background is None:
            return None
        built_in = settings.background in BUILT_INS
        return load_object(
            settings.background,
            self._folder,
            key="background",
            image_size=image_size,
            height_px=settings.object_height_px if built_in else None,
            centre_px=settings.background_px or ((0.75 * image_size, 0.25 * image_size) if built_in else None),
        )

    # The stage's side

    def carry(self, position_mm: Position) -> None:
        """Take over from the stage how the object is carried, from now on; before now, what was said before holds.

        Args:
            position_mm: clock seconds ``(n,)`` to stage position ``(n,)`` in mm. It is asked for later moments too.
        """
        with self._lock:
            now_s = self._clock.now_s()
            self._carried.append((now_s, position_mm))
            if self._run:
                self._forget_after(self._run, now_s)

    @staticmethod
    def _forget_after(run: _Run, now_s: float) -> None:
        """Drop what was worked out ahead of time: the object moves otherwise now."""
        whole = int(np.searchsorted(run.edge_s, now_s)) // _STRETCH
        run.known.intersection_update(range(whole))

    def _displacement(self, image_size: int) -> Displacement:
        """How the object moves, by what is known now."""
        if self._trajectory is not None:
            return Trajectory(*self._trajectory)
        px_per_mm = self.settings.px_per_mm or 7.2 * image_size / 128
        return StageMotion(self._carried, px_per_mm, self.settings.axis_angle_deg, self._origin_mm or 0.0)

    def _fix_origin(self, first_edge_s: float) -> None:
        """The first run finds the object where it was drawn; later runs keep that place on the stage."""
        if self._origin_mm is None and self._trajectory is None:
            at_mm = StageMotion(self._carried, 1.0, 0.0, 0.0).position_mm(np.array([first_edge_s]))
            self._origin_mm = float(at_mm[0])

    # The modulator's side

    def show(self, projection: Projection) -> None:
        """Show a projection, from its ``start_s`` on.

        Raises:
            InputError: photon counting, and the object lets no light through to the field at the first picture.
        """
        with self._lock:
            settings, picture_s = self.settings, projection.picture_time_s
            sync = sync_line(
                len(projection.play_order),
                picture_time_s=picture_s,
                delay_s=projection.sync_delay_s,
                jitter_s=settings.sync_jitter_s,
                seed=getattr(settings.noise, "seed", 0),
                faults=(*settings.faults, *(DroppedEdge(kind="drop-edge", picture=k) for k in projection.silent)),
            )
            first_edge_s = projection.start_s - projection.sync_delay_s
            self._fix_origin(first_edge_s)
            path = LightPath(self._scene, self._optics, self._grid, projection.mirrors)
            scale = self._counts_per_light(first_edge_s)
            edge_s = projection.start_s + sync.phase * picture_s
            bins = max(0, len(edge_s) - 1)
            self._run = _Run(
                projection,
                self._scene,
                self._grid.image_size,
                sync,
                edge_s,
                path,
                first_edge_s,
                scale,
                self._no_counts(bins),
                set(),
            )
            self._dark_s = math.inf

    def _counts_per_light(self, first_edge_s: float) -> float:
        noise = self.settings.noise
        if not isinstance(noise, PhotonNoise):
            return 1.0
        size = self._grid.image_size
        dx, dy = self._displacement(size).at(first_edge_s, np.zeros(1))[0]
        total = float(self._scene.on_grid(dx, dy, size, 1.0).sum())
        if total <= 0:
            raise InputError(
                device=_NAME,
                saw=f"no light of '{self.settings.object}' in the field at the first picture, displaced by {dx:g}, {dy:g} px",
                expected="some light, of which peak_counts is the measure",
                remedy="change start_px, object_at_mm or the trajectory in [scene], or start_mm in plan.toml",
            )
        return noise.peak_counts / total

    def dark(self) -> None:
        """Halt: no picture and no edge after now."""
        with self._lock:
            self._dark_s = min(self._dark_s, self._clock.now_s())

    @property
    def shown_until_s(self) -> float:
        """When the present projection is over: past, future, or infinite for one that stalls. Before any, 0."""
        with self._lock:
            if self._run is None:
                return 0.0
            projection = self._run.projection
            end_s = projection.start_s + len(projection.play_order) * projection.picture_time_s
            return min(self._dark_s, math.inf if self._run.sync.stalls_at is not None else end_s)

    # The counter's side

    def edges(self, after: int, until_s: float) -> Edges:
        """Sync edges of the present projection with index >= ``after`` up to ``until_s`` on the bench's clock."""
        with self._lock:
            if self._run is None:
                return Edges(np.zeros(0), np.zeros(0, np.int64), finished=False)
            edge_s = self._run.edge_s
            last = int(np.searchsorted(edge_s, min(until_s, self._dark_s), side="right"))
            index = np.arange(min(after, last), last)
            over = self._dark_s <= until_s or (last == len(edge_s) and self._run.sync.stalls_at is None)
            return Edges(edge_s[index], index, finished=over)

    def counts(self, first: int, n: int) -> Counts:
        """What is counted between the seen edges ``first`` and ``first + n``: bin k lies between edge k and edge k + 1.

        Returns:
            ``(n,)``: uint32 for ``poisson`` noise, float64 otherwise. The same for whoever asks, in whatever blocks.

        Raises:
            WrongState: nothing was shown, or there are no such bins.
        """
        with self._lock:
            if n == 0:
                return self._no_counts(0)
            run = self._shown("counts")
            if not 0 <= first <= first + n < len(run.edge_s):
                raise WrongState(
                    device=_NAME,
                    saw=f"a call for bins {first} to {first + n - 1}",
                    expected=f"bins 0 to {len(run.edge_s) - 2}, between {len(run.edge_s)} edges",
                    remedy="ask for bins whose closing edge was seen",
                )
            for stretch in range(first // _STRETCH, -(-(first + n) // _STRETCH)):
                if stretch not in run.known:
                    self._count(run, stretch)
            return run.counts[first : first + n].copy()

    def _no_counts(self, bins: int) -> Counts:
        return np.zeros(bins, np.uint32) if isinstance(self.settings.noise, PhotonNoise) else np.zeros(bins)

    def _shown(self, what: str) -> _Run:
        if self._run is None:
            raise WrongState(
                device=_NAME,
                saw=f"a call for {what} before anything was shown",
                expected="a run first",
                remedy="start the modulator",
            )
        return self._run

    def _count(self, run: _Run, stretch: int) -> None:
        """Work out the bins of one stretch."""
        bins = slice(stretch * _STRETCH, (stretch + 1) * _STRETCH)
        begin, end = run.sync.phase[:-1][bins], run.sync.phase[1:][bins]
        light, lit_px, first = self._pictures(run, begin, end)
        run.counts[bins] = measure(
            self.settings.noise,
            stretch,
            light=overlap(begin, end, first, light),
            lit_px=overlap(begin, end, first, lit_px),
            duration_s=(end - begin) * run.projection.picture_time_s,
            counts_per_light=run.counts_per_light,
        )
        run.known.add(stretch)

    def _pictures(self, run: _Run, begin: Floats, end: Floats) -> tuple[Floats, Floats, int]:
        """Light and lit area of each picture that the bins touch, and which is the first of them."""
        projection = run.projection
        transition = self.settings.mirror_transition_s / projection.picture_time_s
        # One more before the first, from which the mirrors may still be swinging.
        first = max(0, math.floor(begin[0]) - 1)
        picture = np.arange(first, min(len(projection.play_order), math.ceil(end[-1])))
        middle_s = (picture.astype(np.float64) + 0.5) * projection.picture_time_s + projection.sync_delay_s
        seen = run.path.of(
            projection.play_order[picture], self._displacement(run.image_size).at(run.first_edge_s, middle_s), middle_s
        )
        light = seen.light
        if transition:
            before = np.concatenate([[0.0], light[:-1]])
            light = light + (before - light) * min(transition, 1.0) / 2
        return light, seen.lit_px, first

    # The framework's side

    def truth(self, time_s: Floats) -> Truth:
        """What the last run showed ``time_s`` (n,) after its first sync edge; see ``protocols.Truth``.

        Raises:
            WrongState: nothing was shown yet.
        """
        with self._lock:
            run = self._shown("the truth")
            at_px = self._displacement(run.image_size).at(run.first_edge_s, np.asarray(time_s, np.float64))
            image = run.scene.on_grid(float(at_px[0, 0]), float(at_px[0, 1]), run.image_size, 1.0)
            return Truth(at_px - at_px[0], image * self.settings.object_level)


def bench_of(context: BenchContext, device: str) -> OpticalBench:
    """Give the optical bench of a context.

    Raises:
        InputError: the context has no scene, or another one.
    """
    if isinstance(context.scene, OpticalBench):
        return context.scene
    raise InputError(
        device=device,
        saw="no [scene] table" if context.scene is None else f"a scene of type {type(context.scene).__name__}",
        expected="the optical bench, on which simulated devices and emulators stand",
        remedy="add a [scene] table to bench.toml, or choose a driver for real hardware",
    )

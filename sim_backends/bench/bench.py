"""The optical bench: one scene, one clock, one light path, shared by every simulated device and wire emulator."""

import math
import threading
from pathlib import Path

import numpy as np

from protocols import BenchContext, Counts, Floats, InputError, PixelGrid, Truth, WrongState
from sim_backends.bench.clock import BenchClock, RealTimeClock, VirtualClock
from sim_backends.bench.fault_settings import DroppedEdge
from sim_backends.bench.files import load_trajectory
from sim_backends.bench.motion import Displacement, Position, StageMotion, Trajectory
from sim_backends.bench.noise_settings import NoNoise, PhotonNoise
from sim_backends.bench.objects import NOTHING
from sim_backends.bench.projection import Edges, Projection
from sim_backends.bench.run import Run, no_counts
from sim_backends.bench.settings import SceneSettings
from sim_backends.bench.sync import sync_line
from sim_backends.bench.view import view_of

_NAME = "bench"

_SEEDS_APART = 1_000_003
"""From the seed of one run to that of the next, where each has noise of its own: no seed that a person gives comes near."""


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
        self._run: Run | None = None
        self._runs = 0
        self._dark_s = math.inf
        self._trajectory = load_trajectory(folder / settings.trajectory) if settings.trajectory else None
        self.use_grid(PixelGrid(image_size=128, superpixel=2))

    @property
    def clock(self) -> BenchClock:
        """The time of every device on this bench."""
        return self._clock

    def use_grid(self, grid: PixelGrid) -> None:
        """Put the object on another image grid. Scales that the settings leave open follow ``image_size``."""
        with self._lock:
            self._view = view_of(self.settings, self._folder, grid)

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
                self._run.forget_after(now_s)

    def _displacement(self, image_size: int) -> Displacement:
        """How the object moves, by what is known whenever it is asked."""
        if self._trajectory is not None:
            return Trajectory(*self._trajectory)
        return StageMotion(self._carried, *self._scale(image_size), self._origin_mm or 0.0)

    def _scale(self, image_size: int) -> tuple[float, float]:
        """Pixels a millimetre, and the direction of the stage in degrees."""
        return self.settings.px_per_mm or 7.2 * image_size / 128, self.settings.axis_angle_deg

    def _fix_origin(self, first_edge_s: float) -> None:
        """The first run finds the object where it was drawn; later runs keep that place on the stage."""
        if self._origin_mm is None and self._trajectory is None:
            at_mm = StageMotion(self._carried, 1.0, 0.0, 0.0).position_mm(np.array([first_edge_s]))
            self._origin_mm = float(at_mm[0])

    def object_boxes_px(self, grid: PixelGrid, stage_mm: Floats) -> Floats | None:
        """Tell where the stage will bring the object; see ``protocols.PlacesObject``."""
        settings = self.settings
        if self._trajectory is not None or settings.object == NOTHING or not settings.object_level:
            return None
        with self._lock:
            view = self._view if self._view.grid == grid else view_of(settings, self._folder, grid)
            origin_mm = float(stage_mm[0]) if self._origin_mm is None else self._origin_mm
            motion = StageMotion([(-math.inf, lambda clock_s: clock_s)], *self._scale(grid.image_size), origin_mm)
            at_px = motion.at(0.0, stage_mm)  # a stage that is at t mm at the time t
        picture = view.object
        height, width = (side * picture.cell_px for side in picture.cells.shape)
        corner = at_px + np.array([picture.left_px, picture.top_px]) - 0.5
        return np.concatenate([corner, corner + np.array([width, height])], axis=1)

    # The modulator's side

    def show(self, projection: Projection) -> None:
        """Show a projection, from its ``start_s`` on.

        Raises:
            InputError: photon counting, and the object lets no light through to the field at the first picture.
        """
        with self._lock:
            settings = self._settings_of_run()
            sync = sync_line(
                len(projection.play_order),
                picture_time_s=projection.picture_time_s,
                delay_s=projection.sync_delay_s,
                jitter_s=settings.sync_jitter_s,
                seed=getattr(settings.noise, "seed", 0),
                faults=(*settings.faults, *(DroppedEdge(kind="drop-edge", picture=k) for k in projection.silent)),
            )
            self._fix_origin(projection.first_edge_s)
            displacement = self._displacement(self._view.grid.image_size)
            all_lit = self._all_lit(displacement, projection.first_edge_s)
            self._run = Run(
                settings,
                view=self._view,
                projection=projection,
                sync=sync,
                displacement=displacement,
                all_lit=all_lit,
            )
            self._dark_s = math.inf

    def _settings_of_run(self) -> SceneSettings:
        """The settings, with a seed of its own for each run where that is asked for; the first has the one that was given."""
        settings, self._runs = self.settings, self._runs + 1
        if not settings.fresh_noise or isinstance(settings.noise, NoNoise):
            return settings
        seed = settings.noise.seed + _SEEDS_APART * (self._runs - 1)
        return settings.model_copy(update={"noise": settings.noise.model_copy(update={"seed": seed})})

    def _all_lit(self, displacement: Displacement, first_edge_s: float) -> float:
        """Light of the object in an all-lit picture where it is first seen; 0 where nothing is measured by it."""
        settings = self.settings
        if not isinstance(settings.noise, PhotonNoise) and not settings.ambient_level:
            return 0.0
        dx, dy = displacement.at(first_edge_s, np.zeros(1))[0]
        total = self._view.all_lit(float(dx), float(dy))
        if total <= 0:
            raise InputError(
                device=_NAME,
                saw=f"no light of '{settings.object}' in the field at the first picture, displaced by {dx:g}, {dy:g} px",
                expected="some light, of which peak_counts and ambient_level are the measure",
                remedy="change start_px, object_at_mm or the trajectory in [scene], or start_mm in plan.toml",
            )
        return total

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
            end_s = projection.start_s + projection.duration_s
            return min(self._dark_s, math.inf if self._run.sync.stalls_at is not None else end_s)

    # The counter's side

    def edges(self, after: int, until_s: float) -> Edges:
        """Sync edges of the present projection with index >= ``after`` up to ``until_s`` on the bench's clock."""
        with self._lock:
            if self._run is None:
                return Edges(np.zeros(0), 0, finished=False)
            edge_s = self._run.edge_s
            last = int(np.searchsorted(edge_s, min(until_s, self._dark_s), side="right"))
            first = min(after, last)
            over = self._dark_s <= until_s or (last == len(edge_s) and self._run.sync.stalls_at is None)
            return Edges(edge_s[first:last], first, finished=over)  # a view: a counter asks for each block

    def counts(self, first: int, n: int) -> Counts:
        """What is counted between the seen edges ``first`` and ``first + n``: bin k lies between edge k and edge k + 1.

        Returns:
            ``(n,)``: uint32 for ``poisson`` noise, float64 otherwise. The same for whoever asks, in whatever blocks.

        Raises:
            WrongState: nothing was shown, or there are no such bins.
        """
        with self._lock:
            if n == 0:
                return no_counts(self.settings, 0)
            run = self._shown("counts")
            if not 0 <= first <= first + n < len(run.edge_s):
                raise WrongState(
                    device=_NAME,
                    saw=f"a call for bins {first} to {first + n - 1}",
                    expected=f"bins 0 to {len(run.edge_s) - 2}, between {len(run.edge_s)} edges",
                    remedy="ask for bins whose closing edge was seen",
                )
            return run.counts(first, n)

    def _shown(self, what: str) -> Run:
        if self._run is None:
            raise WrongState(
                device=_NAME,
                saw=f"a call for {what} before anything was shown",
                expected="a run first",
                remedy="start the modulator",
            )
        return self._run

    # The framework's side

    def truth(self, time_s: Floats) -> Truth:
        """What the last run showed ``time_s`` (n,) after its first sync edge; see ``protocols.Truth``.

        Raises:
            WrongState: nothing was shown yet.
        """
        with self._lock:
            return self._shown("the truth").truth(np.asarray(time_s, np.float64))


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

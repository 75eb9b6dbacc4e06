"""What stands before the modulator: object and background on one image grid, and what happens to their light."""

from dataclasses import dataclass
from pathlib import Path

from protocols import Floats, PixelGrid
from sim_backends.bench.blur import blurred
from sim_backends.bench.files import load_object
from sim_backends.bench.illumination import illumination
from sim_backends.bench.image import AreaImage
from sim_backends.bench.lamp import Lamp
from sim_backends.bench.light import Optics
from sim_backends.bench.objects import BUILT_INS
from sim_backends.bench.pose import ChangingImage
from sim_backends.bench.settings import SceneSettings


@dataclass(frozen=True, eq=False)
class View:
    """The scene on an image grid, where it is not displaced."""

    object: AreaImage
    optics: Optics
    grid: PixelGrid

    def all_lit(self, dx_px: float, dy_px: float) -> float:
        """Light of the object, displaced, in an all-lit picture; ``object_level`` and the lamp do not count."""
        size, falloff = self.grid.image_size, self.optics.illumination_falloff
        light = self.object.on_grid(dx_px, dy_px, size, 1.0)
        return float((light * illumination(size, falloff) if falloff else light).sum())

    def background(self) -> Floats | None:
        """``(image_size, image_size)`` transmission of the background, where there is one."""
        if self.optics.background is None:
            return None
        return self.optics.background.on_grid(0.0, 0.0, self.grid.image_size, 1.0) * self.optics.background_level


def view_of(settings: SceneSettings, folder: Path, grid: PixelGrid) -> View:
    """Load object and background, and put them on a grid. Scales that the settings leave open follow ``image_size``.

    Raises:
        InputError: a file that cannot be used, or a blur that is too wide for it.
    """
    shown = load_object(
        settings.object,
        folder,
        key="object",
        image_size=grid.image_size,
        height_px=settings.object_height_px,
        centre_px=settings.start_px,
    ).without_dark_borders()
    optics = Optics(
        Lamp(settings.light_level, settings.led_drift_per_s, settings.led_flicker, 2 * settings.mains_hz),
        settings.illumination_falloff,
        settings.edge_loss,
        settings.mirrors_inverted,
        _background(settings, folder, grid.image_size),
        settings.background_level,
        settings.object_level,
    )
    return View(blurred(shown, settings.blur_px), optics, grid)


def _background(settings: SceneSettings, folder: Path, image_size: int) -> AreaImage | None:
    if settings.background is None:
        return None
    built_in = settings.background in BUILT_INS
    image = load_object(
        settings.background,
        folder,
        key="background",
        image_size=image_size,
        height_px=settings.object_height_px if built_in else None,
        centre_px=settings.background_px or ((0.75 * image_size, 0.25 * image_size) if built_in else None),
    )
    return blurred(image, settings.blur_px)


def changing(shown: AreaImage, settings: SceneSettings, run_s: float) -> ChangingImage:
    """Give the object as it turns and grows by what the settings say in a run of ``run_s`` seconds."""
    return ChangingImage(shown, settings.object_growth, settings.object_turn_deg, run_s)

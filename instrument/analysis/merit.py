"""Figures of merit of one analysis, which ``kinopix analyse`` prints and stores."""

from typing import Any, Final

import numpy as np
from pydantic import NonNegativeFloat, NonNegativeInt

from instrument.analysis.doubts import doubts_of, entangled
from instrument.analysis.stage_figures import StageFigures
from instrument.measurement import LightModel, Measurement, Parameter
from instrument.numerics import displacement_mse, offset_free_mse, psnr, ssim_global, ssim_local
from instrument.reconstruction import Reconstruction
from instrument.tracking import MotionFit, Quantity, Trajectory
from protocols import Floats, Frozen, Truth

_EXACT_DB: Final = 300.0
"""PSNR that is stated for an image without any error: about what the digits of double precision allow."""


class Figures(Frozen):
    """Quality of motion and image. Figures that need the truth are None for a real bench."""

    frames: NonNegativeInt
    """Number of frames analysed."""

    frames_masked: NonNegativeInt
    """Number of frames, of those analysed, that were not valid."""

    travel_px: tuple[float, float] | None
    """Displacement of the last frame in which it is known, x and y; None where the scheme has no position."""

    sigma_px: NonNegativeFloat | None
    """Median of the stated standard deviation of the displacement; None where there are too few frames to state one."""

    misfit: float | None
    """Root mean square of what image and motion leave unexplained, over the noise; about 1 where both are right."""

    light_change: NonNegativeFloat
    """Largest change of the field's total light in the run, relative to its median, over tenths of the run."""

    analysis_s: NonNegativeFloat
    """Time taken by tracking and reconstruction."""

    start_px: tuple[float, float] | None = None
    """The object's centroid at frame 0, x and y in px of the field; None where the scheme measures displacement alone."""

    start_sigma_px: tuple[float, float] | None = None
    """Its standard deviation."""

    start_error_px: NonNegativeFloat | None = None
    """Its distance from the centroid of the true image."""

    reference_frame: NonNegativeInt = 0
    """Frame that displacements are relative to, and that the image shows."""

    motion_px: MotionFit | None = None
    """Travel, speed and acceleration in px, of a parabola fitted to the path; None where its covariance is not known."""

    motion_mm: MotionFit | None = None
    """The same in mm along the stage's axis; None where the bench was not calibrated."""

    stage: StageFigures | None = None
    """What the stage did, held against what it was told; None where the plan moved nothing."""

    turn_deg: float | None = None
    """Angle of the last frame in which the displacement is known, against ``reference_frame``, clockwise as one looks at the
    picture; None where none was seen."""

    turn_sigma_deg: NonNegativeFloat | None = None
    """Its stated standard deviation in that frame."""

    growth: float | None = None
    """Size of the object in that frame over that in ``reference_frame``, less 1; None where it was not found to change."""

    growth_sigma: NonNegativeFloat | None = None
    """Its stated standard deviation in that frame."""

    displacement_mse_px2: float | None = None
    """Mean squared error of the displacement over both axes and the frames in which it is known, relative to
    ``reference_frame``."""

    displacement_mse_offset_free_px2: float | None = None
    """Mean squared error of the displacement after a constant shift is removed."""

    psnr_db: float | None = None
    """10 log10(1 / MSE) of the image, clipped to 0..1; after one least-squares gain for photon counts; 300 at most. Of a wide
    image it is that of what is in the field at frame 0, as is the structural similarity: the truth holds no more."""

    ssim_global: float | None = None
    """Structural similarity with moments of the whole image, as in Li et al. (2023)."""

    ssim_local: float | None = None
    """Structural similarity with a Gaussian window of 11 x 11, sigma 1.5, as in Wang et al. (2004)."""

    image_px: tuple[NonNegativeInt, NonNegativeInt] | None = None
    """Columns and rows of an image that reaches outside the field, in px of the patterns; None of one that is the field's."""

    origin_px: tuple[NonNegativeInt, NonNegativeInt] | None = None
    """Column and row of such an image at which the field's pixel (0, 0) is; None likewise."""

    grid: NonNegativeInt | None = None
    """Image pixels that a pattern pixel has along each axis; None where there is no image."""

    background_share: NonNegativeFloat | None = None
    """Share of the total light that stems from something that stands still, where its image was found with the object's."""

    light: LightModel = LightModel()
    """What the bench does to the light: given, or fitted to the run."""

    found: tuple[str, ...] = ()
    """What the counts themselves show to be wrong, and what was done about it, in a few words each."""

    doubts: tuple[str, ...] = ()
    """Sentences, each of which gives a reason to doubt the result."""

    def rows(self) -> dict[str, str]:
        """Give the figures as a person reads them: text by name."""
        rows = {
            "frames": f"{self.frames}, {self.frames_masked} masked",
        }
        if self.travel_px is not None:
            rows["travel"] = f"{self.travel_px[0]:.2f}, {self.travel_px[1]:.2f} px"
            sigma = "-" if self.sigma_px is None else f"{self.sigma_px:.3f} px (median, one sigma)"
            rows["stated uncertainty"] = sigma
        if self.reference_frame:
            rows["displacement from"] = f"frame {self.reference_frame}, whose image is shown"
        if self.start_px is not None and self.start_sigma_px is not None:
            (x, y), (sigma_x, sigma_y) = self.start_px, self.start_sigma_px
            error = "" if self.start_error_px is None else f" (off by {self.start_error_px:.2f})"
            rows["centroid at frame 0"] = f"{x:.2f} +- {sigma_x:.2f}, {y:.2f} +- {sigma_y:.2f} px{error}"
        rows |= _motion_rows(self.motion_mm or self.motion_px)
        if self.stage is not None:
            rows["stage"] = self.stage.row()
        if self.turn_deg is not None:
            sigma = "-" if self.turn_sigma_deg is None else f"{self.turn_sigma_deg:.2f}"
            rows["turn"] = f"{self.turn_deg:.2f} degrees clockwise (+- {sigma}, one sigma)"
        if self.growth is not None and self.growth_sigma is not None:
            rows["growth"] = f"{100 * self.growth:+.1f} % (+- {100 * self.growth_sigma:.1f}, one sigma)"
        if self.displacement_mse_px2 is not None and self.displacement_mse_offset_free_px2 is not None:
            rows["displacement MSE"] = (
                f"{self.displacement_mse_px2:.4f} px^2 ({self.displacement_mse_offset_free_px2:.4f} offset-free)"
            )
        if self.psnr_db is not None:
            rows["PSNR"] = f"{self.psnr_db:.1f} dB"
            rows["SSIM"] = f"{self.ssim_global:.4f} global, {self.ssim_local:.4f} local"
        if self.misfit is not None:
            rows["misfit"] = f"{self.misfit:.3f} (1 is the noise alone)"
        if self.image_px is not None and self.origin_px is not None:
            (columns, lines), (x, y) = self.image_px, self.origin_px
            rows["image"] = f"{columns} x {lines} px; the field begins at column {x}, row {y} of it"
        if self.grid is not None and self.grid > 1:
            rows["image pixels"] = f"{1 / self.grid:g} px wide, {self.grid} x {self.grid} to a pattern pixel"
        rows |= _light_rows(self.light)
        if self.background_share is not None:
            rows["background"] = f"{100 * self.background_share:.1f} % of the light stands still (fitted)"
        if self.found:
            rows["in the counts"] = "; ".join(self.found)
        return {**rows, "analysis": f"{self.analysis_s:.2f} s"}

    def caption(self) -> str:
        """Give one line for a picture."""
        parts = [f"{self.frames} frames"]
        if self.motion_mm is not None:
            parts.append(_interval(self.motion_mm.speed, "mm/s").removesuffix(" (95 %)"))
        if self.displacement_mse_px2 is not None:
            parts.append(f"displacement MSE {self.displacement_mse_px2:.4f} px²")
        elif self.sigma_px is not None:
            parts.append(f"displacement known to {self.sigma_px:.3f} px")
        if self.psnr_db is not None:
            parts.append(f"image PSNR {self.psnr_db:.1f} dB")
        return ", ".join(parts)


def _motion_rows(motion: MotionFit | None) -> dict[str, str]:
    """Give travel, speed and acceleration with their 95 % intervals, as a person reads them."""
    if motion is None:
        return {}
    unit = motion.unit
    rows = {
        f"travel in {unit}": _interval(motion.travel, unit),
        "speed, mid-run": _interval(motion.speed, f"{unit}/s"),
        "speed, start": _interval(motion.start_speed, f"{unit}/s"),
        "speed, end": _interval(motion.end_speed, f"{unit}/s"),
        "acceleration": _interval(motion.acceleration, f"{unit}/s^2"),
    }
    if motion.off_axis_deg is not None:
        rows["off the axis"] = _interval(motion.off_axis_deg, "degrees")
    return rows


def _interval(number: Quantity, unit: str) -> str:
    """Give a number with half its 95 % interval, to the digits that mean something."""
    reach = (number.high - number.low) / 2
    digits = 3 if reach <= 0 or not np.isfinite(reach) else int(np.clip(1 - np.floor(np.log10(reach)), 0, 9))
    return f"{number.value:.{digits}f} +- {reach:.{digits}f} {unit} (95 %)"


def _light_rows(light: LightModel) -> dict[str, str]:
    """Give the numbers of the light model that are not 0, as a person reads them."""
    rows = {
        "mirror leak": _number(light.leak, "of the picture before"),
        "edge loss": _number(light.edge_loss, "a mirror's dark side"),
    }
    if light.profile is not None:
        brightness = np.array(light.profile.values)
        least = 100 * float(brightness.min() / brightness.max())
        rows["illumination"] = f"{least:.0f} % of the brightest at the darkest place ({light.profile.source})"
    for ripple in light.ripples:
        whose = "ambient" if ripple.lamp_share < 0.5 else "lamp"
        rows[f"{ripple.frequency_hz:.0f} Hz"] = f"{100 * ripple.amplitude:.1f} % of the light ({whose}, fitted)"
    if any(offset.value for offset in light.offsets):
        offsets = ", ".join(f"{100 * offset.value:.2f}" for offset in light.offsets)
        source = next(offset.source for offset in light.offsets if offset.value)
        rows["offsets"] = f"{offsets} % of the light ({source})"
    return {name: text for name, text in rows.items() if text}


def _number(parameter: Parameter, what: str) -> str:
    """Give a number with its uncertainty and source; nothing where it is 0 because nobody and nothing said otherwise."""
    if parameter.value == 0 and parameter.source == "assumed":
        return ""
    sigma = "" if parameter.sigma is None else f" +- {parameter.sigma:.4f}"
    return f"{parameter.value:.4f}{sigma} {what} ({parameter.source})"


def figures_of(
    measurement: Measurement,
    truth: Truth | None,
    trajectory: Trajectory | None,
    reconstruction: Reconstruction | None,
    took_s: float,
    *,
    stage: StageFigures | None = None,
) -> Figures:
    """Compute the figures, with those that need the truth where it is known.

    Args:
        measurement: measurement that was analysed.
        truth: true displacement and image; None where they are unknown.
        trajectory: path found; None where the scheme has no position.
        reconstruction: image found; None where the scheme has none.
        took_s: time taken by the analysis.
        stage: what the stage did.
    """
    light_change = measurement.light_change()
    reference = 0 if trajectory is None else trajectory.reference_frame
    of_path = _path_figures(trajectory, truth)
    of_image = _image_figures(reconstruction, None if reference else truth, measurement)
    used = int(np.count_nonzero(measurement.valid))
    if trajectory is not None and used < 2:
        of_path |= {"travel_px": None, "sigma_px": None, "motion_px": None, "motion_mm": None}
    joint = trajectory is not None and trajectory.method == "joint"
    if joint and reconstruction is not None and entangled(reconstruction, used):
        of_path |= {"sigma_px": None, "motion_px": None, "motion_mm": None}
    return Figures(
        frames=len(measurement),
        frames_masked=int(np.count_nonzero(~measurement.valid)),
        light_change=light_change,
        analysis_s=took_s,
        light=measurement.light,
        found=tuple(finding.text for finding in measurement.findings),
        stage=stage,
        doubts=(
            *(finding.sentence for finding in measurement.findings),
            *doubts_of(measurement, trajectory, reconstruction),
            *(() if stage is None else stage.sentences()),
        ),
        **{"travel_px": None, "sigma_px": None, "misfit": None, **of_path, **of_image},
    )


def _path_figures(trajectory: Trajectory | None, truth: Truth | None) -> dict[str, Any]:
    """Compute the figures of the path."""
    if trajectory is None:
        return {}
    found_px, finite = trajectory.displacement_px, np.isfinite(trajectory.sigma_px)
    sigma_px = float(np.median(trajectory.sigma_px[finite])) if finite.any() else np.inf
    figures: dict[str, Any] = {
        "travel_px": tuple(found_px[trajectory.last_known].tolist()),
        "sigma_px": sigma_px if np.isfinite(sigma_px) and sigma_px > 0 else None,
        "reference_frame": trajectory.reference_frame,
        "motion_px": trajectory.motion_px,
        "motion_mm": trajectory.motion_mm,
    }
    if trajectory.angle_deg is not None and trajectory.angle_sigma_deg is not None:
        turn_sigma = float(trajectory.angle_sigma_deg[trajectory.last_known])
        figures["turn_deg"] = float(trajectory.angle_deg[trajectory.last_known])
        figures["turn_sigma_deg"] = turn_sigma if np.isfinite(turn_sigma) else None
    if trajectory.magnification is not None and trajectory.magnification_sigma is not None:
        figures["growth"] = float(trajectory.magnification[trajectory.last_known] - 1)
        figures["growth_sigma"] = float(trajectory.magnification_sigma[trajectory.last_known])
    if trajectory.start_px is not None and trajectory.start_sigma_px is not None:
        figures["start_px"] = tuple(trajectory.start_px.tolist())
        figures["start_sigma_px"] = tuple(trajectory.start_sigma_px.tolist())
        if truth is not None and truth.image.sum() > 0:
            figures["start_error_px"] = float(np.hypot(*(trajectory.start_px - _centroid_px(truth.image))))
    if truth is not None:
        truth_px = truth.displacement_px - truth.displacement_px[trajectory.reference_frame]
        known = np.isfinite(trajectory.sigma_px).all(axis=1)
        known = known if np.count_nonzero(known) > 1 else np.ones_like(known)
        figures["displacement_mse_px2"] = displacement_mse(found_px[known], truth_px[known])
        figures["displacement_mse_offset_free_px2"] = offset_free_mse(found_px[known], truth_px[known])
    return figures


def _centroid_px(image: Floats) -> Floats:
    """Centroid of an image, x and y."""
    light = float(image.sum())
    weights: tuple[Floats, Floats] = image.sum(axis=0), image.sum(axis=1)
    return np.array([float(weight @ np.arange(len(weight))) for weight in weights]) / light


def _image_figures(
    reconstruction: Reconstruction | None, truth: Truth | None, measurement: Measurement
) -> dict[str, Any]:
    """Compute the figures of the image."""
    if reconstruction is None:
        return {}
    image, fit_gain = reconstruction.in_field, measurement.photon_counts
    figures: dict[str, Any] = {
        "misfit": reconstruction.misfit if np.isfinite(reconstruction.misfit) else None,
        "grid": reconstruction.grid,
    }
    if reconstruction.wide:
        figures["image_px"] = reconstruction.at_patterns.shape[::-1]
        figures["origin_px"] = (reconstruction.field.left, reconstruction.field.top)
    if reconstruction.still is not None:
        background, own = float(reconstruction.still.sum()), float(image.sum())
        figures["background_share"] = background / max(background + own, 1e-300)
    if truth is not None:
        figures["psnr_db"] = min(psnr(image, truth.image, fit_gain=fit_gain), _EXACT_DB)
        figures["ssim_global"] = ssim_global(image, truth.image, fit_gain=fit_gain)
        figures["ssim_local"] = ssim_local(image, truth.image, fit_gain=fit_gain)
    return figures

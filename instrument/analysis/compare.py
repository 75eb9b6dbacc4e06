"""The image of a moving object held against a reference image of it, such as one taken at rest.

Both images have gains and places of their own: the image is moved and scaled onto the reference by least squares first.

References:
    Li, Cai, Wang, Yao, Zhao, "Single-pixel imaging of a translational object", Opt. Express (2023): reference image of the
    resting object, 100 patterns a second, 19,992 differential Hadamard patterns.
"""

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from scipy.optimize import least_squares

from instrument.analysis.analyse import analyse
from instrument.numerics import psnr, ssim_global, ssim_local
from instrument.recording import Recording
from protocols import Floats, Frozen, InputError

_BRIGHT: Final = 0.9  # quantile of an object's pixels that is called its brightness
_STEEP: Final = 0.9  # quantile of the slopes at edges from which on an edge is straight across


class Comparison(Frozen):
    """How alike two images are, after one was moved and scaled onto the other."""

    shift_px: tuple[float, float]
    """How far the image was moved, x and y, in px of the reference."""

    gain: float
    """By what it was multiplied."""

    psnr_db: float
    """10 log10(1 / mean squared difference), the brightness of the reference being 1 and both clipped to 0..1."""

    ssim_global: float
    """Structural similarity with moments of the whole image, as in Li et al. (2023)."""

    ssim_local: float
    """Structural similarity with a Gaussian window of 11 x 11, sigma 1.5, as in Wang et al. (2004)."""

    edge_width_px: float
    """Width of the image's edges from 10 to 90 %."""

    reference_edge_width_px: float
    """That of the reference."""

    def rows(self) -> dict[str, str]:
        """Give the figures as a person reads them: text by name."""
        return {
            "shift": f"{self.shift_px[0]:+.2f}, {self.shift_px[1]:+.2f} px",
            "PSNR": f"{self.psnr_db:.1f} dB",
            "SSIM": f"{self.ssim_global:.4f} global, {self.ssim_local:.4f} local",
            "edge width": f"{self.edge_width_px:.2f} px, of the reference {self.reference_edge_width_px:.2f} px (10 to 90 %)",
        }


@dataclass(frozen=True, eq=False)
class Compared:
    """The figures and both images."""

    figures: Comparison
    """How alike they are."""

    image: Floats
    """``(m, m)``: the image, moved and scaled onto the reference."""

    reference: Floats
    """``(m, m)``: the reference, its brightness being 1."""


def compare(reference: Recording, moving: Recording) -> Compared:
    """Analyse two recordings and hold their images against each other, at the patterns' resolution.

    Args:
        reference: of the object at rest as a rule; its image is made by the scheme's own method.
        moving: of the same object in motion.

    Raises:
        InputError: other pixels, a scheme without an image, or a recording that cannot be analysed.
    """
    ours, theirs = moving.plan, reference.plan
    if (ours.image_size, ours.superpixel) != (theirs.image_size, theirs.superpixel):
        raise InputError(
            saw=f"{ours.image_size} px of {ours.superpixel} mirrors, and {theirs.image_size} px of {theirs.superpixel}",
            expected="two recordings with the same pixels",
            remedy="record both with the same image_size and superpixel",
        )
    return compare_images(_image_of(reference), _image_of(moving))


def _image_of(recording: Recording) -> Floats:
    found = analyse(recording).reconstruction
    if found is None:
        raise InputError(
            saw=f"a recording of the scheme {recording.plan.scheme.name}, which makes no image",
            expected="a scheme with Hadamard patterns",
            remedy="compare recordings of fourier-hadamard, or of hadamard",
        )
    return found.in_field


def compare_images(reference: Floats, image: Floats) -> Compared:
    """Move and scale an image onto a reference, and say how alike they are. Both are ``(m, m)``.

    Raises:
        InputError: nothing is bright in one of them.
    """
    if not (reference.max() > 0 and image.max() > 0):
        raise InputError(
            saw="an image without light", expected="an object in both", remedy="look at both recordings first"
        )
    from scipy.signal import fftconvolve  # noqa: PLC0415 - slow to load: only who compares needs it

    reference = reference / _brightness(reference)
    correlation: Floats = np.asarray(fftconvolve(reference, image[::-1, ::-1]), np.float64)
    row, column = np.unravel_index(int(np.argmax(correlation)), correlation.shape)
    size = len(reference)
    start = np.array([float(column) - (size - 1), float(row) - (size - 1), 1 / _brightness(image)])

    def difference(numbers: Floats) -> Floats:
        return np.asarray((numbers[2] * _moved(image, numbers[:2]) - reference).ravel(), np.float64)

    fit: Any = least_squares(difference, start, x_scale=[1.0, 1.0, abs(start[2])])
    dx, dy, gain = (float(number) for number in fit.x)
    fitted: Floats = gain * _moved(image, np.array([dx, dy]))
    figures = Comparison(
        shift_px=(dx, dy),
        gain=gain,
        psnr_db=min(psnr(fitted, np.clip(reference, 0, 1)), 300.0),
        ssim_global=ssim_global(fitted, np.clip(reference, 0, 1)),
        ssim_local=ssim_local(fitted, np.clip(reference, 0, 1)),
        edge_width_px=edge_width_px(fitted),
        reference_edge_width_px=edge_width_px(reference),
    )
    return Compared(figures, fitted, reference)


def _brightness(image: Floats) -> float:
    """The brightness of an object, whatever single pixels say."""
    return float(np.quantile(image[image > image.max() / 4], _BRIGHT))


def _moved(image: Floats, shift_px: Floats) -> Floats:
    """Move an image by fractions of a pixel, by Fourier interpolation in a dark surround."""
    size = len(image)
    padded = np.pad(image, size // 2)
    fx, fy = np.meshgrid(np.fft.fftfreq(len(padded)), np.fft.fftfreq(len(padded)))
    phase = np.exp(-2j * np.pi * (fx * shift_px[0] + fy * shift_px[1]))
    moved = np.fft.ifft2(np.fft.fft2(padded) * phase).real
    return np.asarray(moved[size // 2 : size // 2 + size, size // 2 : size // 2 + size], np.float64)


def edge_width_px(image: Floats) -> float:
    """Give the width of an image's edges from 10 to 90 %: 0.8 of its brightness over the steepest slopes.

    Of an edge that is a ramp of w px it is 0.8 w. Slopes are central differences, so that the least is 1.6 px, that of a step.

    Args:
        image: ``(m, m)``.
    """
    slope_y, slope_x = np.gradient(image)
    slope = np.hypot(slope_x, slope_y)
    brightness = _brightness(image)
    edges = slope[slope > 0.1 * brightness]
    if not len(edges):
        return float(len(image))
    return 0.8 * brightness / float(np.quantile(edges, _STEEP))

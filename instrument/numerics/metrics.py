"""Figures of merit of a trajectory and of an image."""

import numpy as np
from scipy.ndimage import gaussian_filter

from protocols import Floats

_C1, _C2 = 0.01**2, 0.03**2  # constants of Wang et al. (2004), for data of range 1
_SIGMA_PX = 1.5
_RADIUS_PX = 5


def displacement_mse(displacement_px: Floats, truth_px: Floats) -> float:
    """Give the mean squared error over frames and both axes, in px^2, relative to frame 0. Both arrays are ``(frames, 2)``."""
    error: Floats = displacement_px - truth_px
    return float(np.vdot(error, error)) / error.size


def offset_free_mse(displacement_px: Floats, truth_px: Floats) -> float:
    """Give ``displacement_mse`` after the mean error of each axis is subtracted, as a constant shift blurs no image."""
    error: Floats = displacement_px - truth_px
    rest: Floats = error - error.mean(axis=0)
    return float(np.mean(rest**2))


def psnr(image: Floats, truth: Floats, *, fit_gain: bool = False) -> float:
    """Give the peak signal-to-noise ratio 10 log10(1 / MSE), in dB, of the image clipped to 0..1; infinite where both are equal.

    Args:
        image: image of the same shape as ``truth``.
        truth: true transmission, 0 to 1.
        fit_gain: whether the image is first multiplied by its least-squares gain, as is fair to methods without a scale.
    """
    error = float(np.mean((_clipped(image, truth, fit_gain=fit_gain) - truth) ** 2))
    return float("inf") if error == 0 else float(-10 * np.log10(error))


def ssim_local(image: Floats, truth: Floats, *, fit_gain: bool = False) -> float:
    """Give the mean structural similarity in Gaussian windows of 11 x 11, sigma 1.5, data range 1; arguments as in ``psnr``.

    References:
        Wang, Bovik, Sheikh, Simoncelli, IEEE Trans. Image Process. 13 (2004) 600, equation 13. Equals scikit-image's
        ``structural_similarity(gaussian_weights=True, sigma=1.5, use_sample_covariance=False, data_range=1)``.
    """
    a, b = _clipped(image, truth, fit_gain=fit_gain), truth

    def local(values: Floats) -> Floats:
        """Give the mean in the window around each pixel."""
        mean: Floats = gaussian_filter(values, _SIGMA_PX, radius=_RADIUS_PX)
        return mean

    mean_a, mean_b = local(a), local(b)
    variance_a, variance_b = local(a * a) - mean_a**2, local(b * b) - mean_b**2
    similarity = _similarity(mean_a, mean_b, variance_a, variance_b, local(a * b) - mean_a * mean_b)
    return float(similarity[_RADIUS_PX:-_RADIUS_PX, _RADIUS_PX:-_RADIUS_PX].mean())


def ssim_global(image: Floats, truth: Floats, *, fit_gain: bool = False) -> float:
    """Give the structural similarity of the whole image as one window, data range 1; arguments as in ``psnr``.

    References:
        Li et al., "Single-pixel imaging of a translational object", Opt. Express (2023): SSIM as printed there.
    """
    a, b = _clipped(image, truth, fit_gain=fit_gain), truth
    product: Floats = (a - a.mean()) * (b - b.mean())
    covariance = float(np.mean(product))
    means, variances = (np.asarray(a.mean()), np.asarray(b.mean())), (np.asarray(a.var()), np.asarray(b.var()))
    return float(_similarity(*means, *variances, np.asarray(covariance)))


def _similarity(mean_a: Floats, mean_b: Floats, variance_a: Floats, variance_b: Floats, covariance: Floats) -> Floats:
    """Give the similarity index of these moments."""
    luminance: Floats = (2 * mean_a * mean_b + _C1) / (mean_a**2 + mean_b**2 + _C1)
    return luminance * (2 * covariance + _C2) / (variance_a + variance_b + _C2)


def _clipped(image: Floats, truth: Floats, *, fit_gain: bool) -> Floats:
    """Give the image after its least-squares gain, if wanted, clipped to 0..1."""
    power = float(np.vdot(image, image))
    gain = float(np.vdot(image, truth)) / power if fit_gain and power > 0 else 1.0
    return np.clip(gain * image, 0.0, 1.0)

"""What a path is less sure by as its image is estimated from the same values.

A step of the path holds the image. But the image was found along the path, and is in error itself: part of what the Hadamard
values say of a slow motion has gone into the image, which bends as the path does, and the position values are held against an
image with noise in it. What that adds to the variance is worked out here by linear algebra, without another solution.

Let J be the derivatives of the whitened Hadamard values by slow modes of the path, K those of the position values, A and P the
derivatives of both by the image's pixels, S the prior precision of the modes (that of the smoothing), and G = (A'A + Q)^-1 the
covariance of the pixels, with the prior precision Q that the solver's penalty stands for. An image found along a path that is in
error by d follows it by -G A'J d, so that one round leads from d to

    d' = B (F d + s),   B = (J'J + K'K + S)^-1,   F = (J'A + K'P) G A'J,   s = J'(n - A e) + K'(m - P e) - S d0,

with noise n and m, the pixels' own error e and the true modes d0. As Q and S say how large e and d0 are, s has the covariance
J'J - J'A G A'J + K'K + K'P G P'K + S. After r rounds the error is d = (1 + B F + ... + (B F)^(r - 1)) B s. With a known image,
G = 0, it has the covariance B, which is that of the smoothing. Angle and magnification of an object whose shape changes are
modes among them, and add to the error of the path likewise.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.polynomial.legendre import legvander

from instrument.joint.detail import Picture
from instrument.joint.evidence import Evidence
from instrument.joint.image_cells import Cells, cells_of
from instrument.joint.prediction import Prediction
from instrument.numerics import Smooth
from protocols import Floats

_MODES: Final = 8
"""Polynomials of time for each axis: what is faster is no bend of the image."""

_BLOCK_ROWS: Final = 2048
"""Rows that are written out at a time."""


def by_image_px2(picture: Picture, evidence: Evidence, prediction: Prediction, fits: Sequence[Smooth]) -> Floats:
    """``(frames, 2)``: variance of the displacements that the image's own uncertainty adds.

    Args:
        picture: path, and the image along it.
        evidence: what the values say of the displacement, given that image.
        prediction: what they were held against.
        fits: how the path was smoothed, along x and y.
    """
    from scipy.linalg import block_diag, cho_factor, cho_solve  # noqa: PLC0415 - slow to load: not while a counter counts

    layers, path = cells_of(picture), picture.iterate.trajectory
    frames = len(path)
    if not any(layer.lit.any() for layer in layers):
        return np.zeros((frames, 2))
    modes = np.asarray(legvander(np.linspace(-1.0, 1.0, frames), _MODES - 1), np.float64)
    own = modes[picture.iterate.problem.values.frame]
    seen = evidence.hadamard.slope
    # x, y, and where the shape changes a line of time for angle and magnification, of which the position values say nothing
    hadamard = np.hstack([seen[:, 0, None] * own, seen[:, 1, None] * own, seen[:, 2:] * own[:, 1:2]])
    shape = np.zeros((len(seen), seen.shape[1] - 2))
    positions = [
        np.hstack([view.position.slope[:, 0, None] * own, view.position.slope[:, 1, None] * own, shape])
        for view in evidence.axes
    ]
    alongs = [view.by_offset / prediction.total[:, None] for view in evidence.axes]
    normal, of_hadamard = _written_out(layers, hadamard)
    of_position = np.vstack([layer.of_position(alongs, positions, prediction) for layer in layers])
    smoothing = block_diag(*(fit.precision_of(modes) for fit in fits), np.zeros((shape.shape[1], shape.shape[1])))
    known = hadamard.T @ hadamard + sum(position.T @ position for position in positions) + smoothing
    factor = cho_factor(normal + block_diag(*(layer.precision() for layer in layers)), lower=True)
    followed = cho_solve(factor, of_hadamard)
    taken = of_hadamard.T @ followed
    gain = np.linalg.inv(known)
    carried, again = gain, gain @ (taken + of_position.T @ followed)
    for _ in range(picture.iterate.refinements - 1):
        carried = gain + again @ carried
    of_score = known - taken + of_position.T @ cho_solve(factor, of_position)
    both = 2 * _MODES
    added = (carried @ of_score @ carried.T)[:both, :both] - np.linalg.inv(known[:both, :both])
    since = modes - modes[path.reference_frame]
    of_axes = [added[:_MODES, :_MODES], added[_MODES:, _MODES:]]
    variance = np.stack([np.einsum("fk,kl,fl->f", since, of_axis, since) for of_axis in of_axes], axis=1)
    return np.asarray(np.maximum(variance, 0.0), np.float64)


def _written_out(layers: Sequence[Cells], modes: Floats) -> tuple[Floats, Floats]:
    """Give A'A and A'J, with the rows of all layers side by side."""
    cells = sum(int(np.count_nonzero(layer.lit)) for layer in layers)
    normal, of_modes = np.zeros((cells, cells)), np.zeros((cells, modes.shape[1]))
    for first in range(0, len(modes), _BLOCK_ROWS):
        chosen = slice(first, first + _BLOCK_ROWS)
        rows = np.hstack([layer.rows(chosen) for layer in layers])
        normal += rows.T @ rows
        of_modes += rows.T @ modes[chosen].astype(np.float32)
    return normal, of_modes

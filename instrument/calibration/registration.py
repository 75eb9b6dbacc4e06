"""Static images of one object at several places, registered to a fraction of a pixel, with honest uncertainties.

All views are explained by one image of the object, shifted, under white noise: their common image is a Wiener mean of the views,
shifted back by Fourier interpolation, and each place is corrected by weighted least squares (Gauss-Newton) against it until the
places stand still. As the prior of the image does not change with its place, this is the maximum of the likelihood of the places
alone. Pairwise registration (``skimage.registration``) tells no uncertainty, and gives each pair the noise of both images.

An object that moves through an uneven light changes its brightness, and not evenly: each view is given a plane, a + b x + c y,
that multiplies the image. Spatial frequencies near the edge of what pixels can hold are folded, in a way that depends on the
fraction of the pixel; they are given little weight (``_PASS``).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter

from instrument.measurement import ImageValues
from instrument.reconstruction import inverse_hadamard
from protocols import Floats, InputError, Integers

_PASS: Final = 0.25  # cycles a pixel at which a spatial frequency has 1/e of its weight
_ROUNDS: Final = 40
_STANDS: Final = 0.01  # change of the places over their uncertainty at which they stand still
_ROOM_PX: Final = 4  # dark rim of the patch that holds the object
_VISIBLE: Final = 6.0  # standard deviations of the brightest spot of 3 x 3 px
_LEVEL: Final = 0.25  # of the object's brightness, above which a pixel belongs to it
_TWO: Final = 1.35  # misfit above which one object and what stands still do not explain the views
_STILL: Final = 5.0  # standard deviations of 3 x 3 px from which on something stands still
_FOLDED: Final = (
    0.05  # error of a shifted model, over the object's brightness, that sharp edges make by folded frequencies
)
_TURNS: Final = 10  # in which the object and what stands still are found, at most
_BETTER: Final = 0.995  # ratio of misfits above which another turn is not worth it
_PLANE: Final = 3  # numbers of the plane of brightness
_PLACE: Final = 2  # numbers of a place

_Complex = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class Registration:
    """Places of the object in all views."""

    place_px: Floats
    """``(views, 2)``: displacement x, y from the first view."""

    covariance_px2: Floats
    """``(views, 2, 2)``: covariance of each place; that of the difference of two is the sum."""

    box_px: tuple[float, float, float, float]
    """Left, top, right and bottom edge of the object in the first view."""

    misfit: float
    """Root mean square of what is left unexplained, over the noise."""

    still_share: float
    """Share of the light that stands still; 0 where none was found."""


def _means(picture: Floats, *, mode: Literal["reflect", "wrap"] = "reflect") -> Floats:
    """Mean over the 3 x 3 px around each pixel."""
    return np.asarray(uniform_filter(picture, 3, mode=mode), np.float64)


def registered(views: Sequence[ImageValues], names: Sequence[str]) -> Registration:
    """Register the static images of an object.

    Args:
        views: image values of each run.
        names: what messages call each view, such as ``"10 mm"``.

    Raises:
        InputError: no object, in all views or in one; an object that reaches the border of the field; more than one that moves.
    """
    size = views[0].size
    pictures = np.stack([inverse_hadamard(view.difference, view.pairs, size) for view in views])
    sigma = np.array([_pixel_sigma(view) for view in views])
    _refuse_nothing(pictures, sigma, names)
    found = _Group.of(pictures, sigma, np.zeros((size, size)), names)
    if found.misfit > _TWO or found.still_significance > _STILL:
        found = min([found, *_layered(pictures, sigma, names)], key=lambda each: each.misfit)
    if found.beyond:
        raise InputError(
            saw=f"an object that reaches the border of the field at {found.beyond}",
            expected="an object that is wholly inside the field at every position",
            remedy="leave out that position, or take a smaller object",
        )
    if found.misfit > _TWO:
        raise InputError(
            saw=f"images that one moving object does not explain: {found.misfit:.2g} times the noise is left",
            expected="one object that moves with the stage and neither turns nor changes",
            remedy="take a second moving object out of the light, look for reflections, and lower the light if counts are lost",
        )
    return found.registration()


def _layered(pictures: Floats, sigma: Floats, names: Sequence[str]) -> "list[_Group]":
    """Explain the views by the object and something that stands still, found in turn; nothing where that leads nowhere."""
    common = np.min([_means(picture) for picture in pictures], axis=0)
    still = np.where(common > _STILL * float(sigma.mean()) / 3, common, 0.0)
    groups: list[_Group] = []
    for _ in range(_TURNS):
        groups.append(_Group.of(pictures, sigma, still, names))
        if len(groups) > 1 and groups[-1].misfit > _BETTER * groups[-2].misfit:
            break
        still = groups[-1].remainder
    return groups


def _pixel_sigma(view: ImageValues) -> float:
    """Standard deviation of a pixel of the inverse transform; the mean is taken of patterns that were shown more than once."""
    flat = view.pairs[:, 0] * view.size + view.pairs[:, 1]
    shown = np.bincount(flat, minlength=view.size**2)
    variance = np.bincount(flat, weights=view.difference_variance, minlength=view.size**2) / np.maximum(shown, 1) ** 2
    return float(np.sqrt(variance.sum())) / view.size**2


@dataclass(frozen=True, eq=False)
class _Patches:
    """Cut-outs of the views, with the object in the middle of each to a fraction of a pixel."""

    pixels: Floats
    """``(views, height, width)``."""

    corner: Integers
    """``(views, 2)``: column and row of each cut-out's first pixel."""

    sigma: Floats
    """``(views,)``: standard deviation of a pixel."""

    @cached_property
    def frequency(self) -> tuple[Floats, Floats]:
        """Spatial frequencies along x and y, cycles a pixel, each ``(height, width)``."""
        height, width = self.pixels.shape[1:]
        fx, fy = np.meshgrid(np.fft.fftfreq(width), np.fft.fftfreq(height))
        return fx.astype(np.float64), fy.astype(np.float64)

    @cached_property
    def planes(self) -> Floats:
        """``(3, height, width)``: 1, x and y, in units of half the width and height."""
        height, width = self.pixels.shape[1:]
        x, y = np.meshgrid(np.linspace(-1, 1, width), np.linspace(-1, 1, height))
        return np.stack([np.ones((height, width)), x, y])


@dataclass(frozen=True, eq=False)
class _Group:
    """Views and what explains them."""

    pictures: Floats
    still: Floats
    patches: _Patches
    place_px: Floats
    covariance_px2: Floats
    template: Floats
    """``(height, width)`` of the object, in a patch."""
    models: Floats
    """``(views, size, size)``: the object in each view."""
    misfit: float
    beyond: str
    """View in which the object reaches the border of the field; empty where it does in none."""

    @classmethod
    def of(cls, pictures: Floats, sigma: Floats, still: Floats, names: Sequence[str]) -> "_Group":
        """Register the views, with what stands still taken off."""
        moving = pictures - still
        whole = _first_places(moving)
        box = _box(moving, whole)
        patches = _cut(moving, sigma, whole, box)
        fraction, planes = np.zeros((len(pictures), _PLACE)), np.tile([1.0, 0.0, 0.0], (len(pictures), 1))
        template = np.zeros_like(patches.pixels[0])
        covariance = np.zeros((len(pictures), _PLACE, _PLACE))
        for _ in range(_ROUNDS):
            template = _template(patches, fraction, planes)
            fraction, planes, covariance, change = _step(patches, fraction, planes, template)
            if change < _STANDS:
                break
        models = _models(patches, fraction, planes, template)
        level = _FOLDED * float(np.quantile(template, 0.9))
        left = (patches.pixels - models) / np.hypot(patches.sigma, level)[:, None, None]
        whole_models = np.zeros_like(pictures)
        for model, (column, row), into in zip(models, patches.corner.tolist(), whole_models, strict=True):
            _paste(model, column, row, into)
        beyond = _beyond(moving, sigma, float(np.quantile(template, 0.9)), names)
        misfit = float(np.sqrt(np.mean(_passed(left, patches) ** 2) / np.mean(_pass(patches) ** 2)))
        return cls(pictures, still, patches, whole + fraction, covariance, template, whole_models, misfit, beyond)

    @property
    def remainder(self) -> Floats:
        """``(size, size)``: what stands still, as the mean of what the object leaves of the views, where it stands out."""
        mean: Floats = np.mean(self.pictures - self.models, axis=0)
        bright = _means(mean) > _STILL / 2 * self._sigma_of_mean / 3
        return np.where(bright, mean, 0.0)

    @property
    def still_significance(self) -> float:
        """Brightest spot of 3 x 3 px that all views have beside the object, in standard deviations."""
        mean = np.mean(self.pictures - self.still - self.models, axis=0)
        return float(_means(mean).max()) * 3 / self._sigma_of_mean

    @property
    def _sigma_of_mean(self) -> float:
        return float(np.sqrt(np.sum(self.patches.sigma**2))) / len(self.pictures)

    def registration(self) -> Registration:
        """Give what others need of it."""
        left, top, right, bottom = _edges(self.template)
        column, row = self.patches.corner[0].tolist()
        light = float(self.models[0].sum())
        still = float(self.still.sum())
        return Registration(
            place_px=self.place_px - self.place_px[0],
            covariance_px2=self.covariance_px2,
            box_px=(column + left, row + top, column + right, row + bottom),
            misfit=self.misfit,
            still_share=still / (still + light) if still > 0 else 0.0,
        )


def _first_places(pictures: Floats) -> Floats:
    """Give the displacement of each picture from the first, ``(n, 2)`` x and y in whole pixels, by correlation."""
    from scipy.signal import fftconvolve  # noqa: PLC0415 - slow to load: only who registers pictures needs it

    size = pictures.shape[1]
    places: list[Floats] = []
    for picture in pictures:
        correlation = np.asarray(fftconvolve(picture, pictures[0][::-1, ::-1]), np.float64)
        row, column = np.unravel_index(int(np.argmax(correlation)), correlation.shape)
        places.append(np.array([column - (size - 1), row - (size - 1)], np.float64))
    return np.stack(places)


def _box(pictures: Floats, places: Floats) -> tuple[int, int, int, int]:
    """Give the first and last column and row of the object in the first picture: left, top, right, bottom."""
    size = pictures.shape[1]
    mean = np.zeros((size, size))
    for picture, (dx, dy) in zip(pictures, places.astype(int).tolist(), strict=True):
        mean += _shifted(picture, -dx, -dy) / len(pictures)
    left, top, right, bottom = _edges(mean)
    return round(left + 0.5), round(top + 0.5), round(right - 0.5), round(bottom - 0.5)


def _edges(picture: Floats) -> tuple[float, float, float, float]:
    """Left, top, right and bottom edge of what is bright in a picture; its first pixel reaches from -0.5 to 0.5."""
    bright = _means(picture)
    level = _LEVEL * float(np.quantile(bright[bright > _LEVEL * bright.max()], 0.75))
    rows, columns = np.flatnonzero((bright > level).any(axis=1)), np.flatnonzero((bright > level).any(axis=0))
    return float(columns[0]) - 0.5, float(rows[0]) - 0.5, float(columns[-1]) + 0.5, float(rows[-1]) + 0.5


def _shifted(picture: Floats, dx: int, dy: int) -> Floats:
    """Move a picture by whole pixels; what comes in is dark."""
    moved = np.zeros_like(picture)
    _paste(picture, dx, dy, moved)
    return moved


def _paste(part: Floats, column: int, row: int, into: Floats) -> None:
    """Put a picture into another one at this column and row, which may be outside of it."""
    height, width = into.shape
    top, left = max(0, row), max(0, column)
    bottom, right = min(height, row + part.shape[0]), min(width, column + part.shape[1])
    if bottom > top and right > left:
        into[top:bottom, left:right] = part[top - row : bottom - row, left - column : right - column]


def _cut(pictures: Floats, sigma: Floats, places: Floats, box: tuple[int, int, int, int]) -> _Patches:
    left, top, right, bottom = box
    corner = np.array([left - _ROOM_PX, top - _ROOM_PX]) + places.astype(np.int64)
    shape = (bottom - top + 1 + 2 * _ROOM_PX, right - left + 1 + 2 * _ROOM_PX)
    pixels = np.zeros((len(pictures), *shape))
    for picture, (column, row), into in zip(pictures, corner.tolist(), pixels, strict=True):
        _paste(picture, -column, -row, into)
    return _Patches(pixels, corner, sigma)


def _pass(patches: _Patches) -> Floats:
    """``(height, width)``: weight of each spatial frequency."""
    fx, fy = patches.frequency
    weight: Floats = np.exp(-(((fx**2 + fy**2) / _PASS**2) ** 2))
    return weight


def _passed(pixels: Floats, patches: _Patches) -> Floats:
    return np.fft.ifft2(np.fft.fft2(pixels) * _pass(patches)).real


def _phase(patches: _Patches, fraction: Floats) -> _Complex:
    """``(height, width)``: what a displacement by this fraction of a pixel multiplies the spectrum by."""
    fx, fy = patches.frequency
    phase: _Complex = np.exp(-2j * np.pi * (fx * fraction[0] + fy * fraction[1]))
    return phase


def _template(patches: _Patches, fraction: Floats, planes: Floats) -> Floats:
    """Give the Wiener mean of the views, shifted back and evenly lit."""
    weight = 1 / patches.sigma**2
    weight = weight / weight.sum()
    spectrum = np.zeros(patches.pixels.shape[1:], np.complex128)
    for pixels, place, plane, share in zip(patches.pixels, fraction, planes, weight, strict=True):
        even = pixels * (2 - np.einsum("p,pyx->yx", plane, patches.planes))
        spectrum += share * np.fft.fft2(even) * np.conj(_phase(patches, place))
    noise = _pixels(patches) / float(np.sum(1 / patches.sigma**2))
    power = _means(np.abs(spectrum) ** 2, mode="wrap")
    wiener = np.maximum(power - noise, 0.0) / np.maximum(power, 1e-300)
    return np.fft.ifft2(spectrum * wiener).real


def _pixels(patches: _Patches) -> int:
    """Pixels of a patch."""
    return int(patches.pixels[0].size)


def _models(patches: _Patches, fraction: Floats, planes: Floats, template: Floats) -> Floats:
    spectrum = np.fft.fft2(template)
    moved = np.stack([np.fft.ifft2(spectrum * _phase(patches, place)).real for place in fraction])
    models: Floats = moved * np.einsum("vp,pyx->vyx", planes, patches.planes)
    return models


def _step(
    patches: _Patches, fraction: Floats, planes: Floats, template: Floats
) -> tuple[Floats, Floats, Floats, float]:
    """Correct every view's place and brightness once.

    Returns:
        Places, planes, covariances of the places, and how far the places changed in standard deviations.
    """
    fx, fy = patches.frequency
    spectrum, weight = np.fft.fft2(template), _pass(patches)
    places, lights = fraction.copy(), planes.copy()
    covariances: list[Floats] = []
    for k, (pixels, sigma) in enumerate(zip(patches.pixels, patches.sigma, strict=True)):
        here = spectrum * _phase(patches, fraction[k])
        moved = np.fft.ifft2(here).real
        plane = np.einsum("p,pyx->yx", planes[k], patches.planes)
        slopes = [np.fft.ifft2(-2j * np.pi * frequency * here).real * plane for frequency in (fx, fy)]
        columns = np.stack([*slopes, *(moved * each for each in patches.planes)]).reshape(_PLACE + _PLANE, -1).T
        smooth = np.fft.ifft2(np.fft.fft2(columns.T.reshape(-1, *moved.shape)) * weight).real.reshape(
            columns.shape[1], -1
        )
        residual = (pixels - moved * plane).ravel()
        inverse = np.linalg.pinv(smooth @ columns)
        delta = inverse @ (smooth @ residual)
        covariance = sigma**2 * (inverse @ (smooth @ smooth.T) @ inverse.T)
        places[k] += np.clip(delta[:_PLACE], -0.5, 0.5)
        lights[k] += delta[_PLACE:]
        covariances.append(covariance[:_PLACE, :_PLACE])
    lights[:, 0] /= lights[:, 0].mean()
    lights[:, 1:] -= lights[:, 1:].mean(axis=0)
    places -= places.mean(axis=0)  # that all move together says nothing: the common image moves with them
    covariance = np.stack(covariances)
    change = float(np.max(np.abs(places - fraction) / np.sqrt(np.diagonal(covariance, axis1=1, axis2=2))))
    return places, lights, covariance, change


def _refuse_nothing(pictures: Floats, sigma: Floats, names: Sequence[str]) -> None:
    """Refuse views without an object."""
    seen = [float(_means(picture).max()) * 3 / each for picture, each in zip(pictures, sigma, strict=True)]
    dark = [name for name, strength in zip(names, seen, strict=True) if strength < _VISIBLE]
    if 2 * len(dark) > len(names):
        raise InputError(
            saw=f"no object in {len(dark)} of {len(names)} images: nothing in them stands out of the noise",
            expected="an object in the field, brighter than the noise",
            remedy="look at one image first (kinopix run without [motion]); check object, focus, shutter and light",
        )
    if dark:
        raise InputError(
            saw=f"no object in the image at {', '.join(dark)}, though there is one at other positions",
            expected="the object inside the field at every position",
            remedy="choose positions between those where the object was seen",
        )


def _beyond(pictures: Floats, sigma: Floats, level: float, names: Sequence[str]) -> str:
    """Name the first picture that is bright at the border of the field, beyond which nobody sees the object."""
    for name, picture, noise in zip(names, pictures, sigma, strict=True):
        bright = _means(picture)
        border = np.concatenate([bright[:1].ravel(), bright[-1:].ravel(), bright[:, 0], bright[:, -1]])
        if float(border.max()) > max(_LEVEL * level, _VISIBLE * float(noise) / 3):
            return name
    return ""

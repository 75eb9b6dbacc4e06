"""Products of shifted Hadamard patterns with an image, computed through the few sign changes of their Walsh rows.

A pattern is the outer product of two Walsh rows. Along the axis u on which it changes sign less often, its product with the
image is a weighted sum of few rows of the image's cumulative sum along u. The dot product of that sum with the Walsh row along
the other axis v gives the value. For the 1,666 smoothest patterns of 128 x 128 pixels that takes 17 weighted rows in the mean,
where a matrix product takes 128. Patterns that change sign often along both axes are quicker as matrix products: see
``DenseProducts``.
"""

from dataclasses import dataclass
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from instrument.numerics.compiled import compiled, inlined
from protocols import Singles

_Indices: TypeAlias = NDArray[np.int32]
_LANES = 16  # single-precision numbers that a processor handles at once; rows are padded to whole groups of them
_CACHE_BYTES: Final = 2 << 20
"""Rows of ``many`` that are worked on at a time: about what the caches next to a core hold. Going through all of them anew for
each row of a large image would wait for the memory, five times as long as the arithmetic takes."""

_FEWEST_TERMS: Final = 192
"""Terms that a row of the image gets from them at least: fewer are not worth the way to the row and back."""


@dataclass(frozen=True, eq=False)
class RowProducts:
    """Products of the patterns few(u) many(v) with images ``(length, width)``, u counting rows and v columns."""

    _few: csr_array
    """``(patterns, length)``: weights of the rows of the cumulative image."""

    _few_transposed: csr_array
    """``(blocks length, patterns)``: the transpose of ``_few``, for each block of patterns by itself."""

    _many: Singles
    """``(patterns, width)``: the factor along v, padded with zeros."""

    @classmethod
    def of(cls, few: csr_array, many: Singles, *, block: int | None = None) -> "RowProducts":
        """Prepare the products of some patterns.

        Args:
            few: ``(patterns, length)`` factor along u as ``walsh_changes`` gives it.
            many: ``(patterns, width)`` factor along v as ``walsh_rows`` gives it.
            block: patterns that are summed before the next; None takes as many as the cache holds.
        """
        padded = np.zeros((len(many), _padded(many.shape[1])), np.float32)
        padded[:, : many.shape[1]] = many
        if block is None:
            in_cache = _CACHE_BYTES // max(1, padded.itemsize * padded.shape[1])
            block = max(in_cache, _FEWEST_TERMS * few.shape[1] * few.shape[0] // max(1, few.nnz), 1)
        return cls(_compact(few), _compact(_transposed(few, block)), padded)

    @property
    def nbytes(self) -> int:
        """Memory of the factors, in bytes."""
        return self._many.nbytes + sum(
            part.nbytes for few in (self._few, self._few_transposed) for part in (few.data, few.indices, few.indptr)
        )

    def forward(self, image: Singles) -> Singles:
        """Give the values, ``(patterns,)``, of an image ``(length, width)`` of any memory layout."""
        cumulative = np.zeros((image.shape[0], self._many.shape[1]), np.float32)
        _accumulate(image, cumulative)
        values = np.empty(len(self._many), np.float32)
        _forward(cumulative, self._few.indptr, self._few.indices, self._few.data, self._many, values)
        return values

    def backward(self, values: Singles, width: int) -> Singles:
        """Apply the transpose: ``(patterns,)`` to ``(length, width)``."""
        image = np.empty((self._few.shape[1], self._many.shape[1]), np.float32)
        _backward(
            self._many,
            self._few_transposed.indptr,
            self._few_transposed.indices,
            self._few_transposed.data,
            values,
            image,
        )
        return image[:, :width]


def _transposed(few: csr_array, block: int) -> csr_array:
    """Give the transpose of ``(patterns, length)`` for each block of patterns by itself, one under the other."""
    patterns, length = few.shape
    pattern = np.repeat(np.arange(patterns), np.diff(few.indptr))
    row = pattern // block * length + few.indices
    return csr_array((few.data, (row, pattern)), shape=(max(1, -(-patterns // block)) * length, patterns))


def _padded(width: int) -> int:
    return -(-width // _LANES) * _LANES


def _compact(matrix: csr_array) -> csr_array:
    data, indices, indptr = (
        matrix.data.astype(np.float32),
        matrix.indices.astype(np.int32),
        matrix.indptr.astype(np.int32),
    )
    return csr_array((data, indices, indptr), shape=matrix.shape)


@compiled("void(f4[:, :], f4[:, ::1])", sums_reordered=True)
def _accumulate(image: Singles, cumulative: Singles) -> None:
    """Write the cumulative sum of an image's rows."""
    height, width = image.shape
    for x in range(width):
        cumulative[0, x] = image[0, x]
    for y in range(1, height):
        for x in range(width):
            cumulative[y, x] = cumulative[y - 1, x] + image[y, x]


@inlined
def _weighted_sum(rows: Singles, which: _Indices, weight: Singles, total: Singles) -> None:
    """Write the sum of ``weight * rows[which]`` into ``total``.

    Four rows are added at a time, as ``total`` then moves to memory and back a quarter as often.
    """
    total[:] = 0
    fours = len(which) // 4 * 4
    for m in range(0, fours, 4):
        a, b, c, d = rows[which[m]], rows[which[m + 1]], rows[which[m + 2]], rows[which[m + 3]]
        of_a, of_b, of_c, of_d = weight[m], weight[m + 1], weight[m + 2], weight[m + 3]
        for x in range(len(total)):
            total[x] += (of_a * a[x] + of_b * b[x]) + (of_c * c[x] + of_d * d[x])
    for m in range(fours, len(which)):
        a, of_a = rows[which[m]], weight[m]
        for x in range(len(total)):
            total[x] += of_a * a[x]


@compiled("void(f4[:, ::1], i4[::1], i4[::1], f4[::1], f4[:, ::1], f4[::1])", sums_reordered=True)
def _forward(  # noqa: PLR0917
    cumulative: Singles, first: _Indices, column: _Indices, weight: Singles, many: Singles, values: Singles
) -> None:
    """Multiply each row of the sparse matrix with the cumulative image, then the result with its row of ``many``."""
    row = np.empty(many.shape[1], np.float32)
    for k in range(len(values)):
        own = slice(first[k], first[k + 1])
        _weighted_sum(cumulative, column[own], weight[own], row)
        value = np.float32(0)
        for x in range(len(row)):
            value += row[x] * many[k, x]
        values[k] = value


@compiled("void(f4[:, ::1], i4[::1], i4[::1], f4[::1], f4[::1], f4[:, ::1])", sums_reordered=True)
def _backward(  # noqa: PLR0917
    many: Singles, first: _Indices, column: _Indices, weight: Singles, values: Singles, image: Singles
) -> None:
    """Multiply the transposed sparse matrix with ``values * many``, and sum from the last row of the image upwards."""
    scaled = np.empty_like(weight)
    for m in range(len(weight)):
        scaled[m] = weight[m] * values[column[m]]
    row = np.empty(many.shape[1], np.float32)
    length = len(image)
    for u in range(len(first) - 1):
        own = slice(first[u], first[u + 1])
        _weighted_sum(many, column[own], scaled[own], row)
        for x in range(len(row)):
            image[u % length, x] = row[x] if u < length else image[u % length, x] + row[x]
    for u in range(length - 2, -1, -1):
        for x in range(len(row)):
            image[u, x] += image[u + 1, x]

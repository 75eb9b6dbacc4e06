"""Matrix products against the sums that they stand for, in whole numbers, and parts on one core and on several."""

import threading

import numba
import numpy as np
import pytest

from instrument.numerics import DenseProducts, side_by_side
from protocols import Singles


def test_values_and_images_are_sums_over_pixels_and_patterns() -> None:
    rng = np.random.default_rng(0)

    def whole(*shape: int) -> Singles:
        return rng.integers(-3, 4, shape).astype(np.float32)

    down, across, image, values = whole(2500, 5), whole(2500, 7), whole(5, 7), whole(2500)  # more than two blocks
    products = DenseProducts(down, across)
    np.testing.assert_array_equal(products.forward(image), np.einsum("ku,uv,kv->k", down, image, across))
    np.testing.assert_array_equal(products.backward(values), np.einsum("k,ku,kv->uv", values, down, across))
    assert products.nbytes == 4 * 2500 * 12


@pytest.mark.skipif(numba.get_num_threads() < 2, reason="one core")
def test_parts_meet_on_two_cores_and_keep_their_order_on_one() -> None:
    together = threading.Barrier(2, timeout=10)  # passes only where both are under way
    assert side_by_side([lambda: together.wait() >= 0, lambda: together.wait() >= 0]) == [True, True]
    threads = numba.get_num_threads()
    numba.set_num_threads(1)
    try:
        order: list[int] = []
        side_by_side([lambda: order.append(1), lambda: order.append(2)])
        assert order == [1, 2]
        assert side_by_side([threading.get_ident, threading.get_ident]) == [threading.get_ident()] * 2
    finally:
        numba.set_num_threads(threads)

"""Compiled loops: what they take, and where they are kept."""

import numpy as np
import pytest

from instrument.numerics.compiled import compiled
from protocols import Floats


def _total(series: Floats) -> float:
    total = 0.0
    for value in series:
        total += value
    return total


def test_an_array_of_another_type_is_refused_and_not_compiled_for() -> None:
    total = compiled("f8(f8[::1])")(_total)

    assert total(np.array([1.0, 2.5])) == 3.5
    with pytest.raises(TypeError, match="No matching definition"):
        total(np.ones(3, np.float32))  # pyright: ignore[reportArgumentType]
    with pytest.raises(TypeError, match="No matching definition"):
        total(np.ones(6)[::2])


def test_where_no_folder_can_be_written_to_it_is_compiled_for_this_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """A read-only installation without a home, as in a container."""
    monkeypatch.setattr("numba.core.caching.CompileResultCacheImpl._locator_classes", [])

    assert compiled("f8(f8[::1])", sums_reordered=True)(_total)(np.arange(5.0)) == 10

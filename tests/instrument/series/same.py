"""Whether two files hold the same analysis."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from tests.support.plain_hdf5 import array, text

ARRAYS = ("track/displacement_px", "track/sigma_px", "image/image")


def figures(path: Path) -> dict[str, Any]:
    """Give the figures of an analysis without the time that it took."""
    table: dict[str, Any] = json.loads(text(path, "/entry/analysis/table"))
    del table["analysis_s"]
    return table


def assert_same_analysis(ours: Path, theirs: Path) -> None:
    """Hold two analyses against each other, to the bit."""
    for name in ARRAYS:
        np.testing.assert_array_equal(array(ours, f"/entry/analysis/{name}"), array(theirs, f"/entry/analysis/{name}"))
    assert figures(ours) == figures(theirs)

"""NeXus tools find their way."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from instrument.plan import Plan
from instrument.storage import RecordingWriter, write_analysis
from tests.support import plain_hdf5 as plain

PLAN = Plan(frames=4, image_size=8)


def nxload(path: Path) -> Any:
    """Load by nexusformat."""
    nexus: Any = pytest.importorskip("nexusformat.nexus")
    return nexus.nxload(path)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    path = tmp_path / "run.h5"
    with RecordingWriter(path, PLAN, picture_time_s=50e-6) as writer:
        writer.append(np.arange(24.0), np.arange(24.0) * 50e-6)
        writer.finish()
    return path


def test_the_default_plot_is_the_values_before_an_analysis(path: Path) -> None:
    default = nxload(path).plottable_data
    assert default.nxpath == "/entry/data"
    assert default.nxsignal.nxname == "values"
    np.testing.assert_array_equal(default.nxsignal.nxvalue, np.arange(24.0).reshape(4, 6))


def test_the_default_plot_is_the_image_after_an_analysis(path: Path) -> None:
    image = np.arange(64.0).reshape(8, 8)
    write_analysis(path, displacement_px=np.zeros((4, 2)), image=image)
    default = nxload(path).plottable_data
    assert default.nxpath == "/entry/analysis/image"
    np.testing.assert_array_equal(default.nxsignal.nxvalue, image)
    assert [axis.nxname for axis in default.nxaxes] == ["y_px", "x_px"]


def test_every_group_has_its_class_and_every_number_its_unit(path: Path) -> None:
    """A name that ends on a unit must agree with the ``units`` attribute."""
    write_analysis(path, displacement_px=np.zeros((4, 2)), image=np.eye(8))
    units = {"_s": "s", "_hz": "Hz", "_px": "px"}
    with plain.opened(path) as file:
        items: dict[str, Any] = {}
        file.visititems(items.__setitem__)
        groups = {name: item.attrs.get("NX_class") for name, item in items.items() if not hasattr(item, "dtype")}
        stated = {
            name: item.attrs.get("units")
            for name, item in items.items()
            if hasattr(item, "dtype") and any(name.endswith(end) for end in units)
        }
    assert all(groups.values())
    assert groups["entry/instrument/counter"] == "NXdetector"
    assert len(stated) == 9
    for name, unit in stated.items():
        assert unit == next(unit for end, unit in units.items() if name.endswith(end)), name

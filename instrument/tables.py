"""Arrays handed on to pandas and xarray, where they are installed."""

import importlib
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from protocols import Floats, InputError, Mask


def data_frame(columns: Mapping[str, Floats | Mask], index: str) -> Any:
    """Give a ``pandas.DataFrame``.

    Args:
        columns: arrays of one length by name.
        index: name of the rows' numbers.

    Raises:
        InputError: pandas is not installed.
    """
    pandas = _library("pandas")
    length = len(next(iter(columns.values())))
    return pandas.DataFrame(dict(columns), index=pandas.RangeIndex(length, name=index))


def data_set(
    variables: Mapping[str, tuple[Sequence[str], Floats | Mask]],
    coordinates: Mapping[str, tuple[Sequence[str], Floats]],
    attributes: Mapping[str, str | float],
    units: Mapping[str, str],
) -> Any:
    """Give an ``xarray.Dataset``.

    Args:
        variables: dimensions and array by name.
        coordinates: likewise.
        attributes: of the whole.
        units: by name of a variable or a coordinate.

    Raises:
        InputError: xarray is not installed.
    """
    xarray = _library("xarray")

    def labelled(name: str, dimensions: Sequence[str], array: Floats | Mask) -> Any:
        return tuple(dimensions), np.asarray(array), {"units": units[name]} if name in units else {}

    return xarray.Dataset(
        {name: labelled(name, *value) for name, value in variables.items()},
        {name: labelled(name, *value) for name, value in coordinates.items()},
        dict(attributes),
    )


def _library(name: str) -> Any:
    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise InputError(
            saw=f"no library {name}", expected=f"{name} beside Kinopix", remedy=f"pip install {name}"
        ) from error

"""Figures as JSON that every program reads."""

import json
import math
from collections.abc import Mapping
from typing import Any, cast

import numpy as np


def json_text(value: object, indent: int | None = None) -> str:
    """``value`` as JSON. JSON knows no NaN and no infinity: a number that is not finite becomes ``null``.

    Raises:
        TypeError: something that is neither a number, text, truth value, None, list, mapping nor array of numpy.
    """
    return json.dumps(_plain(value), indent=indent, allow_nan=False)


def _plain(value: object) -> object:
    if isinstance(value, np.generic | np.ndarray):
        return _plain(cast("np.ndarray[Any, Any]", value).tolist())
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in cast("Mapping[object, object]", value).items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in cast("list[object]", value)]
    if value is None or isinstance(value, str | int):
        return value
    raise TypeError(f"{type(value).__name__} cannot be stored as JSON")

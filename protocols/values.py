"""What the values of all three protocols share: frozen models, array types, identity."""

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict

from protocols.field_docs import ModelType

Floats: TypeAlias = NDArray[np.float64]
"""Real numbers in double precision."""

Singles: TypeAlias = NDArray[np.float32]
"""Real numbers in single precision: relative rounding 6e-8, far below any measured noise."""

Bytes: TypeAlias = NDArray[np.uint8]
"""Packed bit planes, or grey values 0 to 255."""

Integers: TypeAlias = NDArray[np.int64]
"""Indices and exact counts."""

Mask: TypeAlias = NDArray[np.bool_]
"""Booleans, True where the thing named holds."""


class Frozen(BaseModel, metaclass=ModelType):
    """A value: it cannot change, and a key that it does not know is an error."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class DeviceIdentity(Frozen):
    """Identity of a device, for the recording and for every error message."""

    name: str
    """Short name that errors carry, such as ``dmd``, ``pmt`` or ``stage``."""

    vendor: str
    """Maker of the device."""

    model: str
    """Name of the model, as the maker writes it."""

    serial: str = ""
    """Serial number, empty where the device does not tell."""

    firmware: str = ""
    """Firmware version, empty where the device does not tell."""

    driver: str = ""
    """Name of the driver plug-in, and version of the vendor library under it."""

    simulated: bool = False
    """True where no hardware stands behind it."""

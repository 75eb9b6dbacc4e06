"""pyserial URLs of the emulators: ``serial.serial_for_url("kinopix-mc600://", timeout=1)`` after ``register_urls()``."""

from collections.abc import Callable, Generator
from contextlib import contextmanager
from functools import partial
from typing import TypeVar
from urllib.parse import parse_qsl, urlsplit

import serial
from pydantic import ValidationError

from sim_backends.bench import BenchClock, VirtualClock
from sim_backends.wire.zolix.controller import Controller
from sim_backends.wire.zolix.mc600 import mc600_controller
from sim_backends.wire.zolix.port import EmulatedPort
from sim_backends.wire.zolix.sc300 import sc300_controller
from sim_backends.wire.zolix.settings import ControllerSettings, Mc600Settings, Sc300Settings

_PACKAGE = "sim_backends.wire.zolix.urls"

_published: dict[str, Controller] = {}

SettingsT = TypeVar("SettingsT", bound=ControllerSettings)


def register_urls() -> None:
    """Make ``kinopix-mc600://`` and ``kinopix-sc300://`` known to pyserial in this process.

    ``kinopix-mc600://?lead_mm=5&busy_policy=mute`` switches a box of its own on, in its own virtual time;
    ``kinopix-mc600://NAME`` is the one that ``publish`` gave this name.
    """
    if _PACKAGE not in serial.protocol_handler_packages:
        serial.protocol_handler_packages.append(_PACKAGE)


@contextmanager
def publish(name: str, controller: Controller) -> Generator[None]:
    """Let URLs reach a controller by name, so that it shares a bench's time and scene."""
    _published[name] = controller
    try:
        yield
    finally:
        del _published[name]


def _connect(
    model: type[SettingsT], build: Callable[[SettingsT, BenchClock], Controller], url: str | None
) -> Controller:
    parts = urlsplit(url or "")
    if parts.netloc:
        if parts.netloc not in _published:
            raise serial.SerialException(f"{url}: no emulated controller is published as {parts.netloc!r}")
        return _published[parts.netloc]
    try:
        settings = model.model_validate(dict(parse_qsl(parts.query)))
    except ValidationError as error:
        raise serial.SerialException(f"{url}: {error}") from error
    return build(settings, VirtualClock())


Handler = tuple[str, Callable[..., EmulatedPort]]
"""What pyserial wants of a URL: the port name, and what builds the port."""


def mc600_url(url: str) -> Handler:
    """Handle ``kinopix-mc600://``."""
    return url, partial(EmulatedPort, partial(_connect, Mc600Settings, mc600_controller))


def sc300_url(url: str) -> Handler:
    """Handle ``kinopix-sc300://``."""
    return url, partial(EmulatedPort, partial(_connect, Sc300Settings, sc300_controller))

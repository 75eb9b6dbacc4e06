"""Entry points that give what cannot serve."""

from pydantic import BaseModel

from protocols import BenchContext, DriverPlugin, Frozen


class Loose(BaseModel):
    """Settings that ignore a key they do not know."""

    gain: float = 1.0


class Greedy(Frozen):
    """Settings with a key that belongs to the framework."""

    transport: str = "usb"


def open_device(settings: BaseModel, context: BenchContext) -> BaseModel:
    """Give back what was given."""
    del context
    return settings


class Device:
    """A device where a plug-in belongs."""


loose = DriverPlugin("Takes anything", Loose, open_device)
greedy = DriverPlugin("Takes the framework's key", Greedy, open_device)

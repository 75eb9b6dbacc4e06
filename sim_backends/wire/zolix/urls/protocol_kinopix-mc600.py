"""``kinopix-mc600://``: pyserial looks for a module of this name and asks it for the port class."""  # noqa: N999

from sim_backends.wire.zolix.url import mc600_url as serial_class_for_url

__all__ = ["serial_class_for_url"]

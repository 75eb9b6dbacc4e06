"""Zolix MC600 and SC300 controllers, over a serial line, moving a KA400Z linear stage."""

"""Zolix KA400Z linear stage on the Zolix MC600 and SC300 controllers, over a serial line."""

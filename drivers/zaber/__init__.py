"""Zaber stages that speak Zaber's ASCII protocol (fact sheet zaber-and-grbl, section 2), written without a device at hand."""

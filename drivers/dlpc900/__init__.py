"""TI's DLPC900 controller (LightCrafter 6500 and 9000) over USB-HID (fact sheet dlpc900), written without a device at hand."""

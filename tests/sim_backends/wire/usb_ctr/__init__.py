"""The emulated USB-CTR, driven as the package usb1 drives one."""

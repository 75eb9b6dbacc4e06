"""The emulated USB-CTR, driven through pyusb."""

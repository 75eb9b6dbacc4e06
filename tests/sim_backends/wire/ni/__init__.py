"""The emulated NI board, driven by the real nidaqmx client."""

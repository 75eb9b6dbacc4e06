"""A NI board with two analogue inputs behind a gRPC device server: the detector's voltage, and the sync line.

Written from NI's remote interface (``nidaqmx.proto``) and the hardware sheet, never from the driver.
"""

"""Counter boards of National Instruments, through NI-DAQmx, reading an H10682 head (``drivers.h10682``)."""

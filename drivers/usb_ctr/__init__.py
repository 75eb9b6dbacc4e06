"""USB-CTR counter boards of Measurement Computing, over USB, reading an H10682 head (``drivers.h10682``)."""

"""Hamamatsu H10682 photon-counting head, read by an NI counter (``ni``) or an MCC USB-CTR board (``usb_ctr``)."""

"""Hamamatsu H10682 photon-counting head: what its drivers share, whichever counter board reads it (``ni``, ``usb_ctr``)."""

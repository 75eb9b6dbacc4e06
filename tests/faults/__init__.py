"""Every fault of the hardware sheets, through the whole instrument: a typed error or a flagged frame, no hang, no lost count."""

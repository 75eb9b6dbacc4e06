"""What a lab measures of its bench before it measures with it: real displacement, detector, mirrors, light, alignment.

Each measurement is a section of the calibration file (``instrument.config.Calibration``).
"""

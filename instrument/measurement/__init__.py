"""The light model and the one ``Measurement`` that every estimator is given."""

from instrument.measurement.detector import Detector, light_of, noise_variance
from instrument.measurement.image_values import ImageValues, fixed_columns
from instrument.measurement.measurement import Measurement

__all__ = ["Detector", "ImageValues", "Measurement", "fixed_columns", "light_of", "noise_variance"]

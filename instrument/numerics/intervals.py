"""Intervals that hold a number with a stated probability."""

from scipy.special import ndtri, stdtrit


def coverage_factor(degrees_of_freedom: int | None, probability: float = 0.95) -> float:
    """Give the number of standard uncertainties to either side of a result, within which the truth is with this probability.

    Args:
        degrees_of_freedom: behind the standard uncertainty, for Student's t; None where the uncertainty itself is known.
        probability: of the interval.
    """
    side = (1 + probability) / 2
    return float(ndtri(side) if degrees_of_freedom is None else stdtrit(degrees_of_freedom, side))

"""The one place where a plan's scheme name becomes a scheme."""

from instrument.plan import Plan
from instrument.schemes.fourier_hadamard import FourierHadamard


def scheme_of(plan: Plan) -> FourierHadamard:
    """Give the scheme that ``plan`` names."""
    return FourierHadamard(plan)

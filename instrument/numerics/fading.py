"""A parabola through the past of a series by weighted least squares, one datum after the other, in constant memory.

Of data z at times u with weights w, the sums of w u^k for k from 0 to 4 ("powers") and of w u^k z for k from 0 to 2 ("moments")
are kept. Time is in units of some duration that keeps all sums of similar size. With fading weights, w = theta^age, u is the age
of a datum, 0 for the newest; with equal weights, w = 1, u is counted from the first datum on.

References:
    Morrison, "Introduction to Sequential Smoothing and Prediction" (1969), chapter 13: fading-memory polynomial filters.
"""

from instrument.numerics.compiled import inlined
from protocols import Floats


@inlined
def age(powers: Floats, moments: Floats, theta: float, step: float) -> None:
    """Add ``step`` to the age u of all data, and multiply their weights by ``theta``.

    Args:
        powers: ``(5,)`` sums of w u^k; overwritten.
        moments: ``(series, 3)`` sums of w u^k z; overwritten.
        theta: share of its weight that a datum keeps.
        step: time to add, in the unit of u.
    """
    for k in range(4, -1, -1):
        # (u + step)^k by the binomial theorem
        binomial, power, total = 1.0, 1.0, powers[k]
        for lower in range(k - 1, -1, -1):
            binomial *= (lower + 1) / (k - lower)
            power *= step
            total += binomial * power * powers[lower]
        powers[k] = theta * total
    for series in range(len(moments)):
        old = moments[series]
        old[2] = theta * (old[2] + 2 * step * old[1] + step * step * old[0])
        old[1] = theta * (old[1] + step * old[0])
        old[0] = theta * old[0]


@inlined
def add(powers: Floats, moments: Floats, time: float, data: Floats) -> None:
    """Add one datum of each series, ``(series,)``, at the time u, with weight 1."""
    power = 1.0
    for k in range(5):
        powers[k] += power
        if k < 3:
            for series in range(len(moments)):
                moments[series, k] += power * data[series]
        power *= time


@inlined
def solve(powers: Floats, moments: Floats, count: int, step: float, curve: Floats) -> float:
    """Find the parabola a + b u + c u^2 of each series.

    Through one datum it is constant. Through two data, at u = 0 and one step from it, it is the one of least b^2 + c^2, b and c
    taken per step.

    Args:
        powers: ``(5,)`` sums of w u^k.
        moments: ``(series, 3)`` sums of w u^k z.
        count: number of data added.
        step: time from one datum to the next, in the unit of u.
        curve: ``(series, 3)``; receives a, b, c.

    Returns:
        The derivative of a with respect to a datum of weight 1 at u = 0: the newest datum's leverage on its own fit.
    """
    if count < 3:
        # The sums of w and w u determine both data; their difference is divided equally between b and c.
        for series in range(len(curve)):
            curve[series] = 0
            if count == 1:
                curve[series, 0] = moments[series, 0] / powers[0]
            else:
                far = moments[series, 1] / powers[1]
                near = (moments[series, 0] - powers[1] / step * far) / (powers[0] - powers[1] / step)
                curve[series, 0] = near
                curve[series, 1], curve[series, 2] = (far - near) / (2 * step), (far - near) / (2 * step * step)
        return 1.0  # the parabola passes through the datum
    s0, s1, s2, s3, s4 = powers[0], powers[1], powers[2], powers[3], powers[4]
    # The cofactors of the normal matrix ((s0, s1, s2), (s1, s2, s3), (s2, s3, s4)).
    aa, ab, ac = s2 * s4 - s3 * s3, s2 * s3 - s1 * s4, s1 * s3 - s2 * s2
    bb, bc, cc = s0 * s4 - s2 * s2, s1 * s2 - s0 * s3, s0 * s2 - s1 * s1
    determinant = s0 * aa + s1 * ab + s2 * ac
    for series in range(len(curve)):
        m0, m1, m2 = moments[series, 0], moments[series, 1], moments[series, 2]
        curve[series, 0] = (aa * m0 + ab * m1 + ac * m2) / determinant
        curve[series, 1] = (ab * m0 + bb * m1 + bc * m2) / determinant
        curve[series, 2] = (ac * m0 + bc * m1 + cc * m2) / determinant
    leverage: float = aa / determinant
    return leverage

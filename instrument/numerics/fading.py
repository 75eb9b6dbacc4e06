"""A parabola through the past of a series, by weighted least squares, one datum after the other in constant memory.

Of the data z at the times u (in units of some length, so that all sums are of one size) it keeps the sums of w u^k, k from 0
to 4, and those of w u^k z, k from 0 to 2. Fading weights, w = kept^age, count time backwards from the newest datum; plain
weights, w = 1, count it from the first one on.

References:
    Morrison, "Introduction to Sequential Smoothing and Prediction" (1969), chapter 13: fading-memory polynomial filters.
"""

from instrument.numerics.compiled import inlined
from protocols import Floats


@inlined
def grow_older(powers: Floats, moments: Floats, kept: float, step: float) -> None:
    """Put all data back by ``step``, and multiply their weights by ``kept``.

    Args:
        powers: ``(5,)``: sums of w u^k.
        moments: ``(series, 3)``: sums of w u^k z.
        kept: share of its weight that a datum keeps.
        step: in the unit of u.
    """
    for k in range(4, -1, -1):
        choose, power, total = 1.0, 1.0, powers[k]
        for lower in range(k - 1, -1, -1):
            choose *= (lower + 1) / (k - lower)
            power *= step
            total += choose * power * powers[lower]
        powers[k] = kept * total
    for series in range(len(moments)):
        old = moments[series]
        old[2] = kept * (old[2] + 2 * step * old[1] + step * step * old[0])
        old[1] = kept * (old[1] + step * old[0])
        old[0] = kept * old[0]


@inlined
def add(powers: Floats, moments: Floats, time: float, data: Floats) -> None:
    """Take in one datum of each series, ``(series,)``, at a time u, with weight 1."""
    power = 1.0
    for k in range(5):
        powers[k] += power
        if k < 3:
            for series in range(len(moments)):
                moments[series, k] += power * data[series]
        power *= time


@inlined
def solve(powers: Floats, moments: Floats, count: int, step: float, curve: Floats) -> float:
    """Find the parabolas a + b u + c u^2.

    Through one datum it is that datum; through two, ``step`` apart, the one of least b^2 + c^2, b and c taken per step.

    Args:
        powers: ``(5,)``.
        moments: ``(series, 3)``.
        count: how many data there were.
        step: from one datum to the next.
        curve: ``(series, 3)``: receives a, b, c.

    Returns:
        The change of a with a datum of weight 1 at u = 0: the newest one's own share in its answer.
    """
    if count < 3:
        # Sums of w and w u determine both data; equal parts of their difference go into b and c.
        for series in range(len(curve)):
            curve[series] = 0
            if count == 1:
                curve[series, 0] = moments[series, 0] / powers[0]
            else:
                far = moments[series, 1] / powers[1]
                near = (moments[series, 0] - powers[1] / step * far) / (powers[0] - powers[1] / step)
                curve[series, 0] = near
                curve[series, 1], curve[series, 2] = (far - near) / (2 * step), (far - near) / (2 * step * step)
        return 1.0  # it is met exactly
    s0, s1, s2, s3, s4 = powers[0], powers[1], powers[2], powers[3], powers[4]
    # Cofactors of the normal matrix ((s0, s1, s2), (s1, s2, s3), (s2, s3, s4)).
    aa, ab, ac = s2 * s4 - s3 * s3, s2 * s3 - s1 * s4, s1 * s3 - s2 * s2
    bb, bc, cc = s0 * s4 - s2 * s2, s1 * s2 - s0 * s3, s0 * s2 - s1 * s1
    whole = s0 * aa + s1 * ab + s2 * ac
    for series in range(len(curve)):
        m0, m1, m2 = moments[series, 0], moments[series, 1], moments[series, 2]
        curve[series, 0] = (aa * m0 + ab * m1 + ac * m2) / whole
        curve[series, 1] = (ab * m0 + bb * m1 + bc * m2) / whole
        curve[series, 2] = (ac * m0 + bc * m1 + cc * m2) / whole
    share: float = aa / whole
    return share

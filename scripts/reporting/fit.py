# SPDX-License-Identifier: GPL-3.0-or-later
"""Power laws through measured points."""
import math
from typing import NamedTuple

# 0.975 quantiles of Student's t for 1, 2, ... degrees of freedom
T_QUANTILES = (12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228)
FIT_POINTS = 25  # of a drawn fit, which is bent where an axis is linear


class PowerLaw(NamedTuple):
    """y = factor · x ^ slope; the slope lies within slope ± half_width_95 with 95 % confidence."""
    slope: float
    half_width_95: float
    factor: float


def t_quantile(freedom):
    """Beyond the table by Cornish and Fisher's expansion, which is good to 0.2 % there."""
    if freedom <= len(T_QUANTILES):
        return T_QUANTILES[freedom - 1]
    z = 1.959964
    return z + (z ** 3 + z) / (4 * freedom) + (5 * z ** 5 + 16 * z ** 3 + 3 * z) / (96 * freedom ** 2)


def usable(points):
    """(x, y) of those that have a logarithm."""
    pairs = [point[:2] for point in points if None not in point[:2]]
    return [(x, y) for x, y in pairs if 0 < x < math.inf and 0 < y < math.inf]


def power_law(points):
    """Least squares in the logarithms of x and y, all points alike; more entries of a point than two are not looked at.
    Points that are not positive are left out. Two points leave the half width infinite; ValueError where fewer than two
    different x are left."""
    logs = [(math.log(x), math.log(y)) for x, y in usable(points)]
    if len({x for x, _ in logs}) < 2:
        raise ValueError("a power law needs points at two or more different, positive x")
    mean_x = math.fsum(x for x, _ in logs) / len(logs)
    mean_y = math.fsum(y for _, y in logs) / len(logs)
    spread = math.fsum((x - mean_x) ** 2 for x, _ in logs)
    slope = math.fsum((x - mean_x) * (y - mean_y) for x, y in logs) / spread
    offset = mean_y - slope * mean_x
    freedom = len(logs) - 2
    if not freedom:
        return PowerLaw(slope, math.inf, math.exp(offset))
    left = math.fsum((y - offset - slope * x) ** 2 for x, y in logs)
    return PowerLaw(slope, t_quantile(freedom) * math.sqrt(left / freedom / spread), math.exp(offset))


def line(points):
    """(offset, slope) of y = offset + slope · x by least squares of relative errors: each point counts by 1 / y²."""
    rows = [(1 / y, x / y) for x, y in points]
    a, b, c = (math.fsum(r[i] * r[j] for r in rows) for i, j in ((0, 0), (0, 1), (1, 1)))
    p, q = math.fsum(r[0] for r in rows), math.fsum(r[1] for r in rows)
    determinant = a * c - b * b
    return (p * c - q * b) / determinant, (q * a - p * b) / determinant


class Approach(NamedTuple):
    """e² = floor² + factor / n ^ power."""
    floor: float
    factor: float
    power: float

    def error(self, n):
        return (self.floor ** 2 + self.factor * n ** -self.power) ** 0.5


POWERS = [i / 50 for i in range(10, 61)]


def approach(points):
    """The Approach through points (n, e), by least squares of relative errors of e². Its power is fitted too where there
    are four different n, else 1, as of plain photon noise. None where there are less than two n."""
    different = len({n for n, _ in points})
    tries = [approach_with(points, power) for power in (POWERS if different > 3 else [1])] if different > 1 else []
    return min(tries, key=lambda t: math.fsum(((t.error(n) / e) ** 2 - 1) ** 2 for n, e in points), default=None)


def approach_with(points, power):
    squares = [(n ** -power, e * e) for n, e in points]
    offset, factor = line(squares)
    if offset > 0 and factor > 0:
        return Approach(offset ** 0.5, factor, power)
    return Approach(0.0, math.fsum(x / y for x, y in squares) / math.fsum((x / y) ** 2 for x, y in squares), power)


def slope_text(law):
    text = f"slope {law.slope:.2f}"
    if math.isfinite(law.half_width_95):
        text += f" ± {law.half_width_95:.2f}"
    return text.replace("-", "−")


def fitted(points):
    """What Series.fit takes: text and points of the fit; None where there is no fit."""
    try:
        law = power_law(points)
    except ValueError:
        return None
    return slope_text(law), curve(points, lambda x: law.factor * x ** law.slope)


def curve(points, function):
    """Over the span of the points."""
    first, last = min(x for x, _ in usable(points)), max(x for x, _ in usable(points))
    places = [first * (last / first) ** (i / (FIT_POINTS - 1)) for i in range(FIT_POINTS)]
    return [(x, function(x)) for x in places]

# SPDX-License-Identifier: GPL-3.0-or-later
"""Axes of plots: which values they show, where their ticks stand and how these are written."""
import math
from dataclasses import dataclass, field

SMALLEST, LARGEST = 1e-300, 1e300  # of what can be drawn
STRIDES = (1, 2, 3, 5, 10, 20, 50, 100, 200)  # decades between the ticks of a log axis
SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


@dataclass
class Axis:
    """`low` and `high` are drawn at the pixels `first` and `last`; they are decimal logarithms on a log axis."""
    log: bool
    low: float
    high: float
    first: float
    last: float
    ticks: list = field(default_factory=list)  # (value, label)
    minor: list = field(default_factory=list)  # values


def drawable(value, log):
    if value is None or not math.isfinite(value) or abs(value) > LARGEST:
        return False
    return value >= SMALLEST if log else True


def place(axis, value):
    """In pixels; what lies outside of the axis goes to its end."""
    position = math.log10(max(value, SMALLEST)) if axis.log else value
    share = (position - axis.low) / (axis.high - axis.low)
    return axis.first + min(1.0, max(0.0, share)) * (axis.last - axis.first)


def bounds(values, log):
    """Ends of an axis that shows these values, with some air."""
    if log:
        low, high = math.log10(min(values)), math.log10(max(values))
        air = 0.05 * (high - low) if high - low > 1e-9 else 0.5
        return low - air, high + air
    low, high = min(values), max(values)
    size = max(abs(low), abs(high))
    if high - low <= 1e-9 * size or not size:
        return low - (size / 2 or 1), high + (size / 2 or 1)
    air = 0.05 * (high - low)
    from_zero, to_zero = 0 <= low <= high / 2, low / 2 <= high <= 0
    return 0.0 if from_zero else low - air, 0.0 if to_zero else high + air


def power_of_ten(mantissa, exponent):
    """10⁻⁷, 2·10⁻⁷"""
    power = "10" + str(exponent).translate(SUPERSCRIPTS)
    return power if mantissa == "1" else f"{mantissa}·{power}"


def plain(value, digits):
    """10,000 or 0.01, with a true minus"""
    return f"{value:,.{digits}f}".replace("-", "−")


def number(value, significant=4):
    """A single value as text: 4 significant digits, no trailing zeros; all digits before the point."""
    if value is None or math.isnan(value):
        return "—"
    if isinstance(value, int):
        return plain(value, 0)
    if math.isinf(value):
        return "∞" if value > 0 else "−∞"
    if value == 0:
        return "0"
    mantissa, exponent = f"{value:.{significant - 1}e}".split("e")
    exponent = int(exponent)
    if not -5 < exponent < 7:
        return power_of_ten(mantissa.rstrip("0").rstrip(".").replace("-", "−"), exponent)
    text = plain(value, max(0, significant - 1 - exponent))
    return text.rstrip("0").rstrip(".") if "." in text else text


def log_labels(marks, unit):
    """Of ticks (mantissa, exponent); powers of ten where plain numbers would grow long."""
    long = any(not -5 < exponent < 6 for _, exponent in marks)
    for mantissa, exponent in marks:
        powers = long and not -2 < exponent < 2
        value = float(f"{mantissa}e{exponent}")
        text = power_of_ten(str(mantissa), exponent) if powers else plain(value, max(0, -exponent))
        yield value, text + unit


def log_marks(low, high, mantissas, stride=1):
    """(mantissa, exponent) on a log axis, at exponents that `stride` divides"""
    marks = [(m, e) for e in range(math.floor(low), math.ceil(high) + 1) if e % stride == 0 for m in mantissas]
    return [(m, e) for m, e in marks if low - 1e-9 <= math.log10(m) + e <= high + 1e-9 and float(f"{m}e{e}") > 0]


def step_of(span, count):
    """(mantissa, exponent) of the smallest step of 1, 2 or 5 · 10^k that cuts the span in `count` parts at most"""
    raw = span / count
    exponent = math.floor(math.log10(raw))
    for mantissa in (1, 2, 5):
        if mantissa * 10.0 ** exponent >= raw * (1 - 1e-9):
            return mantissa, exponent
    return 1, exponent + 1


def linear_label(value, size, exponent, unit):
    """`size`: the largest value of the axis, `exponent`: of its step"""
    top = math.floor(math.log10(size))
    if -4 <= exponent and top < 7:
        return plain(value, max(0, -exponent)) + unit
    mantissa = plain(value / 10.0 ** top, max(0, top - exponent))
    return ("0" if value == 0 else power_of_ten(mantissa, top)) + unit


def multiples(low, high, mantissa, exponent):
    step = mantissa * 10.0 ** exponent
    first, last = math.ceil(low / step - 1e-6), math.floor(high / step + 1e-6)
    return [float(f"{i * mantissa}e{exponent}") for i in range(first, last + 1)]


def linear_ticks(low, high, count, unit):
    """Ticks and the values of minor ones between them."""
    mantissa, exponent = step_of(high - low, count)
    size = max(abs(low), abs(high))
    ticks = [(value, linear_label(value, size, exponent, unit)) for value in multiples(low, high, mantissa, exponent)]
    minor = (5, exponent - 1) if mantissa == 2 else (2 * (mantissa == 1) or 1, exponent - (mantissa == 1))
    majors = {value for value, _ in ticks}
    return ticks, [value for value in multiples(low, high, *minor) if value not in majors]


def linear_choices(low, high, unit):
    for count in (8, 6, 5, 4, 3, 2):
        yield linear_ticks(low, high, count, unit)


def log_choices(low, high, unit):
    """Ticks at 1, 2 and 5, then at decades, then at each few decades; those of a linear axis within half a decade."""
    fine = log_marks(low, high, (1, 2, 5))
    if len(fine) < 3 or high - low < 0.8:
        yield from linear_choices(10 ** low, 10 ** high, unit)
    every = [float(f"{m}e{e}") for m, e in log_marks(low, high, range(1, 10))] if high - low < 12 else []
    majors = {float(f"{m}e{e}") for m, e in fine}
    if high - low < 12:
        yield list(log_labels(fine, unit)), [value for value in every if value not in majors]
    for stride in STRIDES:
        marks = log_marks(low, high, (1,), stride)
        decades = [float(f"1e{e}") for _, e in log_marks(low, high, (1,))] if high - low < 70 else []
        majors = {float(f"1e{e}") for _, e in marks}
        yield list(log_labels(marks, unit)), [value for value in (every or decades) if value not in majors]


def apart(axis, ticks, extent):
    """Do the labels stand clear of each other? `extent`: pixels that a label takes along the axis"""
    places = [(place(axis, value), extent(label)) for value, label in ticks]
    return all(abs(b - a) >= (m + n) / 2 for (a, m), (b, n) in zip(places, places[1:]))


def make_axis(values, log, first, last, extent, unit=""):
    """An axis with the densest ticks whose labels stand clear of each other."""
    axis = Axis(log, *bounds(values, log), first, last)
    unit = " " + unit if unit and unit != "%" else unit
    choices = (log_choices if log else linear_choices)(axis.low, axis.high, unit)
    for axis.ticks, axis.minor in choices:
        if len(axis.ticks) >= 2 and apart(axis, axis.ticks, extent):
            break
    return axis

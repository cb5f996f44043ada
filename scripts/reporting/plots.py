# SPDX-License-Identifier: GPL-3.0-or-later
"""Plots of measured points as SVG: error bars, fits, lines of reference, a legend beside the plot. Series differ in the
shape of their markers too, so that they can be told apart without colours."""
from dataclasses import dataclass, field
from html import escape

from . import axes
from .labels import draw_labels
from .shapes import TEXT_SIZE, colour_of, line_at, marker, path_of, text_at, text_width, wrap

WIDTH, HEIGHT = 760, 440
LEGEND_WIDTH = 200
TITLE_SIZE = 15
LINE_HEIGHT = 15
MANY_POINTS = 40  # of a series; from there on markers are small

DASHES = ("2 3", "8 3 2 3", "12 4", "8 3 2 3 2 3")  # of lines of reference


@dataclass
class Series:
    """points: (x, y, half width of the 95 % interval of y, or 0). fit: (text, [(x, y), ...]), see fit.fitted.
    marks: a text or "" for each point."""
    name: str
    points: list
    line: bool = True
    fit: tuple | None = None
    marks: list | None = None


@dataclass
class Plot:
    """lines: horizontal lines of reference, (y, label). Units are written behind the numbers of the ticks."""
    title: str
    x_label: str
    y_label: str
    series: list
    log_x: bool = True
    log_y: bool = True
    lines: list = field(default_factory=list)
    x_unit: str = ""
    y_unit: str = ""


@dataclass
class Dot:
    """A point that is drawn: place in pixels, ends of its error bar (pixels), text of its tooltip."""
    x: float
    y: float
    bar: tuple | None
    tooltip: str
    label: str


def shown(plot, point):
    return axes.drawable(point[0], plot.log_x) and axes.drawable(point[1], plot.log_y)


def half_width(point):
    width = point[2] if len(point) > 2 else 0
    return width if width and axes.drawable(width, False) else 0


def left_out_notes(plot):
    """A sentence for each series with points that cannot be drawn."""
    notes = []
    for series in plot.series:
        count = sum(not shown(plot, point) for point in series.points)
        if count:
            points = "1 point is" if count == 1 else f"{count} points are"
            name = f"{series.name}: " if series.name else ""
            why = "zero, negative or not finite" if plot.log_x or plot.log_y else "not finite"
            notes.append(f"{name}{points} left out ({why}).")
    for y, label in plot.lines:
        if not axes.drawable(y, plot.log_y):
            notes.append(f"The line “{label}” is left out: it cannot be drawn on this axis.")
    return notes


def values_shown(plot):
    """All x and all y that the axes must show; an error bar stretches a log axis by a decade at most."""
    xs, ys = [], []
    for series in plot.series:
        for point in (p for p in series.points if shown(plot, p)):
            y, dy = point[1], half_width(point)
            xs.append(point[0])
            ys += [y + dy, max(y - dy, y / 10) if plot.log_y else y - dy]
        for point in (p for p in (series.fit[1] if series.fit else []) if shown(plot, p)):
            xs.append(point[0])
            ys.append(point[1])
    if xs:
        ys += [y for y, _ in plot.lines if axes.drawable(y, plot.log_y)]
    return xs, ys


def legend_entries(plot):
    """(kind, index, lines of text, whole text) of what the legend names"""
    entries = []
    for i, series in enumerate(plot.series):
        fit = series.fit[0] if series.fit else ""
        entries += [("series", i, series.name)] if series.name else []
        entries += [("fit", i, fit)] if fit else []
    entries += [("line", i, label) for i, (y, label) in enumerate(plot.lines) if axes.drawable(y, plot.log_y)]
    return [(kind, i, wrap(text, LEGEND_WIDTH - 42, TEXT_SIZE, 3), text) for kind, i, text in entries]


def legend_height(entries):
    return sum(len(lines) * LINE_HEIGHT + 6 for _, _, lines, _ in entries)


def legend_sample(plot, kind, index, x, y):
    if kind == "line":
        return [line_at(x, y, x + 30, y, "#555555", 1.4, DASHES[index % len(DASHES)])]
    if kind == "fit":
        return [line_at(x, y, x + 30, y, colour_of(index), 1.6, "6 4")]
    line = [line_at(x, y, x + 30, y, colour_of(index), 1.6)] if plot.series[index].line else []
    return line + [marker(index, x + 15, y, 4.5)]


def draw_legend(plot, entries, x, y):
    parts = []
    for kind, index, lines, whole in entries:
        parts += legend_sample(plot, kind, index, x, y + LINE_HEIGHT / 2)
        texts = "".join(text_at(x + 38, y + 12 + i * LINE_HEIGHT, line) for i, line in enumerate(lines))
        parts.append(f"<g><title>{escape(whole)}</title>{texts}</g>")
        y += len(lines) * LINE_HEIGHT + 6
    return parts


def draw_axes(x, y, plot):
    """Grid, ticks and their labels, titles of the axes. In pixels y.first is the bottom, y.last the top."""
    parts = []
    for value, label in x.ticks:
        at = axes.place(x, value)
        parts += [line_at(at, y.first, at, y.last, "#e4e4e4"), line_at(at, y.first, at, y.first + 6, "#444444"),
                  text_at(at, y.first + 20, label, anchor="middle")]
    for value, label in y.ticks:
        at = axes.place(y, value)
        parts += [line_at(x.first, at, x.last, at, "#e4e4e4"), line_at(x.first - 6, at, x.first, at, "#444444"),
                  text_at(x.first - 10, at + 4, label, anchor="end")]
    parts += [line_at(axes.place(x, v), y.first, axes.place(x, v), y.first + 3, "#888888") for v in x.minor]
    parts += [line_at(x.first - 3, axes.place(y, v), x.first, axes.place(y, v), "#888888") for v in y.minor]
    parts += [line_at(x.first, y.first, x.last, y.first, "#444444"), line_at(x.first, y.first, x.first, y.last, "#444444")]
    return parts + axis_titles(x, y, plot)


def axis_titles(x, y, plot):
    middle, height = (x.first + x.last) / 2, (y.first + y.last) / 2
    below = wrap(plot.x_label, x.last - x.first, TEXT_SIZE + 1, 1)[0]
    beside = wrap(plot.y_label, y.first - y.last, TEXT_SIZE + 1, 1)[0]
    turned = f'transform="rotate(-90 14 {height:.1f})"'
    return [text_at(middle, y.first + 42, below, TEXT_SIZE + 1, "middle"),
            text_at(14, height, beside, TEXT_SIZE + 1, "middle", turned)]


def tooltip_of(plot, series, point, mark):
    x_unit, y_unit = (" " + unit if unit else "" for unit in (plot.x_unit, plot.y_unit))
    dy = half_width(point)
    lines = [series.name, mark, f"{plot.x_label}: {axes.number(point[0])}{x_unit}",
             f"{plot.y_label}: {axes.number(point[1])}{' ± ' + axes.number(dy, 2) if dy else ''}{y_unit}"]
    return "\n".join(line for line in lines if line)


def dots_of(plot, series, x, y):
    """A Dot for each point, None for those left out."""
    marks = list(series.marks or [])
    marks += [""] * (len(series.points) - len(marks))
    dots = []
    for point, mark in zip(series.points, marks):
        if not shown(plot, point):
            dots.append(None)
            continue
        dy = half_width(point)
        bar = (axes.place(y, point[1] - dy), axes.place(y, point[1] + dy)) if dy else None
        dots.append(Dot(axes.place(x, point[0]), axes.place(y, point[1]), bar,
                        tooltip_of(plot, series, point, mark or ""), mark or ""))
    return dots


def runs(dots):
    """Stretches between points left out."""
    stretch = []
    for dot in [*dots, None]:
        if dot:
            stretch.append((dot.x, dot.y))
        elif stretch:
            yield stretch
            stretch = []


def fit_path(plot, series, x, y):
    return [(axes.place(x, p[0]), axes.place(y, p[1])) for p in (series.fit[1] if series.fit else []) if shown(plot, p)]


def draw_bar(dot, colour, bottom):
    """Without a foot where it runs out of the plot, as on a log axis when it reaches zero."""
    low, high = dot.bar
    parts = [line_at(dot.x, low, dot.x, high, colour, 1.2), line_at(dot.x - 4, high, dot.x + 4, high, colour, 1.2)]
    return parts + ([line_at(dot.x - 4, low, dot.x + 4, low, colour, 1.2)] if low < bottom - 0.1 else [])


def draw_series(plot, x, y):
    """Lines below bars below markers below labels."""
    all_dots = [dots_of(plot, series, x, y) for series in plot.series]
    lines, bars, marks, paths = [], [], [], []
    for index, (series, dots) in enumerate(zip(plot.series, all_dots)):
        stretches, fit = list(runs(dots)) if series.line else [], fit_path(plot, series, x, y)
        paths += [*stretches, fit]
        lines += [path_of(stretch, colour_of(index)) for stretch in stretches if len(stretch) > 1]
        lines += [path_of(fit, colour_of(index), "6 4")] if len(fit) > 1 else []
        radius = 4.5 if len(dots) < MANY_POINTS else 2.5
        for dot in filter(None, dots):
            bars += draw_bar(dot, colour_of(index), y.first) if dot.bar else []
            marks.append(marker(index, dot.x, dot.y, radius, dot.tooltip))
    frame = (x.first, y.last, x.last, y.first)
    return lines + bars + marks + draw_labels([dot for dots in all_dots for dot in dots if dot], paths, frame)


def draw_references(plot, x, y):
    parts = []
    for index, (value, label) in enumerate(plot.lines):
        if axes.drawable(value, plot.log_y):
            at = axes.place(y, value)
            line = line_at(x.first, at, x.last, at, "#555555", 1.4, DASHES[index % len(DASHES)])
            parts.append(f"<g><title>{escape(label)}: {axes.number(value)}</title>{line}</g>")
    return parts


def draw_data(plot, top, bottom, right):
    """The plot proper, between these pixels."""
    xs, ys = values_shown(plot)
    if not xs:
        box = f'<rect x="60" y="{top}" width="{right - 60}" height="{bottom - top}" fill="none" stroke="#cccccc"/>'
        return [box, text_at((60 + right) / 2, (top + bottom) / 2, "no data", 16, "middle", 'fill="#666666"')]
    y = axes.make_axis(ys, plot.log_y, bottom, top, lambda label: 26, plot.y_unit)
    left = 40 + max(text_width(label) for _, label in y.ticks)
    x = axes.make_axis(xs, plot.log_x, left, right, lambda label: text_width(label) + 14, plot.x_unit)
    return draw_axes(x, y, plot) + draw_references(plot, x, y) + draw_series(plot, x, y)


def draw(plot):
    """(SVG, notes on what could not be drawn)"""
    title = wrap(plot.title, WIDTH - 20, TITLE_SIZE, 2)
    top = 24 + 20 * len(title) if plot.title else 20
    entries = legend_entries(plot)
    height = max(HEIGHT, top + legend_height(entries) + 20)
    right = WIDTH - LEGEND_WIDTH - 22 if entries else WIDTH - 40
    parts = [text_at(6, 22 + 20 * i, line, TITLE_SIZE, more='font-weight="600"') for i, line in enumerate(title)]
    parts += draw_data(plot, top, height - 62, right)
    parts += draw_legend(plot, entries, WIDTH - LEGEND_WIDTH, top)
    body = "\n".join(parts)
    return (f'<svg class="plot" xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" width="{WIDTH}" '
            f'height="{height}" role="img" aria-label="{escape(plot.title)}" font-family="sans-serif" fill="#222222">\n'
            f'<rect width="{WIDTH}" height="{height}" fill="#ffffff"/>\n{body}\n</svg>\n'), left_out_notes(plot)

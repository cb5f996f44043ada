# SPDX-License-Identifier: GPL-3.0-or-later
"""Elements of SVG: texts, lines and the markers of series, which differ in colour and shape."""
import textwrap
from html import escape

TEXT_SIZE = 12

# M. Okabe, K. Ito: Color Universal Design, 2008; the faint ones last
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#000000", "#CC79A7", "#E69F00", "#56B4E9")
# centre 0, radius 1
SHAPES = ("circle", "M-.9 -.9H.9V.9H-.9Z", "M0 -1.15L1.1 .85H-1.1Z", "M0 -1.25L1.25 0L0 1.25L-1.25 0Z",
          "M0 1.15L1.1 -.85H-1.1Z", "M-.35 -1.1H.35V-.35H1.1V.35H.35V1.1H-.35V.35H-1.1V-.35H-.35Z")


def text_width(text, size=TEXT_SIZE):
    """About; sans-serif fonts differ."""
    return 0.57 * size * len(text)


def wrap(text, width, size, most_lines):
    return textwrap.wrap(text, max(4, int(width / (0.57 * size))), max_lines=most_lines, placeholder=" …") or [""]


def text_at(x, y, text, size=TEXT_SIZE, anchor="start", more=""):
    return f'<text x="{x:.1f}" y="{y:.1f}" font-size="{size}" text-anchor="{anchor}" {more}>{escape(text)}</text>'


def line_at(x1, y1, x2, y2, colour, width=1.0, dash="", name=""):
    dashed = f' stroke-dasharray="{dash}"' if dash else ""
    named = f' class="{name}"' if name else ""
    return (f'<line{named} x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" stroke="{colour}" '
            f'stroke-width="{width}"{dashed}/>')


def path_of(places, colour, dash=""):
    steps = "L".join(f"{x:.1f} {y:.1f}" for x, y in places)
    dashed = f' stroke-dasharray="{dash}"' if dash else ""
    return f'<path d="M{steps}" fill="none" stroke="{colour}" stroke-width="1.6" stroke-linejoin="round"{dashed}/>'


def colour_of(index):
    return COLOURS[index % len(COLOURS)]


def marker(index, x, y, radius, tooltip=None):
    """Filled; hollow from the second round of shapes on."""
    shape, colour = SHAPES[index % len(SHAPES)], colour_of(index)
    fill = colour if index // len(SHAPES) % 2 == 0 else "#ffffff"
    style = f'fill="{fill}" stroke="{colour}"'
    title = "" if tooltip is None else f"<title>{escape(tooltip)}</title>"
    name = "" if tooltip is None else ' class="mark"'
    if shape == "circle":
        return f'<circle{name} cx="{x:.1f}" cy="{y:.1f}" r="{radius}" {style} stroke-width="1.2">{title}</circle>'
    return (f'<path{name} d="{shape}" transform="translate({x:.1f} {y:.1f}) scale({radius})" {style} '
            f'stroke-width="{1.2 / radius:.2f}">{title}</path>')

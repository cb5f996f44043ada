# SPDX-License-Identifier: GPL-3.0-or-later
"""A page of text, tables, plots and pictures, written as report.md and as report.html, which needs no other file."""
import base64
import os
import pathlib
import re
from dataclasses import dataclass
from html import escape

from .markup import cell_markdown, cell_text, numeric_column, slug, to_html, to_markdown
from .plots import Plot, draw

HERE = pathlib.Path(__file__).resolve().parent
ALLOWED = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'"
LABEL_WIDTH = 120  # pixels of the labels of rows of pictures
SLIDER_WIDTH = 512  # pixels; smaller pictures are enlarged by whole numbers up to it


def png_size(data, path):
    """(width, height) of a PNG file's content"""
    if data[:8] != b"\x89PNG\r\n\x1a\n" or data[12:16] != b"IHDR":
        raise ValueError(f"{path}: not a PNG file")
    return int.from_bytes(data[16:20], "big"), int.from_bytes(data[20:24], "big")


def write_atomically(path, data):
    """The file is there as a whole or as it was before."""
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(path.name + ".part")
    part.write_bytes(data)
    os.replace(part, path)


def image(data, size, label, classes=""):
    width, height = size
    source = base64.b64encode(data).decode("ascii")
    named = f' class="{classes}"' if classes else ""
    return f'<img{named} src="data:image/png;base64,{source}" alt="{escape(label)}" width="{width}" height="{height}">'


def fence(text):
    """Longer than any row of backticks in the text"""
    return "`" * max(3, 1 + max((len(run) for run in re.findall("`+", text)), default=0))


def markdown_table(header, rows, right):
    rule = ["---:" if is_right else "---" for is_right in right]
    return "\n".join("| " + " | ".join(row) + " |" for row in (header, rule, *rows))


def table_html(header, rows, right):
    kinds = [' class="number"' if is_right else "" for is_right in right]
    head = "".join(f"<th{kind}>{to_html(name)}</th>" for kind, name in zip(kinds, header))
    body = "\n".join("<tr>" + "".join(f"<td{kind}>{to_html(text)}</td>" for kind, text in zip(kinds, row)) + "</tr>"
                     for row in rows)
    return f"<table><thead><tr>{head}</tr></thead>\n<tbody>{body}</tbody></table>"


def slider_html(left, right, size):
    """left and right: (PNG data, label)"""
    zoom = max(1, SLIDER_WIDTH // size[0])
    pixels = " pixels" if zoom > 1 else ""
    return (f'<div class="slider" style="width: {size[0] * zoom}px">{image(right[0], size, right[1], "right" + pixels)}'
            f'{image(left[0], size, left[1], "left" + pixels)}<span class="name-left">{escape(left[1])}</span>'
            f'<span class="name-right">{escape(right[1])}</span><div class="bar"></div><input type="range" min="0" max="100" '
            f'step="0.5" value="50" aria-label="{escape(left[1])} against {escape(right[1])}"></div>')


@dataclass
class Cell:
    """Of a grid of pictures; the width in pixels"""
    markdown: str
    html: str
    width: int


def picture_markdown(grid, row_labels, column_labels):
    header = [""] * bool(row_labels) + ([cell_markdown(name) for name in column_labels] or [""] * len(grid[0]))
    rows = [[cell.markdown for cell in row] for row in grid]
    if row_labels:
        rows = [[cell_markdown(label), *row] for label, row in zip(row_labels, rows)]
    return markdown_table(header, rows, [False] * len(header))


def picture_html(grid, row_labels, column_labels):
    """As wide as its pictures, or less where the page is narrower; the columns stay equal."""
    heads = [f"<th>{to_html(label)}</th>" for label in row_labels] or [""] * len(grid)
    rows = [f"<tr>{head}" + "".join(f"<td>{cell.html}</td>" for cell in row) + "</tr>" for head, row in zip(heads, grid)]
    names = "".join(f"<th>{to_html(name)}</th>" for name in [""] * bool(row_labels) + column_labels)
    top = f"<thead><tr>{names}</tr></thead>" if column_labels else ""
    width = len(grid[0]) * (max(cell.width for row in grid for cell in row) + 6) + LABEL_WIDTH * bool(row_labels)
    labelled = " labelled" if row_labels else ""
    return f'<table class="pictures{labelled}" style="width: {width}px">{top}<tbody>' + "\n".join(rows) + "</tbody></table>"


class Page:
    """Blocks in the order of the calls. Pictures are read when they are added."""

    def __init__(self, title):
        self._title = title
        self._markdown, self._html = [], []
        self._contents = []  # (level, place, text) of headings
        self._places = set()
        self._files = {}  # path beside the page: content

    def _add(self, markdown, html):
        self._markdown.append(markdown)
        self._html.append(html)

    def _add_figure(self, markdown, html, caption):
        below = f"<figcaption>{to_html(caption)}</figcaption>" if caption else ""
        self._add(markdown + (f"\n\n{to_markdown(caption)}" if caption else ""), f"<figure>{html}{below}</figure>")

    def _add_file(self, name, data):
        if name in self._files:
            raise ValueError(f"{name}: two plots or pictures of this name")
        self._files[name] = data

    def _add_png(self, name, path):
        """(path beside the page, content, size)"""
        data = pathlib.Path(path).read_bytes()
        size = png_size(data, path)
        self._add_file(f"pictures/{name}.png", data)
        return f"pictures/{name}.png", data, size

    def heading(self, text, level=2):
        """Levels 2 and 3 stand in the table of contents of the HTML."""
        place, number = slug(text), 1
        while place in self._places:
            number += 1
            place = f"{slug(text)}-{number}"
        self._places.add(place)
        if level <= 3:
            self._contents.append((level, place, text))
        self._add(f"{'#' * level} {to_markdown(text)}", f'<h{level} id="{place}">{to_html(text)}</h{level}>')

    def text(self, paragraph):
        """**bold**, `code` and [link](address); an empty line parts paragraphs."""
        for part in filter(None, (part.strip() for part in re.split(r"\n\s*\n", paragraph))):
            self._add(to_markdown(part), f"<p>{to_html(part)}</p>")

    def table(self, header, rows, caption=""):
        """Cells are texts as in text(), or numbers; columns of numbers stand to the right."""
        texts = [[cell_text(value) for value in row] for row in rows]
        if any(len(row) != len(header) for row in texts):
            raise ValueError(f"a table with the columns {', '.join(map(str, header))} has a row of another length")
        names = [str(name) for name in header]
        right = [numeric_column([row[i] for row in texts]) for i in range(len(names))]
        cells = [[cell_markdown(text) for text in row] for row in texts]
        markdown = markdown_table([cell_markdown(name) for name in names], cells, right)
        self._add_figure(markdown, f'<div class="wide">{table_html(names, texts, right)}</div>', caption)

    def plot(self, name, title, x_label, y_label, series, log_x=True, log_y=True, note="", lines=(), x_unit="", y_unit=""):
        """lines: (y, label) of horizontal lines of reference. Units are written behind the numbers of the ticks."""
        svg, left_out = draw(Plot(title, x_label, y_label, list(series), log_x, log_y, list(lines), x_unit, y_unit))
        file = f"plots/{slug(name)}.svg"
        self._add_file(file, svg.encode())
        self._add_figure(f"![{cell_markdown(title)}]({file})", svg, " ".join(filter(None, [note, *left_out])))

    def slider(self, name, caption, left, right, left_label, right_label):
        """Two PNG files of equal size under a handle that parts them."""
        left_file, left_data, size = self._add_png(f"{slug(name)}-left", left)
        right_file, right_data, right_size = self._add_png(f"{slug(name)}-right", right)
        if size != right_size:
            raise ValueError(f"{left} and {right} differ in size: {size} and {right_size}")
        markdown = markdown_table([cell_markdown(left_label), cell_markdown(right_label)],
                                  [[f"![]({left_file})", f"![]({right_file})"]], [False, False])
        html = slider_html((left_data, left_label), (right_data, right_label), size)
        self._add_figure(markdown, html, caption)

    def pictures(self, name, caption, rows, row_labels=(), column_labels=()):
        """Rows of PNG files; None where there is none."""
        count = max(len(row) for row in rows)
        if len(column_labels) not in (0, count) or len(row_labels) not in (0, len(rows)):
            raise ValueError(f"{name}: as many labels as rows and columns, or none")
        grid = [[self._picture(f"{slug(name)}-{i + 1}-{j + 1}", row[j] if j < len(row) else None) for j in range(count)]
                for i, row in enumerate(rows)]
        labels, names = [str(text) for text in row_labels], [str(text) for text in column_labels]
        self._add_figure(picture_markdown(grid, labels, names), picture_html(grid, labels, names), caption)

    def _picture(self, name, path):
        if path is None:
            return Cell("—", "—", 0)
        file, data, size = self._add_png(name, path)
        return Cell(f"![]({file})", image(data, size, ""), size[0])

    def details(self, text_block, summary=""):
        """Text as it stands; with a summary it is folded away under it."""
        marks = fence(text_block)
        block = f"<pre>{escape(text_block)}</pre>"
        self._add((f"{to_markdown(summary)}\n\n" if summary else "") + f"{marks}text\n{text_block.rstrip()}\n{marks}",
                  f"<details><summary>{to_html(summary)}</summary>{block}</details>" if summary else block)

    def markdown(self):
        return "\n\n".join([f"# {to_markdown(self._title)}", *self._markdown]) + "\n"

    def html(self):
        style, script = ((HERE / name).read_text() for name in ("style.css", "script.js"))
        items = "\n".join(f'<li class="level{level}"><a href="#{place}">{to_html(text)}</a></li>'
                          for level, place, text in self._contents)
        contents = f'<nav aria-label="Contents"><ul>\n{items}\n</ul></nav>\n' if items else ""
        return (f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
                f'<meta http-equiv="Content-Security-Policy" content="{ALLOWED}">\n'
                f'<meta name="viewport" content="width=device-width, initial-scale=1">\n'
                f'<link rel="icon" href="data:,">\n<title>{escape(self._title)}</title>\n<style>\n{style}</style>\n</head>\n'
                f'<body>\n<h1>{to_html(self._title)}</h1>\n{contents}<main>\n' + "\n".join(self._html) +
                f"\n</main>\n<script>\n{script}</script>\n</body>\n</html>\n")

    def write(self, folder):
        """report.md, report.html, plots/ and pictures/; the two pages last."""
        folder = pathlib.Path(folder)
        for name, data in self._files.items():
            write_atomically(folder / name, data)
        write_atomically(folder / "report.md", self.markdown().encode())
        write_atomically(folder / "report.html", self.html().encode())

# SPDX-License-Identifier: GPL-3.0-or-later
"""Run in scripts/: python3 -m unittest"""
import math
import pathlib
import re
import struct
import tempfile
import unittest
import xml.etree.ElementTree as ElementTree
import zlib

from reporting import axes, labels
from reporting.fit import approach, fitted, line, power_law, t_quantile
from reporting.markup import numeric_column, to_html, to_markdown
from reporting.page import Page
from reporting.plots import HEIGHT, WIDTH, Plot, Series, draw

NOTHING_LOADED = re.compile(r"""(?:src|poster|data|action)\s*=\s*["'](?!data:)|url\(|@import|<link(?! rel="icon" href="data:)""")


def chunk(name, data):
    return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))


def write_png(path, width, height, grey):
    rows = (b"\0" + bytes([grey]) * width) * height
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)) +
                     chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))
    return path


def drawn(series, **more):
    """(SVG as a tree, its text, notes)"""
    svg, notes = draw(Plot("title", "x", "y", series, **more))
    return ElementTree.fromstring(svg), svg, notes


class Fits(unittest.TestCase):
    def test_exact_power_laws(self):
        for slope, factor in ((-0.5, 3.0), (2.0, 1e-6), (0.0, 7.0)):
            law = power_law([(x, factor * x ** slope, 0.1) for x in (0.1, 1, 5, 40, 1e4)])
            self.assertAlmostEqual(law.slope, slope, 12)
            self.assertAlmostEqual(law.factor / factor, 1, 12)
            self.assertAlmostEqual(law.half_width_95, 0, 10)

    def test_lines(self):
        offset, slope = line([(1, 3), (2, 5), (4, 9)])
        self.assertAlmostEqual(offset, 1)
        self.assertAlmostEqual(slope, 2)
        offset, slope = line([(0, 1), (1, 3), (1, 6)])  # relative: of 3 and 6 at one place 3.6 costs least
        self.assertAlmostEqual(offset, 1)
        self.assertAlmostEqual(slope, 2.6)

    def test_approach(self):
        for floor, power in ((0.03, 0.6), (0.03, 1.0), (0.0, 0.8)):
            points = [(n, (floor ** 2 + 0.05 * n ** -power) ** 0.5) for n in (100, 400, 1600, 6400, 25600)]
            law = approach(points)
            self.assertAlmostEqual(law.floor, floor, 6)
            self.assertAlmostEqual(law.power, power, 9)
            self.assertAlmostEqual(law.error(800), (floor ** 2 + 0.05 * 800 ** -power) ** 0.5, 9)
        self.assertEqual(approach([(1, 0.5), (4, 0.25)]).power, 1)  # too few for more
        self.assertEqual(approach([(1, 1.0), (4, 0.2)]).floor, 0)  # falls faster than noise does
        self.assertIsNone(approach([(5, 0.1), (5, 0.2)]))

    def test_half_width_by_hand(self):
        """ln x = -1, 0, 1 and ln y = 0, 1, 0: slope 0, residuals -1/3, 2/3, -1/3"""
        slope, half_width, factor = power_law([(math.exp(x), math.exp(y)) for x, y in ((-1, 0), (0, 1), (1, 0))])
        self.assertAlmostEqual(slope, 0)
        self.assertAlmostEqual(half_width, 12.706 * math.sqrt(2 / 3 / 1 / 2))
        self.assertAlmostEqual(factor, math.exp(1 / 3))

    def test_quantiles(self):
        for freedom, expected in ((1, 12.706), (10, 2.228), (11, 2.201), (20, 2.086), (100, 1.984)):
            self.assertAlmostEqual(t_quantile(freedom) / expected, 1, delta=0.002)

    def test_few_points(self):
        self.assertEqual(power_law([(1, 1), (2, 4)]).half_width_95, math.inf)
        for points in ([], [(1, 2)], [(3, 1), (3, 2)], [(1, 1), (0, 2), (-1, 2), (2, None), (2, math.nan)]):
            self.assertRaises(ValueError, power_law, points)
            self.assertIsNone(fitted(points))
        self.assertEqual(fitted([(1, 1), (4, 0.5)])[0], "slope −0.50")


class Axes(unittest.TestCase):
    def labels(self, values, log, unit="", last=560):
        return [label for _, label in axes.make_axis(values, log, 60, last, lambda text: 7 * len(text) + 14, unit).ticks]

    def test_linear(self):
        self.assertEqual(self.labels([0, 10], False, last=400), ["0", "2", "4", "6", "8", "10"])
        self.assertEqual(self.labels([-0.3, 0.3], False, last=300), ["−0.2", "0.0", "0.2"])
        self.assertEqual(self.labels([0, 2.4], False, "s", last=400), ["0.0 s", "0.5 s", "1.0 s", "1.5 s", "2.0 s", "2.5 s"])
        self.assertEqual(self.labels([0, 40000], False, last=420), ["0", "10,000", "20,000", "30,000", "40,000"])

    def test_log(self):
        self.assertEqual(self.labels([0.01, 1], True), ["0.01", "0.02", "0.05", "0.1", "0.2", "0.5", "1"])
        self.assertEqual(self.labels([1, 1e5], True), ["1", "10", "100", "1,000", "10,000", "100,000"])
        self.assertEqual(self.labels([1e-6, 1], True), ["10⁻⁶", "10⁻⁵", "10⁻⁴", "10⁻³", "10⁻²", "0.1", "1"])

    def test_ticks_stand_inside_and_apart(self):
        for low, high in ((1e-300, 1e300), (1, 1), (1, 1.0001), (3, 4), (1e-9, 2e-9), (5, 5e7), (1e299, 1e300), (0.2, 30)):
            for log in (True, False):
                axis = axes.make_axis([low, high], log, 60, 560, lambda text: 7 * len(text) + 14)
                values = [value for value, _ in axis.ticks]
                names = [label for _, label in axis.ticks]
                self.assertGreaterEqual(len(values), 2, (low, high, log))
                self.assertLessEqual(len(values), 14, (low, high, log))
                self.assertEqual(len(set(names)), len(names), names)
                self.assertTrue(axes.apart(axis, axis.ticks, lambda text: 7 * len(text)), names)
                self.assertFalse(set(values) & set(axis.minor))

    def test_numbers(self):
        for value, text in ((0.01, "0.01"), (10000, "10,000"), (2.5, "2.5"), (0.0, "0"), (1234.56, "1,235"), (99999.0, "99,999"),
                            (2e-7, "2·10⁻⁷"), (1e9, "10⁹"), (-3.5, "−3.5"), (None, "—"), (math.nan, "—"), (120.0, "120")):
            self.assertEqual(axes.number(value), text)


class Plots(unittest.TestCase):
    def marks(self, tree):
        return [element for element in tree.iter() if element.get("class") == "mark"]

    def test_size_and_marks(self):
        tree, _, notes = drawn([Series("a", [(1, 2, 0.1), (2, 3, 0)]), Series("b", [(1, 5)], line=False)])
        self.assertEqual((tree.get("width"), tree.get("height")), (str(WIDTH), str(HEIGHT)))
        self.assertEqual((len(self.marks(tree)), notes), (3, []))

    def test_left_out(self):
        points = [(0, 1, 0), (1, -1, 0), (1, math.nan, 0), (1, None, 0), (2, 2, 5)]
        tree, _, notes = drawn([Series("a", points)], lines=[(0, "zero")])
        self.assertEqual(len(self.marks(tree)), 1)
        self.assertEqual(notes[0], "a: 4 points are left out (zero, negative or not finite).")
        self.assertIn("zero", notes[1])
        tree, _, notes = drawn([Series("a", points)], log_x=False, log_y=False)
        self.assertEqual(len(self.marks(tree)), 3)

    def test_no_data(self):
        for series in ([], [Series("a", [])], [Series("a", [(-1, 1, 0)])]):
            self.assertIn("no data", drawn(series)[1])

    def test_everything_inside(self):
        points = [(1e-12, 1e-200, 0), (1e30, 1e250, 1e260), (3, 3, 2.999999)]
        for log in (True, False):
            tree, svg, _ = drawn([Series("a " * 200, points, fit=("slope", [(1, 1), (2, 2)]))], log_x=log, log_y=log)
            for element in tree.iter():
                for name, limit in (("x", WIDTH), ("x1", WIDTH), ("x2", WIDTH), ("cx", WIDTH), ("y", HEIGHT), ("y1", HEIGHT)):
                    self.assertTrue(0 <= float(element.get(name, 0)) <= limit, ElementTree.tostring(element))
            self.assertNotIn("nan", svg)

    def test_long_legends_grow_the_plot(self):
        series = [Series(f"a series with a long name, number {i}", [(1, 1 + i, 0)]) for i in range(30)]
        tree = drawn(series)[0]
        lowest = max(float(e.get("y")) for e in tree.iter() if e.get("y"))
        self.assertTrue(HEIGHT < lowest < float(tree.get("height")))

    def test_escaping(self):
        tree, svg, _ = drawn([Series("<b>&\"'", [(1, 1, 0)], marks=["<i>"])], lines=[(2, "<u>")])
        self.assertFalse(re.search("<[biu]>", svg))

    def test_labels_keep_off_lines(self):
        self.assertTrue(labels.crosses([(0, 0), (10, 10)], (4, 4, 6, 6)))
        self.assertFalse(labels.crosses([(0, 0), (10, 10)], (6, 1, 9, 4)))
        self.assertFalse(labels.crosses([(0, 0), (3, 3)], (4, 4, 6, 6)))
        self.assertTrue(labels.crosses([(5, 0), (5, 10)], (4, 4, 6, 6)))


class Markup(unittest.TestCase):
    def test_html(self):
        self.assertEqual(to_html("**a** `b **c** <d>` <e> & [f](https://g.org/?h=1&i=2)"),
                         "<strong>a</strong> <code>b **c** &lt;d&gt;</code> &lt;e&gt; &amp; "
                         '<a href="https://g.org/?h=1&amp;i=2">f</a>')
        for address in ("javascript:alert`1`", "data:text/html,x", "//host/x", "vbscript:x"):
            self.assertNotIn("<a", to_html(f"[a]({address})"))
        self.assertNotIn('"onclick', to_html('[a](x"onclick="y)'))

    def test_markdown(self):
        self.assertEqual(to_markdown("<script> a < b `<c>`"), "\\<script> a < b `<c>`")

    def test_columns_of_numbers(self):
        for column in (["1", "2.5"], ["0.01 ± 0.002", "—"], ["10,000 s", "3 ms"], ["−1.5", "2·10⁻⁷"], ["**3**", "4 %"], ["64 × 64"]):
            self.assertTrue(numeric_column(column), column)
        for column in (["a", "1"], [], ["", "—"], ["3 of the 4"]):
            self.assertFalse(numeric_column(column), column)


class Pages(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.a, self.b = (write_png(self.folder / f"{name}.png", 8, 4, grey) for name, grey in (("a", 50), ("b", 200)))

    def page(self):
        page = Page("A <title>")
        page.heading("Same & same")
        page.heading("Same & same", 3)
        page.text("One **paragraph**.\n\nAnother with a [link](https://example.org).")
        page.table(["name", "value"], [["a|b", 0.5], ["<c>", 12345]], "Of `things`")
        page.plot("p 1", "plot", "x", "y", [Series("s", [(1, 1, 0.1), (0, 2, 0)])], note="Bars: 95 %.")
        page.slider("s", "caption", self.a, self.b, "left", "right")
        page.pictures("g", "grid", [[self.a, None], [self.b]], ["r1", "r2"], ["c1", "c2"])
        page.details("```\n<x>", "More")
        return page

    def test_files(self):
        self.page().write(self.folder / "out")
        found = sorted(str(p.relative_to(self.folder / "out")) for p in (self.folder / "out").rglob("*") if p.is_file())
        self.assertEqual(found, ["pictures/g-1-1.png", "pictures/g-2-1.png", "pictures/s-left.png", "pictures/s-right.png",
                                 "plots/p-1.svg", "report.html", "report.md"])
        self.assertEqual((self.folder / "out/pictures/g-2-1.png").read_bytes(), self.b.read_bytes())
        ElementTree.parse(self.folder / "out/plots/p-1.svg")

    def test_html_needs_nothing_else(self):
        html = self.page().html()
        self.assertIsNone(NOTHING_LOADED.search(html))
        self.assertEqual(set(re.findall(r"https?://[^\s\"'<]*", html)), {"https://example.org", "http://www.w3.org/2000/svg"})
        self.assertEqual(html.count("data:image/png;base64,"), 4)

    def test_html_is_escaped(self):
        html = self.page().html()
        self.assertIn("<h1>A &lt;title&gt;</h1>", html)
        self.assertIn("<td>&lt;c&gt;</td>", html)
        self.assertIn('<td class="number">12,345</td>', html)

    def test_contents(self):
        html = self.page().html()
        for place in ("same-same", "same-same-2"):
            self.assertEqual((html.count(f'href="#{place}"'), html.count(f'id="{place}"')), (1, 1))

    def test_markdown(self):
        text = self.page().markdown()
        for part in ("# A \\<title>\n\n## Same & same\n", "| name | value |\n| --- | ---: |\n| a\\|b | 0.5 |\n| \\<c> | 12,345 |",
                     "![plot](plots/p-1.svg)\n\nBars: 95 %. s: 1 point is left out", "````text\n```\n<x>\n````",
                     "|  | c1 | c2 |\n| --- | --- | --- |\n| r1 | ![](pictures/g-1-1.png) | — |"):
            self.assertIn(part, text)

    def test_refusals(self):
        page, other = Page(""), write_png(self.folder / "c.png", 9, 4, 0)
        self.assertRaises(ValueError, page.slider, "s", "", self.a, other, "", "")
        self.assertRaises(ValueError, page.table, ["a", "b"], [[1]])
        page.plot("p", "", "", "", [])
        self.assertRaises(ValueError, page.plot, "P", "", "", "", [])
        (self.folder / "d.png").write_bytes(b"no picture")
        self.assertRaises(ValueError, page.pictures, "g", "", [[self.folder / "d.png"]])


if __name__ == "__main__":
    unittest.main()

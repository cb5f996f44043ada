# SPDX-License-Identifier: GPL-3.0-or-later
"""Text with **bold**, `code` and [link](address) as HTML and as Markdown; all else is taken literally."""
import re
from html import escape

from .axes import number

CODE = re.compile(r"(`[^`]+`)")
LINK = re.compile(r"\[([^\]]+)\]\(([^()\s]+)\)")
BOLD = re.compile(r"\*\*(.+?)\*\*")
SAFE_ADDRESS = re.compile(r"(https?://|#|(?![/\\])[^:]*$)", re.IGNORECASE)  # no javascript:, no //host
# a number, perhaps with ± or × another and a unit
NUMERIC = re.compile(r"[<>≈~]? ?[-+−]?(\d[\d,.]*|\.\d+)([eE][-+]?\d+)?(·10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)?"
                     r"( ?[±×x/–] ?[\d,.]+(·10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)?)*( ?(%|[A-Za-zµ°/²³]{1,5}))?")
NEUTRAL = ("", "—", "–", "-", "∞", "−∞", "inf", "nan")


def link_html(found):
    text, address = found.groups()
    return f'<a href="{address}">{text}</a>' if SAFE_ADDRESS.match(address) else found.group(0)


def to_html(text):
    parts = []
    for part in CODE.split(text):
        if CODE.fullmatch(part):
            parts.append(f"<code>{escape(part[1:-1])}</code>")
        else:
            parts.append(BOLD.sub(r"<strong>\1</strong>", LINK.sub(link_html, escape(part))))
    return "".join(parts)


def to_markdown(text):
    """Tags are not let through."""
    parts = CODE.split(text)
    return "".join(part if CODE.fullmatch(part) else re.sub(r"<(?=[A-Za-z/!?])", r"\\<", part) for part in parts)


def cell_text(value):
    if isinstance(value, bool):
        return "yes" if value else "no"
    return number(value) if value is None or isinstance(value, (int, float)) else str(value)


def cell_markdown(text):
    return to_markdown(text).replace("|", "\\|").replace("\n", " ")


def numeric_column(texts):
    """Has it numbers only, besides empty cells?"""
    full = [text.replace("**", "").strip() for text in texts if text.strip() not in NEUTRAL]
    return bool(full) and all(NUMERIC.fullmatch(text) for text in full)


def slug(text):
    """For names of files and of places in the page"""
    return re.sub(r"[^a-z0-9]+", "-", text.lower()).strip("-") or "part"

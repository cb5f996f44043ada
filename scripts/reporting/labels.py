# SPDX-License-Identifier: GPL-3.0-or-later
"""Labels beside points, where they cover neither points nor each other."""
from .shapes import text_at, text_width

LABEL_SIZE = 11
MOST_LABELS = 20  # beyond that there are tooltips only


def overlap(a, b):
    """Of boxes (left, top, right, bottom)"""
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def crosses(path, box):
    """Does a path through these places enter the box?"""
    return any(segment_crosses(a, b, box) for a, b in zip(path, path[1:]))


def segment_crosses(a, b, box):
    """Cuts the segment by the four sides in turn (Liang and Barsky)."""
    first, last = 0.0, 1.0
    for i in (0, 1):
        step = b[i] - a[i]
        if step == 0:
            if not box[i] < a[i] < box[i + 2]:
                return False
            continue
        near, far = sorted(((box[i] - a[i]) / step, (box[i + 2] - a[i]) / step))
        first, last = max(first, near), min(last, far)
    return first < last


def boxes(dot):
    """Where its label may stand, the best first"""
    width, height = text_width(dot.label, LABEL_SIZE), LABEL_SIZE + 2
    for dx, dy in ((7, -height - 3), (7, 3), (-7 - width, -height - 3), (-7 - width, 3),
                   (-width / 2, -height - 8), (-width / 2, 8), (9, -height / 2), (-9 - width, -height / 2)):
        yield dot.x + dx, dot.y + dy, dot.x + dx + width, dot.y + dy + height


def taken_by(dot):
    """Its marker and its error bar"""
    yield dot.x - 5, dot.y - 5, dot.x + 5, dot.y + 5
    if dot.bar:
        yield dot.x - 4, min(dot.bar), dot.x + 4, max(dot.bar)


def choose(dot, taken, paths, frame):
    """The first free box, at best one that no path crosses; None where there is none."""
    free = [box for box in boxes(dot) if frame[0] < box[0] and frame[1] < box[1] and box[2] < frame[2] and box[3] < frame[3]
            and not any(overlap(box, other) for other in taken)]
    clear = (box for box in free if not any(crosses(path, box) for path in paths))
    return next(clear, free[0] if free else None)


def draw_labels(dots, paths, frame):
    """frame: (left, top, right, bottom) of the plot. What finds no place is left to its tooltip."""
    labelled = [dot for dot in dots if dot.label]
    if len(labelled) > MOST_LABELS:
        return []
    taken, parts = [box for dot in dots for box in taken_by(dot)], []
    for dot in labelled:
        box = choose(dot, taken, paths, frame)
        if box:
            taken.append(box)
            halo = 'fill="#333333" stroke="#ffffff" stroke-width="3" paint-order="stroke"'
            parts.append(text_at(box[0], box[3] - 3, dot.label, LABEL_SIZE, more=halo))
    return parts

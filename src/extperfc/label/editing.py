"""Edits of the boxes of one image. They take and return tuples of boxes; a selection is a set of indices."""

from extperfc.label.boxes import Box, clipped, moved, resized

EDGES_X, EDGES_Y = ("left", "right"), ("top", "bottom")
FLAGS = ("difficult", "truncated", "occluded")


def _near_edges(box, x, y, tolerance):
    """Edges of a box within `tolerance` px of a point; empty when the point is away from the whole border."""
    if not (box.x0 - tolerance <= x <= box.x1 + tolerance and box.y0 - tolerance <= y <= box.y1 + tolerance):
        return frozenset()
    # On a box narrower than two tolerances only the nearer edge counts.
    edges = {min(EDGES_X, key=lambda edge: abs(x - (box.x0 if edge == "left" else box.x1))),
             min(EDGES_Y, key=lambda edge: abs(y - (box.y0 if edge == "top" else box.y1)))}
    at = {"left": abs(x - box.x0), "right": abs(x - box.x1), "top": abs(y - box.y0), "bottom": abs(y - box.y1)}
    return frozenset(edge for edge in edges if at[edge] <= tolerance)


def hit(boxes, selection, x, y, tolerance):
    """What a press at (x, y) px takes hold of: (index, edges), with no edges for the inside; None for free space.

    Edges of selected boxes come first, so that a box below another one can be resized; then the smallest box around
    the point.
    """
    for index in sorted(selection):
        edges = _near_edges(boxes[index], x, y, tolerance)
        if edges:
            return index, edges
    inside = [i for i, box in enumerate(boxes) if box.x0 <= x < box.x1 and box.y0 <= y < box.y1]
    if inside:
        return min(inside, key=lambda i: (boxes[i].area, i not in selection)), frozenset()
    return None


def apply(boxes, selection, edit):
    """Boxes of which the selected ones went through a function."""
    return tuple(edit(box) if i in selection else box for i, box in enumerate(boxes))


def shifted(boxes, selection, dx, dy, size):
    """Selected boxes moved together by (dx, dy) px, as far as all of them stay in an image of `size`."""
    width, height = size
    chosen = [boxes[i] for i in selection]
    if not chosen:
        return boxes
    dx = max(-min(box.x0 for box in chosen), min(dx, width - max(box.x1 for box in chosen)))
    dy = max(-min(box.y0 for box in chosen), min(dy, height - max(box.y1 for box in chosen)))
    return apply(boxes, selection, lambda box: moved(box, dx, dy, width, height))


def stretched(boxes, selection, edges, dx, dy, size):
    """Selected boxes with some of their edges moved by (dx, dy) px."""
    return apply(boxes, selection, lambda box: resized(box, edges, dx, dy, *size))


def without(boxes, selection):
    """The boxes that are not selected."""
    return tuple(box for i, box in enumerate(boxes) if i not in selection)


def with_class(boxes, selection, name):
    """Selected boxes of another class."""
    return apply(boxes, selection, lambda box: box.replaced(name=name))


def with_flag_toggled(boxes, selection, flag):
    """Sets a flag of FLAGS on all selected boxes, or clears it when all of them have it."""
    wanted = not all(getattr(boxes[i], flag) for i in selection)
    return apply(boxes, selection, lambda box: box.replaced(**{flag: wanted}))


def with_added(boxes, added, size):
    """(boxes, selection of the added ones): boxes from elsewhere, clipped to an image of `size`; equal ones are not
    doubled."""
    fitting = [box for box in (clipped(one, *size) for one in added) if box and box not in boxes]
    return (*boxes, *fitting), set(range(len(boxes), len(boxes) + len(fitting)))


def drawn(name, start, end, size):
    """The box between two points (px), clipped to an image of `size`; None when it is too small."""
    x0, y0, x1, y1 = (round(value) for value in (*start, *end))
    return clipped(Box(name, min(x0, x1), min(y0, y1), max(x0, x1), max(y0, y1)), *size)

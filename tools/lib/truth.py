"""Compares detections with the simulator's ground truth; knows neither ROS nor images."""

import collections

import numpy

MIN_OVERLAP = 0.5  # of a detection's box and a visible object's, as intersection over union

Box = collections.namedtuple("Box", "label corners")         # corners: x0 y0 x1 y1 [px], edges of the pixels
TrueObject = collections.namedtuple("TrueObject", "label position")    # position: centre, 3 values [m]
Nearest = collections.namedtuple("Nearest", "object error_m")


def overlap(a, b):
    """Intersection over union of two boxes' corners, 0 to 1."""
    width = min(a[2], b[2]) - max(a[0], b[0])
    height = min(a[3], b[3]) - max(a[1], b[1])
    if width <= 0 or height <= 0:
        return 0.0
    both = width * height
    return both / ((a[2] - a[0]) * (a[3] - a[1]) + (b[2] - b[0]) * (b[3] - b[1]) - both)


def match(detections, visible, min_overlap=MIN_OVERLAP):
    """For each detection the index of the visible object that it is, or None.

    `detections` are Box, the best first; each takes the object of its class that it overlaps most, unless another took it.
    """
    free = set(range(len(visible)))
    matches = []
    for found in detections:
        overlaps = [(overlap(found.corners, visible[i].corners), i) for i in free if visible[i].label == found.label]
        best, index = max(overlaps, default=(0.0, None))
        if index is not None and best < min_overlap:
            index = None
        free.discard(index)
        matches.append(index)
    return matches


def nearest(label, position, objects):
    """The object of this class whose centre is nearest to `position`, as Nearest; or None."""
    position = numpy.asarray(position)
    near = [Nearest(t, float(numpy.linalg.norm(numpy.asarray(t.position) - position))) for t in objects if t.label == label]
    return min(near, key=lambda n: n.error_m, default=None)


class Score:
    """Sums of all frames."""

    def __init__(self):
        self.frames = 0
        self.visible = 0
        self.found = 0
        self.false = 0
        self.errors_m = []

    def add(self, visible, matches, errors_m):
        """One frame: number of visible objects, result of match(), position errors of detections that are an object."""
        self.frames += 1
        self.visible += visible
        self.found += sum(index is not None for index in matches)
        self.false += sum(index is None for index in matches)
        self.errors_m += errors_m

    def summary(self):
        """Lines for people."""
        if not self.frames:
            return []
        fraction = f" ({100 * self.found / self.visible:.0f} %)" if self.visible else ""
        lines = [f"found {self.found} of {self.visible} visible objects in {self.frames} frames{fraction}, "
                 f"{self.false} false detections"]
        if self.errors_m:
            lines.append(f"position of the objects' centres: mean error {100 * numpy.mean(self.errors_m):.1f} cm, "
                         f"95 % are below {100 * numpy.percentile(self.errors_m, 95):.1f} cm")
        return lines

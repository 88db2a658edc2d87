"""Counts of a labelled folder."""

import collections
import dataclasses
import statistics

SMALL_PX = 16  # boxes with a shorter side are hard to detect


@dataclasses.dataclass
class ClassCounts:
    """Boxes of one class. sides_px: square root of the area of each box."""

    boxes: int = 0
    images: int = 0
    difficult: int = 0
    truncated: int = 0
    small: int = 0
    sides_px: list = dataclasses.field(default_factory=list)

    @property
    def median_side_px(self):
        return statistics.median(self.sides_px) if self.sides_px else 0.0

    def add(self, box):
        self.boxes += 1
        self.difficult += box.difficult
        self.truncated += box.truncated
        self.small += min(box.width, box.height) < SMALL_PX
        self.sides_px.append(box.area ** 0.5)


@dataclasses.dataclass
class Statistics:
    """Counts of images, and of boxes by class in the order of the document's classes."""

    images: int
    labelled: int
    empty: int
    by_class: dict

    @property
    def boxes(self):
        return sum(counts.boxes for counts in self.by_class.values())


def count(document):
    """Statistics of a document."""
    by_class = {name: ClassCounts() for name in document.classes()}
    images_of = collections.Counter()
    for name in document.names:
        for box in document.boxes(name):
            by_class[box.name].add(box)
        images_of.update({box.name for box in document.boxes(name)})
    for name, counts in by_class.items():
        counts.images = images_of[name]
    labelled = [name for name in document.names if document.is_labelled(name)]
    return Statistics(len(document.names), len(labelled), sum(not document.boxes(name) for name in labelled), by_class)


HEADINGS = ("class", "boxes", "images", "difficult", "truncated", f"under {SMALL_PX} px", "median side")


def rows(found):
    """Lines of a table under HEADINGS, as text."""
    return [(name, str(one.boxes), str(one.images), str(one.difficult), str(one.truncated), str(one.small),
             f"{one.median_side_px:.0f} px") for name, one in found.by_class.items()]


def summary(found):
    """One sentence on the images."""
    return (
        f"{found.labelled} of {found.images} images labelled, {found.empty} of them without objects; {found.boxes} "
        f"boxes"
    )


def as_text(found):
    """The table as plain text."""
    table = [HEADINGS, *rows(found)]
    widths = [max(len(row[i]) for row in table) for i in range(len(HEADINGS))]
    lines = [
        "  ".join(
            cell.ljust(width) if i == 0 else cell.rjust(width) for i, (cell, width) in enumerate(zip(row, widths)))
        for row in table
    ]
    return "\n".join([summary(found), *lines]) + "\n"

"""What a set of labelled images is, in any file format."""

import collections
import dataclasses
import hashlib
import pathlib
import typing

import cv2
import numpy as np

from ..errors import DataError

SHOWN_PROBLEMS = 20  # lines of an error message


class Problem(typing.NamedTuple):
    """A finding about one image or label file. Errors keep a set from being used, warnings do not."""

    kind: str  # e.g. "inverted_box"
    where: str  # file, or image name
    text: str
    is_error: bool = True

    def __str__(self):
        return f"{'error' if self.is_error else 'warning'}: {self.where}: {self.text}"


@dataclasses.dataclass(frozen=True, eq=False)
class Sample:
    """One labelled image.

    boxes: float32 [M, 4], x0 y0 x1 y1 in pixels of the image file; a box around the pixel column 7 alone goes from 7
    to 8. labels: int64 [M], indices into the class names, from 0, without a background. difficult: bool [M]. size:
    width and height of the image in pixels, (0, 0) when the label file does not state them.
    """

    name: str
    image: pathlib.Path
    boxes: np.ndarray
    labels: np.ndarray
    difficult: np.ndarray
    size: typing.Tuple[int, int] = (0, 0)

    def read_image(self):
        """uint8 [H, W, 3], RGB. DataError when the file is missing or no image."""
        image = cv2.imread(str(self.image), cv2.IMREAD_COLOR)
        if image is None:
            raise DataError(f"{self.image}: cannot be read as an image: restore it, or remove its labels")
        return cv2.cvtColor(image, cv2.COLOR_BGR2RGB)


def make_sample(name, image, rows, size=(0, 0)):
    """A sample from rows of (label, x0, y0, x1, y1, difficult)."""
    table = np.array(rows, np.float64).reshape(-1, 6)
    return Sample(name, pathlib.Path(image), table[:, 1:5].astype(np.float32), table[:, 0].astype(np.int64),
                  table[:, 5] > 0, tuple(size))


@dataclasses.dataclass(frozen=True, eq=False)
class Dataset:
    """Labelled images with their class names. splits: names of the samples by the name of the split."""

    root: pathlib.Path
    class_names: typing.Tuple[str, ...]
    samples: typing.Tuple[Sample, ...]
    splits: typing.Dict[str, typing.Tuple[str, ...]] = dataclasses.field(default_factory=dict)

    def __len__(self):
        return len(self.samples)

    def split(self, name):
        """The samples of one split, in the order of the set. DataError when there is no such split."""
        if name not in self.splits:
            known = ", ".join(sorted(self.splits)) or "none"
            raise DataError(f"{self.root}: no split \"{name}\" (there are: {known}); make splits with"
                            f" extperfc-train split {self.root}")
        wanted = set(self.splits[name])
        return dataclasses.replace(self, samples=tuple(s for s in self.samples if s.name in wanted), splits={})

    def counts(self):
        """Objects per class, difficult ones included: {class name: number}."""
        counted = collections.Counter(int(label) for sample in self.samples for label in sample.labels)
        return {name: counted[i] for i, name in enumerate(self.class_names)}

    def with_classes(self, class_names):
        """The same images with labels in the order of `class_names`; DataError when a label is not among them."""
        missing = [n for n, count in self.counts().items() if count and n not in class_names]
        if missing:
            raise DataError(f"{self.root}: has objects of {', '.join(missing)}, but the classes to learn are"
                            f" {', '.join(class_names)}: add them under data.classes, or remove the labels")
        index = np.array([class_names.index(n) if n in class_names else -1 for n in self.class_names] or [-1])
        samples = tuple(dataclasses.replace(s, labels=index[s.labels].astype(np.int64)) for s in self.samples)
        return dataclasses.replace(self, class_names=tuple(class_names), samples=samples)

    def checksum(self):
        """SHA-256 over names, image files, boxes and labels: the same data, the same digits, wherever they lie."""
        digest = hashlib.sha256("\n".join(self.class_names).encode())
        for sample in sorted(self.samples, key=lambda s: s.name):
            digest.update(sample.name.encode() + b"\0")
            digest.update(hashlib.sha256(sample.image.read_bytes()).digest())
            for part in (sample.boxes, sample.labels, sample.difficult):
                digest.update(np.ascontiguousarray(part).tobytes())
        return digest.hexdigest()


def refuse_errors(place, problems):
    """Raises DataError when a problem is an error; lists the first ones."""
    errors = [p for p in problems if p.is_error]
    if errors:
        lines = [f"  {p.where}: {p.text}" for p in errors[:SHOWN_PROBLEMS]]
        if len(errors) > SHOWN_PROBLEMS:
            lines.append(f"  ... and {len(errors) - SHOWN_PROBLEMS} more: extperfc-train check {place} lists all")
        raise DataError("\n".join([f"{place}: {len(errors)} errors:", *lines]))

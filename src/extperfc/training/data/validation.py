"""Report on a set of labelled images: what is missing, wrong, doubled, or in two splits."""

import collections
import dataclasses
import typing

from .dataset import DataError, Dataset, Problem
from .fingerprints import fingerprint, near_pairs
from .reading import box_fault, scan

TINY_BOX_PX = 4.0


@dataclasses.dataclass(frozen=True)
class Report:
    """What check() found. pairs: indices into dataset.samples of images that look alike."""

    dataset: Dataset
    problems: typing.Tuple[Problem, ...]
    pairs: typing.Tuple[typing.Tuple[int, int], ...]

    @property
    def errors(self):
        return [p for p in self.problems if p.is_error]

    def as_dict(self):
        """For JSON."""
        kinds = collections.Counter(p.kind for p in self.problems)
        return {"path": str(self.dataset.root), "images": len(self.dataset), "classes": self.dataset.counts(),
                "splits": {name: len(names) for name, names in self.dataset.splits.items()}, "kinds": dict(kinds),
                "problems": [p._asdict() for p in self.problems]}

    def text(self):
        """For a terminal: a summary, then a line for each problem."""
        data = self.as_dict()
        lines = [
            f"{data['path']}: {data['images']} images, {sum(data['classes'].values())} objects",
            "classes: " + ", ".join(f"{name} {count}" for name, count in data["classes"].items()),
            "splits: " + (", ".join(f"{n} {c}" for n, c in data["splits"].items()) or "none (extperfc-train split)")
        ]
        lines += [str(p) for p in self.problems]
        count = len(self.errors)
        lines.append(f"{count} errors, {len(self.problems) - count} warnings")
        return "\n".join(lines)


def check(path):
    """Reads everything below `path`, every image file included, and reports all problems at once."""
    dataset, problems = scan(path)
    prints, samples = [], []
    for sample in dataset.samples:
        try:
            prints.append(fingerprint(sample.image))
        except DataError as error:
            problems.append(
                Problem("unreadable_image", sample.image.name, f"{error}: restore it, or remove its labels"))
            continue
        samples.append(sample)
        problems += size_problems(sample, prints[-1].size)
    dataset = dataclasses.replace(dataset, samples=tuple(samples))
    pairs = near_pairs(prints)
    problems += double_problems(samples, prints, pairs) + leak_problems(dataset, pairs) + class_problems(dataset)
    return Report(dataset, tuple(problems), tuple(pairs))


def size_problems(sample, size):
    """Stated size against that of the file; boxes against the file's size where none was stated; specks."""
    problems = []
    if all(sample.size) and tuple(sample.size) != tuple(size):
        problems.append(
            Problem(
                "wrong_size", sample.name, f"the labels are for {sample.size[0]} x {sample.size[1]} pixels, but"
                f" the image has {size[0]} x {size[1]}: restore the image that was labelled"))
    for number, box in enumerate(sample.boxes, 1):
        kind, text = ("", "") if all(sample.size) else box_fault(box, size)
        if kind:
            problems.append(Problem(kind, sample.name, f"box {number} {text}", kind != "box_over_edge"))
        elif min(box[2] - box[0], box[3] - box[1]) < TINY_BOX_PX:
            problems.append(
                Problem("tiny_box", sample.name, f"box {number} is smaller than {TINY_BOX_PX:g} pixels: mark it"
                        " difficult, or delete it", False))
    return problems


def double_problems(samples, prints, pairs):
    """Images that are there twice. Those with different labels are errors: one of them must be wrong."""
    problems = []
    for i, j in pairs:
        one, other = samples[i], samples[j]
        if prints[i].sha256 != prints[j].sha256:
            problems.append(Problem("near_duplicate", other.name, f"looks like {one.name}", False))
        elif same_labels(one, other):
            problems.append(
                Problem("duplicate_image", other.name, f"is the same file as {one.name}: remove one", False))
        else:
            problems.append(
                Problem("duplicate_image", other.name, f"is the same file as {one.name} with other labels: keep"
                        " the right one"))
    return problems


def same_labels(one, other):
    return sorted((int(c), *map(float, b)) for c, b in zip(one.labels, one.boxes)) == sorted(
        (int(c), *map(float, b)) for c, b in zip(other.labels, other.boxes))


def leak_problems(dataset, pairs):
    """Images, or such that look alike, in two splits: what is tested was trained on."""
    home = collections.defaultdict(set)
    for split, names in dataset.splits.items():
        for name in names:
            home[name].add(split)
    problems = [Problem("split_leak", name, f"is in the splits {' and '.join(sorted(splits))}: make them again with"
                        " extperfc-train split") for name, splits in home.items() if len(splits) > 1]
    for i, j in pairs:
        one, other = dataset.samples[i].name, dataset.samples[j].name
        apart = [(a, b) for a in sorted(home[one]) for b in sorted(home[other]) if a != b]
        if apart:
            problems.append(
                Problem(
                    "split_leak", other, f"in {apart[0][1]} looks like {one} in {apart[0][0]}: make the splits"
                    " again with extperfc-train split"))
    return problems


def class_problems(dataset):
    """Classes that a split lacks; those that no image has."""
    problems = []
    for name, count in dataset.counts().items():
        if not count:
            problems.append(Problem("unused_class", "labels.txt", f"no image has a {name}", False))
    for split in dataset.splits:
        if not dataset.splits[split]:
            problems.append(
                Problem("empty_split", split, "has no image: make the splits again with extperfc-train split"))
            continue
        missing = [n for n, count in dataset.split(split).counts().items() if not count and dataset.counts()[n]]
        problems += [Problem("missing_class", split, f"has no {n}, though other splits do", False) for n in missing]
    return problems

"""COCO object detection files (cocodataset.org, "Data format", section 1: object detection).

A box is [x, y, width, height] in pixels from the image's upper left corner; a crowd region (`iscrowd`) counts as
difficult.
"""

import json
import pathlib
import re

from .dataset import Dataset, Problem, make_sample

SPLIT = re.compile(r"(?:^|_)(train|val|test)(?:\d{4})?$")


def coco_files(path):
    """The JSON files of a file, or of a folder with an optional `annotations` folder."""
    if path.is_file():
        return [path] if path.suffix == ".json" else []
    return sorted([*path.glob("*.json"), *(path / "annotations").glob("*.json")])


def is_coco(path):
    """Whether `path` is, or holds, a file in COCO's format."""
    return any(is_coco_file(file) for file in coco_files(path))


def is_coco_file(file):
    try:
        content = json.loads(file.read_text())
    except (ValueError, OSError):
        return path_says_coco(file)
    return isinstance(content, dict) and "images" in content and "categories" in content


def path_says_coco(file):
    """A damaged file that stands where COCO's do is reported, not passed over."""
    return bool(file.parent.name == "annotations" or SPLIT.search(file.stem))


def scan_coco(path):
    """(Dataset, problems) of a file, or of a folder whose files NAME_train.json, NAME_val.json, ... are its splits."""
    problems, samples, splits, class_names = [], {}, {}, []
    for file in filter(is_coco_file, coco_files(path)):
        try:
            content = json.loads(file.read_text())
        except ValueError as error:
            problems.append(Problem("bad_annotation", file.name, f"is no JSON ({error})"))
            continue
        names = add_file(content, file, class_names, samples, problems)
        found = SPLIT.search(file.stem)
        if found:
            splits[found[1]] = tuple(names)
    return Dataset(path, tuple(class_names), tuple(samples.values()), splits), problems


def add_file(content, file, class_names, samples, problems):
    """Adds a file's classes and images; returns the names of its images."""
    categories = {}
    for category in sorted(content.get("categories", []), key=lambda c: c.get("id", 0)):
        if category["name"] not in class_names:
            class_names.append(category["name"])
        categories[category["id"]] = class_names.index(category["name"])
    rows = {image["id"]: [] for image in content.get("images", [])}
    for note in content.get("annotations", []):
        row, text = read_note(note, categories, rows)
        if text:
            kind = "unknown_class" if "category" in text else "bad_annotation"
            problems.append(Problem(kind, file.name, f"annotation {note.get('id')}: {text}"))
        else:
            rows[note["image_id"]].append(row)
    names = []
    for image in content.get("images", []):
        name = pathlib.PurePath(image["file_name"]).with_suffix("").as_posix()
        names.append(name)
        place = image_place(file, image["file_name"])
        if place is None:
            problems.append(Problem("missing_image", file.name, f"image {image['file_name']} is in none of the folders"
                                    f" {', '.join(p.as_posix() for p in image_folders(file))}: restore it"))
            continue
        samples[name] = make_sample(name, place, rows[image["id"]], (image.get("width", 0), image.get("height", 0)))
    return [n for n in names if n in samples]


def read_note(note, categories, rows):
    """(row of make_sample, "") or (None, what is wrong)."""
    box = note.get("bbox")
    if note.get("image_id") not in rows:
        return None, f"there is no image with id {note.get('image_id')}"
    if note.get("category_id") not in categories:
        return None, f"there is no category with id {note.get('category_id')}: add it to categories"
    if not (isinstance(box, list) and len(box) == 4 and all(isinstance(v, (int, float)) for v in box)):
        return None, "bbox is not a list of four numbers"
    x, y, width, height = box
    return (categories[note["category_id"]], x, y, x + width, y + height, bool(note.get("iscrowd", 0))), ""


def image_folders(file):
    """Where the images of a COCO file may lie, the likely ones first."""
    base = file.parent.parent if file.parent.name == "annotations" else file.parent
    found = SPLIT.search(file.stem)
    split = file.stem[found.start():].lstrip("_") if found else "images"
    return [base / "images", base, base / split, base / "images" / split, base / "JPEGImages"]


def image_place(file, name):
    return next((folder / name for folder in image_folders(file) if (folder / name).exists()), None)


def to_coco(dataset):
    """A data set as COCO's dictionary; ids count from 1, in the order of the samples."""
    images, notes = [], []
    for number, sample in enumerate(dataset.samples, 1):
        images.append({"id": number, "file_name": sample.image.name, "width": sample.size[0], "height": sample.size[1]})
        for box, label, difficult in zip(sample.boxes, sample.labels, sample.difficult):
            x0, y0, x1, y1 = (float(v) for v in box)
            notes.append({"id": len(notes) + 1, "image_id": number, "category_id": int(label) + 1,
                          "bbox": [x0, y0, x1 - x0, y1 - y0], "area": (x1 - x0) * (y1 - y0), "iscrowd": int(difficult)})
    categories = [{"id": i, "name": name} for i, name in enumerate(dataset.class_names, 1)]
    return {"images": images, "annotations": notes, "categories": categories}

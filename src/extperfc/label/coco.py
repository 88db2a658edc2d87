"""COCO's detection format (cocodataset.org/#format-data): x, y, width, height in pixels that count from 0.

The flags of Pascal VOC are kept in `attributes` of each annotation. Unlabelled images are left out of an export,
since an image without annotations means one without objects.
"""

import dataclasses
import json

from extperfc.atomic_files import replace_file
from extperfc.label.boxes import from_floats

FLAGS = ("truncated", "difficult", "occluded")


class CocoError(Exception):
    """A COCO file cannot be used; the text says why and what to do."""


def to_coco(document):
    """The labelled images of a document as COCO's structure. Class and image ids count from 1."""
    category_ids = {name: i for i, name in enumerate(document.classes(), 1)}
    images, annotations = [], []
    for image_id, name in enumerate(filter(document.is_labelled, document.names), 1):
        width, height = document.size(name)
        images.append({"id": image_id, "file_name": document.folder.files[name].name, "width": width, "height": height})
        for box in document.boxes(name):
            annotations.append({
                "id": len(annotations) + 1, "image_id": image_id, "category_id": category_ids[box.name],
                "bbox": [box.x0, box.y0, box.width, box.height], "area": box.area, "iscrowd": 0, "segmentation": [],
                "attributes": {flag: getattr(box, flag) for flag in FLAGS}})
    return {"info": {"description": document.folder.path.resolve().name, "version": "1.0"}, "licenses": [],
            "images": images, "annotations": annotations,
            "categories": [{"id": i, "name": name, "supercategory": ""} for name, i in category_ids.items()]}


def export_file(document, file):
    """Writes a COCO file. Returns (images, boxes). Raises WriteError, and FolderError for an image that cannot be
    read."""
    content = to_coco(document)
    replace_file(file, (json.dumps(content, indent=1) + "\n").encode())
    return len(content["images"]), len(content["annotations"])


def read_file(file):
    """A COCO structure with its three lists. Raises CocoError."""
    try:
        with open(file, encoding="utf-8") as stream:
            content = json.load(stream)
    except OSError as error:
        raise CocoError(f"cannot read {file}: {error.strerror}") from None
    except ValueError as error:
        raise CocoError(f"{file} is no JSON file ({error}): give one in COCO's detection format") from None
    missing = [key for key in ("images", "annotations", "categories")
               if not isinstance(content, dict) or not isinstance(content.get(key), list)]
    if missing:
        raise CocoError(f"{file} has no list {' and no list '.join(missing)}: give one in COCO's detection format")
    return content


@dataclasses.dataclass
class Imported:
    """What an import did. replaced: images whose earlier labels it replaced. skipped: (what, why)."""

    images: int = 0
    boxes: int = 0
    replaced: int = 0
    skipped: list = dataclasses.field(default_factory=list)


def _boxes_by_image(content, result, sizes):
    """Boxes by image id; what cannot be used goes to result.skipped."""
    classes = {one["id"]: str(one["name"]) for one in content["categories"]}
    found = {}
    for one in content["annotations"]:
        image_id = one["image_id"]
        if image_id not in sizes:
            continue
        label = f"annotation {one.get('id', '?')}"
        if one.get("iscrowd"):
            result.skipped.append((label, "it marks a crowd, not an object"))
            continue
        x, y, width, height = map(float, one["bbox"])
        box = from_floats(classes[one["category_id"]], (x, y, x + width, y + height), *sizes[image_id])
        if box is None:
            result.skipped.append((label, "its box is empty or outside the image"))
            continue
        flags = one.get("attributes", {})
        found.setdefault(image_id, []).append(box.replaced(**{flag: bool(flags.get(flag, False)) for flag in FLAGS}))
    return found


def _stem_of(file_name):
    return str(file_name).replace("\\", "/").rsplit("/", 1)[-1].rsplit(".", 1)[0]


def _images_to_take(content, document, replace, result):
    """{image id: name} of the images that are in the folder and may be changed."""
    taken = {}
    for one in content["images"]:
        name = _stem_of(one["file_name"])
        if name not in document.folder.files:
            result.skipped.append((one["file_name"], "no such image in the folder"))
        elif document.is_labelled(name) and not replace:
            result.skipped.append((one["file_name"], "it is labelled already; --replace replaces its labels"))
        else:
            taken[one["id"]] = name
    return taken


def import_file(document, file, replace=False):
    """Takes the boxes of a COCO file over into a document, as one step of its history for each image. Images are
    found by the name of their file. Labelled ones are skipped unless `replace`. Returns Imported. Raises CocoError."""
    content, result = read_file(file), Imported()
    try:
        taken = _images_to_take(content, document, replace, result)
        found = _boxes_by_image(content, result, {image_id: document.size(name) for image_id, name in taken.items()})
    except (KeyError, TypeError, ValueError) as error:
        raise CocoError(f"{file} is not in COCO's detection format ({type(error).__name__}: {error})") from None
    for image_id, name in taken.items():
        result.replaced += document.is_labelled(name)
        boxes = found.get(image_id, [])
        document.change(name, boxes, "import of COCO labels")
        result.images, result.boxes = result.images + 1, result.boxes + len(boxes)
    for name in dict.fromkeys(box.name for boxes in found.values() for box in boxes):
        document.folder.add_class(name)
    return result

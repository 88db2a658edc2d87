"""Pascal VOC folders, as extperfc-render and extperfc-label write them.

JPEGImages/NAME.jpg (or .png), Annotations/NAME.xml, ImageSets/Main/SPLIT.txt with a name per line, labels.txt with a
class per line. Pixel numbers in the files count from 1 and include both ends (VOC development kit, section 4.1), so
that x0 = xmin - 1 and x1 = xmax.
"""

import xml.etree.ElementTree

import numpy as np

from .dataset import Dataset, Problem, make_sample

IMAGE_SUFFIXES = (".jpg", ".jpeg", ".png", ".bmp")
CORNERS = ("xmin", "ymin", "xmax", "ymax")


def is_voc_folder(path):
    """Whether `path` holds annotations in VOC's layout."""
    return (path / "Annotations").is_dir()


def scan_voc(path):
    """(Dataset, problems) of a folder; samples without an image or a readable label file are left out."""
    problems = []
    trees = {}
    for file in sorted((path / "Annotations").glob("*.xml")):
        try:
            trees[file.stem] = xml.etree.ElementTree.parse(file).getroot()
        except xml.etree.ElementTree.ParseError as error:
            problems.append(Problem("bad_annotation", file.name, f"is no XML ({error}): label the image again"))
    class_names = read_class_names(path, trees)
    images = image_files(path / "JPEGImages")
    samples = []
    for name, root in trees.items():
        image = find_image(images, name, root)
        if image is None:
            problems.append(Problem("missing_image", f"{name}.xml", f"no image JPEGImages/{name}.jpg or .png: restore"
                                    " it, or remove the label file"))
            continue
        rows, found = read_objects(root, name, class_names)
        problems += found
        samples.append(make_sample(name, image, rows, size_of(root)))
    for name in sorted(set(images) - set(trees) - {s.image.stem for s in samples}):
        problems.append(
            Problem(
                "missing_annotation", images[name].name, "has no label file in Annotations: label it (an"
                " image without objects has a file without boxes), or remove it", False))
    splits, found = read_splits(path, {s.name for s in samples})
    return Dataset(path, class_names, tuple(samples), splits), problems + found


def read_class_names(path, trees):
    """labels.txt, or else all names in the label files in alphabetical order."""
    file = path / "labels.txt"
    if file.exists():
        return tuple(line.strip() for line in file.read_text().splitlines() if line.strip())
    return tuple(
        sorted({(node.text or "").strip()
                for root in trees.values()
                for node in root.iterfind("object/name")}))


def image_files(folder):
    """Image files by name without suffix."""
    if not folder.is_dir():
        return {}
    return {file.stem: file for file in sorted(folder.iterdir()) if file.suffix.lower() in IMAGE_SUFFIXES}


def find_image(images, name, root):
    """The image of a label file: of its own name, or of the name in <filename>."""
    stated = (root.findtext("filename") or "").rsplit(".", 1)[0]
    return images.get(name) or images.get(stated)


def size_of(root):
    """(width, height) that the file states, or zeros."""
    try:
        return tuple(int(float(root.findtext(f"size/{side}"))) for side in ("width", "height"))
    except (TypeError, ValueError):
        return (0, 0)


def read_objects(root, name, class_names):
    """(rows of make_sample, problems) of one label file."""
    rows, problems = [], []
    for number, node in enumerate(root.iterfind("object"), 1):
        where, label = f"{name}.xml", (node.findtext("name") or "").strip()
        if label not in class_names:
            problems.append(
                Problem(
                    "unknown_class", where, f"object {number} is a \"{label}\", which labels.txt does not"
                    " list: add it there, or correct the label"))
            continue
        try:
            x0, y0, x1, y1 = (float(node.findtext(f"bndbox/{corner}")) for corner in CORNERS)
        except (TypeError, ValueError):
            problems.append(Problem("bad_annotation", where, f"object {number} has no bndbox with four numbers"))
            continue
        difficult = (node.findtext("difficult") or "0").strip() not in ("0", "")
        rows.append((class_names.index(label), x0 - 1, y0 - 1, x1, y1, difficult))
    return rows, problems


def read_splits(path, known):
    """(names by split, problems) of ImageSets/Main; without trainval, the union of two, and VOC's lists per class."""
    splits, problems = {}, []
    for file in sorted((path / "ImageSets" / "Main").glob("*.txt")):
        names = [line.strip() for line in file.read_text().splitlines() if line.strip()]
        if file.stem == "trainval" or file.stem.endswith(("_train", "_val", "_trainval", "_test")):
            continue
        for name in names:
            if name not in known:
                problems.append(
                    Problem(
                        "unknown_name", f"ImageSets/Main/{file.name}", f"lists {name}, which has no image"
                        " with labels: make the splits again with extperfc-train split"))
        splits[file.stem] = tuple(n for n in names if n in known)
    return splits, problems


def write_voc_sample(folder, sample, class_names):
    """Writes the label file of a sample below `folder`/Annotations."""
    root = xml.etree.ElementTree.Element("annotation")
    add = xml.etree.ElementTree.SubElement
    add(root, "folder").text = "JPEGImages"
    add(root, "filename").text = sample.image.name
    size = add(root, "size")
    for side, value in zip(("width", "height", "depth"), (*sample.size, 3)):
        add(size, side).text = str(value)
    for box, label, difficult in zip(sample.boxes, sample.labels, sample.difficult):
        node = add(root, "object")
        add(node, "name").text = class_names[label]
        add(node, "difficult").text = str(int(difficult))
        corners = add(node, "bndbox")
        for corner, value in zip(CORNERS, np.round(box).astype(int) + (1, 1, 0, 0)):
            add(corners, corner).text = str(value)
    file = folder / "Annotations" / f"{sample.name}.xml"
    file.write_bytes(xml.etree.ElementTree.tostring(root))

"""Reads a model folder (models/README.md) for detector.Detector.

Of the layouts it knows those of LAYOUTS; extperfc/detector and tools/extperfc-model run all of them.
"""

import dataclasses
import hashlib
import pathlib

import numpy as np
import yaml

LAYOUTS = {"ssd": 2, "ssd_priors": 2, "yolo_v7": 1, "yolo_v8": 1}  # number of output tensors
KEYS = {
    "": {"name", "file", "sha256", "input", "output", "classes", "classes_file", "thresholds", "source", "license"},
    "input": {"name", "width", "height", "color", "resize", "interpolation", "mean", "scale"},
    "output": {"layout", "names", "background_class", "apply_softmax", "variances", "priors", "anchors"},
    "thresholds": {"score", "nms_iou", "max_detections"},
    "output.priors": {"clip", "levels"},
    "output.priors.levels": {"stride", "rows", "columns", "min_size", "max_size", "aspect_ratios"},
}


class ModelError(Exception):
    """A model folder cannot be used; the text names it, what is wrong and the remedy."""


@dataclasses.dataclass(frozen=True)
class ModelSpec:
    """Content of model.yaml. mean, scale: arrays of 3 in the network's channel order. priors: (N, 4) of cx, cy, w, h
    in 0 to 1 of the input, or None. background_class: -1 without one."""

    name: str
    file: pathlib.Path
    width: int
    height: int
    is_bgr: bool
    is_letterbox: bool
    is_area: bool
    mean: np.ndarray
    scale: np.ndarray
    layout: str
    output_names: tuple
    background_class: int
    apply_softmax: bool
    variances: tuple
    priors: np.ndarray | None
    classes: tuple
    score: float
    nms_iou: float
    max_detections: int


class _Section:
    """A mapping of model.yaml whose values are checked; errors name file and key."""

    def __init__(self, values, path, file):
        self.path, self.file = path, file
        if not isinstance(values, dict):
            raise ModelError(f"{file}: {path or 'the file'} must be a mapping of keys (models/README.md)")
        self.values = values
        unknown = [str(key) for key in values if key not in KEYS[path]]
        if unknown:
            raise ModelError(f"{file}: unknown key {self.name_of(unknown[0])}: remove it (models/README.md lists all)")

    def name_of(self, key):
        return f"{self.path}.{key}" if self.path else key

    def fail(self, key, wanted):
        raise ModelError(f"{self.file}: {self.name_of(key)} must be {wanted}, not {self.values.get(key)!r}")

    def section(self, key, default=None):
        return _Section(self.values.get(key, default), self.name_of(key), self.file)

    def text(self, key, default=None):
        value = self.values.get(key, default)
        if not isinstance(value, str) or (default is None and not value):
            self.fail(key, "a text")
        return value

    def choice(self, key, names):
        value = self.values.get(key, names[0])
        if value not in names:
            self.fail(key, " or ".join(names))
        return value

    def number(self, key, low, high, default=None):
        value = self.values.get(key, default)
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not low <= value <= high:
            self.fail(key, f"a number in [{low}, {high}]")
        return value

    def integer(self, key, low, high, default=None):
        value = self.number(key, low, high, default)
        if int(value) != value:
            self.fail(key, f"a whole number in [{low}, {high}]")
        return int(value)

    def flag(self, key):
        value = self.values.get(key, False)
        if not isinstance(value, bool):
            self.fail(key, "true or false")
        return value

    def numbers(self, key, count, default):
        """`count` numbers as an array; one number stands for all."""
        value = self.values.get(key, default)
        values = value if isinstance(value, list) else [value] * count
        if len(values) != count or not all(isinstance(one, (int, float)) for one in values):
            self.fail(key, f"a number or a list of {count}")
        return np.array(values, np.float32)

    def texts(self, key):
        value = self.values.get(key, [])
        if not isinstance(value, list) or not all(isinstance(one, str)
                                                  for one in value) or len(set(value)) < len(value):
            self.fail(key, "a list of texts, each once")
        return tuple(value)


def _level_priors(level, width, height):
    """Priors of one feature map, cell after cell, as SSD's authors lay them out (Liu et al. 2016, section 2.2)."""
    stride = level.integer("stride", 1, 4096)
    columns = level.integer("columns", 1, 1024, -(-width // stride))
    rows = level.integer("rows", 1, 1024, -(-height // stride))
    low, high = level.number("min_size", 1e-3, 8192), level.number("max_size", 0, 8192, 0)
    sizes = [(low, low)] + ([((low * high) ** 0.5,) * 2] if high else [])
    for ratio in level.values.get("aspect_ratios", []):
        root = ratio ** 0.5
        sizes += [(low * root, low / root), (low / root, low * root)]
    ys, xs = np.mgrid[:rows, :columns]
    centers = np.stack([(xs + 0.5) * stride / width, (ys + 0.5) * stride / height], -1).reshape(-1, 1, 2)
    shape = np.array(sizes)[None] / (width, height)
    count = len(sizes)
    return np.concatenate([np.repeat(centers, count, 1), np.repeat(shape, len(centers), 0)], 2).reshape(-1, 4)


def _priors(output, width, height):
    listed = output.values.get("priors")
    if isinstance(listed, list):
        priors = np.array(listed, np.float64)
        if priors.ndim != 2 or priors.shape[1] != 4:
            output.fail("priors", "rows of four numbers cx, cy, w, h")
        return np.float32(priors)
    generator = output.section("priors")
    levels = generator.values.get("levels")
    if not isinstance(levels, list) or not levels:
        generator.fail("levels", "a list of feature maps")
    priors = np.concatenate(
        [_level_priors(_Section(one, "output.priors.levels", output.file), width, height) for one in levels])
    return np.float32(np.clip(priors, 0, 1) if generator.flag("clip") else priors)


def _layout(output):
    layout = output.text("layout")
    if layout not in LAYOUTS:
        raise ModelError(
            f"{output.file}: layout {layout} cannot propose boxes here: use a model of layout {', '.join(LAYOUTS)}, or "
            "export this network with its decoding (models/README.md)")
    return layout


def _classes(root, folder):
    if "classes_file" not in root.values:
        classes = root.texts("classes")
    else:
        file = folder / root.text("classes_file")
        try:
            classes = tuple(line.rstrip() for line in file.read_text(encoding="utf-8").rstrip().splitlines())
        except OSError as error:
            raise ModelError(f"cannot read {file}: {error.strerror}; correct classes_file in {root.file}") from None
    if not classes:
        root.fail("classes", "a list of names")
    return classes


def _network_file(root, folder):
    file = folder / root.text("file")
    try:
        content = file.read_bytes()
    except OSError as error:
        raise ModelError(f"cannot read {file}: {error.strerror}; correct `file` in {root.file}") from None
    stated = root.text("sha256", "").lower()
    if stated and hashlib.sha256(content).hexdigest() != stated:
        raise ModelError(f"{file} does not have the sha256 of {root.file}: copy the network again, or remove sha256")
    return file


def load(folder):
    """The ModelSpec of a folder. Raises ModelError."""
    folder = pathlib.Path(folder)
    file = folder / "model.yaml"
    try:
        values = yaml.safe_load(file.read_text(encoding="utf-8"))
    except OSError as error:
        raise ModelError(
            f"cannot read {file}: {error.strerror}; give a folder with a model.yaml, e.g. models/shapes") from None
    except yaml.YAMLError as error:
        raise ModelError(f"{file} is no YAML file: {' '.join(str(error).split())}") from None
    root = _Section(values, "", file)
    source, output, thresholds = root.section("input"), root.section("output"), root.section("thresholds", {})
    width, height = source.integer("width", 8, 4096), source.integer("height", 8, 4096)
    layout = _layout(output)
    names = output.texts("names")
    if len(names) not in ({LAYOUTS[layout]} if LAYOUTS[layout] > 1 else {0, 1}):
        output.fail("names", f"the {LAYOUTS[layout]} output tensors of layout {layout}")
    classes = _classes(root, folder)
    return ModelSpec(name=root.text("name"),
                     file=_network_file(root, folder),
                     width=width,
                     height=height,
                     is_bgr=source.choice("color", ("rgb", "bgr")) == "bgr",
                     is_letterbox=source.choice("resize", ("stretch", "letterbox")) == "letterbox",
                     is_area=source.choice("interpolation", ("linear", "area")) == "area",
                     mean=source.numbers("mean", 3, 0.0),
                     scale=source.numbers("scale", 3, 1.0),
                     layout=layout,
                     output_names=names,
                     background_class=output.integer("background_class", -1, len(classes), -1),
                     apply_softmax=output.flag("apply_softmax"),
                     variances=tuple(output.numbers("variances", 2, [0.1, 0.2])),
                     priors=_priors(output, width, height) if layout == "ssd_priors" else None,
                     classes=classes,
                     score=thresholds.number("score", 0, 1, 0.5),
                     nms_iou=thresholds.number("nms_iou", 0, 1, 0.45),
                     max_detections=thresholds.integer("max_detections", 1, 10000, 100))

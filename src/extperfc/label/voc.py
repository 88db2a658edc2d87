"""Pascal VOC annotation files, as tools/extperfc-render writes them.

Pixels of the file count from 1 and both ends of a box belong to it: xmin = x0 + 1 and xmax = x1 of boxes.Box.
Elements that are not known here are kept as text and written back.
"""

import dataclasses
import math
import xml.etree.ElementTree as ElementTree
from xml.sax.saxutils import escape

from extperfc.label.boxes import Box

KNOWN = {"folder", "filename", "source", "size", "segmented", "object"}
KNOWN_OF_OBJECT = {"name", "pose", "truncated", "occluded", "difficult", "visible", "bndbox"}
DATABASE = "extperfc-label"


class FormatError(Exception):
    """A file is not what it should be; the text names it and what to do."""


@dataclasses.dataclass(frozen=True)
class Annotation:
    """Content of one annotation file. width, height [px]: of the image."""

    filename: str
    width: int
    height: int
    boxes: tuple[Box, ...] = ()
    folder: str = "JPEGImages"
    source: str = f"<source><database>{DATABASE}</database></source>"
    segmented: str = "0"
    extra: tuple[str, ...] = ()


def _text(parent, path, default=None):
    found = parent.find(path)
    return default if found is None or found.text is None else found.text.strip()


def _number(parent, path, where, default=None):
    text = _text(parent, path)
    if text is None and default is not None:
        return default
    try:
        value = float(text)
    except (TypeError, ValueError):
        raise FormatError(f"{where}: <{path}> must be a number, not {text!r}: correct it or remove the file") from None
    if not math.isfinite(value):
        raise FormatError(f"{where}: <{path}> must be finite, not {text}: correct it or remove the file")
    return value


def _as_text(element):
    element.tail = None
    return ElementTree.tostring(element, encoding="unicode").strip()


def _rest(parent, known):
    return tuple(_as_text(child) for child in parent if child.tag not in known)


def _box(element, where):
    name = _text(element, "name")
    if not name:
        raise FormatError(f"{where}: an <object> has no <name>: correct it or remove the file")
    where = f"{where}, object {name}"
    low_x, low_y, high_x, high_y = (math.floor(_number(element, f"bndbox/{key}", where) + 0.5)
                                    for key in ("xmin", "ymin", "xmax", "ymax"))
    if high_x < low_x or high_y < low_y:
        raise FormatError(
            f"{where}: its box is inverted ({low_x}, {low_y}, {high_x}, {high_y}): correct it or remove the file")
    flags = {key: _number(element, key, where, 0.0) != 0 for key in ("truncated", "difficult", "occluded")}
    visible = _number(element, "visible", where) if element.find("visible") is not None else None
    return Box(name, low_x - 1, low_y - 1, high_x, high_y, pose=_text(element, "pose", "Unspecified"), visible=visible,
               extra=_rest(element, KNOWN_OF_OBJECT), **flags)


def parse(data, where):
    """The annotation in the bytes of a file; `where` names it in errors. Raises FormatError."""
    try:
        root = ElementTree.fromstring(data)
    except ElementTree.ParseError as error:
        raise FormatError(
            f"{where} is no XML file ({error}): correct it, or remove it to label the image anew") from None
    if root.tag != "annotation":
        raise FormatError(f"{where} holds <{root.tag}> and no Pascal VOC <annotation>: move it out of the folder")
    source = root.find("source")
    return Annotation(
        filename=_text(root, "filename", ""), width=int(_number(root, "size/width", where, 0.0)),
        height=int(_number(root, "size/height", where, 0.0)), folder=_text(root, "folder", ""),
        source=Annotation.source if source is None else _as_text(source), segmented=_text(root, "segmented", "0"),
        boxes=tuple(_box(element, where) for element in root.findall("object")), extra=_rest(root, KNOWN))


def _box_lines(box):
    yield "  <object>"
    yield f"    <name>{escape(box.name)}</name>"
    yield f"    <pose>{escape(box.pose)}</pose>"
    for key in ("truncated", "occluded", "difficult"):
        yield f"    <{key}>{int(getattr(box, key))}</{key}>"
    if box.visible is not None:
        yield f"    <visible>{box.visible:.3g}</visible>"
    yield "    <bndbox>"
    for key, value in (("xmin", box.x0 + 1), ("ymin", box.y0 + 1), ("xmax", box.x1), ("ymax", box.y1)):
        yield f"      <{key}>{value}</{key}>"
    yield "    </bndbox>"
    yield from (f"    {text}" for text in box.extra)
    yield "  </object>"


def to_xml(annotation):
    """The bytes of an annotation file."""
    lines = [
        "<annotation>", f"  <folder>{escape(annotation.folder)}</folder>",
        f"  <filename>{escape(annotation.filename)}</filename>", f"  {annotation.source}", "  <size>",
        f"    <width>{annotation.width}</width>", f"    <height>{annotation.height}</height>", "    <depth>3</depth>",
        "  </size>", f"  <segmented>{escape(annotation.segmented)}</segmented>"
    ]
    lines += [f"  {text}" for text in annotation.extra]
    for box in annotation.boxes:
        lines += _box_lines(box)
    return ("\n".join([*lines, "</annotation>"]) + "\n").encode()

"""A folder of images and their annotation files.

Two layouts: that of Pascal VOC, with JPEGImages/, Annotations/ and labels.txt; and a plain folder of images, beside
which Annotations/ and labels.txt are made. An image is labelled when its annotation file exists, with or without
objects in it.
"""

import errno
import fcntl
import os
import pathlib
import re
import struct

from extperfc.atomic_files import WriteError, make_folder, replace_file
from extperfc.label import voc

SUFFIXES = {".jpg", ".jpeg", ".png", ".bmp", ".webp"}
LOCK = ".extperfc-label.lock"


class FolderError(Exception):
    """A folder cannot be labelled; the text names it and the remedy."""


def natural_key(name):
    """Sorts image9 before image10."""
    return [int(part) if part.isdigit() else part.lower() for part in re.split(r"(\d+)", name)]


def _images_of(folder):
    return sorted(
        (file for file in folder.iterdir() if file.suffix.lower() in SUFFIXES and not file.name.startswith(".")),
        key=lambda file: natural_key(file.name))


def _refuse_twins(images):
    by_stem = {}
    for file in images:
        other = by_stem.setdefault(file.stem, file)
        if other is not file:
            raise FolderError(
                f"{other.name} and {file.name} in {file.parent} would have one annotation file: rename one of them")


class ImageFolder:
    """Paths, class names and annotation files of a folder. Images are known by their stem, e.g. "000012"."""

    def __init__(self, path):
        self.path = pathlib.Path(path)
        if not self.path.is_dir():
            raise FolderError(
                f"there is no folder {self.path}: give one with images, or one that extperfc-record wrote")
        inner = self.path / "JPEGImages"
        self.image_folder = inner if inner.is_dir() else self.path
        images = _images_of(self.image_folder)
        if not images:
            raise FolderError(f"{self.image_folder} holds no images ({', '.join(sorted(SUFFIXES))}): record some with "
                              "extperfc-record, or give another folder")
        _refuse_twins(images)
        self.files = {file.stem: file for file in images}
        self.annotations = self.path / "Annotations"
        self.classes = self._read_classes()
        self._lock = None

    @property
    def names(self):
        return list(self.files)

    @property
    def labels_file(self):
        return self.path / "labels.txt"

    def annotation_file(self, name):
        return self.annotations / f"{name}.xml"

    def is_labelled(self, name):
        return self.annotation_file(name).exists()

    def lock(self):
        """Keeps a second window off this folder until this process ends, however it ends. Raises FolderError."""
        try:
            self._lock = open(self.path / LOCK, "w", encoding="utf-8")
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            self._lock.close()
            raise FolderError(f"another extperfc-label has {self.path} open: close that window first") from None
        except OSError as error:
            if error.errno not in (errno.ENOLCK, errno.EOPNOTSUPP):
                raise FolderError(
                    f"cannot write into {self.path} ({error.strerror}): change its owner or mode, or copy the "
                    "folder to a disk that you can write to") from None

    def unlock(self):
        if self._lock:
            self._lock.close()
            self._lock = None

    def load(self, name):
        """The annotation of an image, or None where there is no file. Raises FormatError."""
        file = self.annotation_file(name)
        try:
            data = file.read_bytes()
        except FileNotFoundError:
            return None
        except OSError as error:
            raise voc.FormatError(f"cannot read {file}: {error.strerror}") from None
        return voc.parse(data, file)

    def save(self, name, annotation):
        """Writes an annotation file: the old one stays until the new one is whole and on the disk. Raises
        WriteError."""
        make_folder(self.annotations)
        replace_file(self.annotation_file(name), voc.to_xml(annotation))

    def remove(self, name):
        """Removes an annotation file: the image is unlabelled again. Raises WriteError."""
        try:
            self.annotation_file(name).unlink(missing_ok=True)
        except OSError as error:
            raise WriteError(
                f"cannot remove {self.annotation_file(name)}: {error.strerror}; is its folder read-only?") from None

    def add_class(self, name):
        """Appends a class to labels.txt. Raises FolderError for a name that the file cannot hold, and WriteError."""
        name = name.strip()
        if not name or "\n" in name:
            raise FolderError("a class needs a name of one line")
        if name in self.classes:
            return
        classes = [*self.classes, name]
        replace_file(self.labels_file, "".join(f"{one}\n" for one in classes).encode())
        self.classes = classes

    def _read_classes(self):
        try:
            lines = self.labels_file.read_text(encoding="utf-8").splitlines()
        except FileNotFoundError:
            return []
        except (OSError, UnicodeDecodeError) as error:
            raise FolderError(
                f"cannot read {self.labels_file} ({error}): it must be UTF-8 text with one class per line") from None
        return list(dict.fromkeys(line.strip() for line in lines if line.strip()))


def _png_size(head):
    return struct.unpack(">II", head[16:24])


def _jpeg_size(data):
    at = 2
    while at + 9 < len(data):
        if data[at] != 0xFF:
            return None
        kind = data[at + 1]
        if 0xC0 <= kind <= 0xCF and kind not in (0xC4, 0xC8, 0xCC):
            height, width = struct.unpack(">HH", data[at + 5:at + 9])
            return width, height
        at += 2 + struct.unpack(">H", data[at + 2:at + 4])[0] if kind != 0xFF else 1
    return None


def image_size(file):
    """(width, height) of an image [px]: from its header where that is quick, else by decoding it. Raises
    FolderError."""
    try:
        with open(file, "rb") as stream:
            data = stream.read(4096)
            if data[:2] == b"\xff\xd8" and _jpeg_size(data) is None:  # behind a preview or a colour profile
                data += stream.read(1 << 20)
    except OSError as error:
        raise FolderError(f"cannot read {file}: {error.strerror}") from None
    if data[:8] == b"\x89PNG\r\n\x1a\n" and len(data) >= 24:
        return _png_size(data)
    size = _jpeg_size(data) if data[:2] == b"\xff\xd8" else None
    if size:
        return size
    import cv2
    image = cv2.imread(os.fspath(file), cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION)
    if image is None:
        raise FolderError(f"{file} is not an image that OpenCV reads: remove it or convert it to JPEG or PNG")
    return image.shape[1], image.shape[0]

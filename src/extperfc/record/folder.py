"""The folder of a recording: Pascal VOC's, with Depth/ and camera.yaml, as tools/extperfc-label and the training
read it.

  JPEGImages/NNNNNN.jpg (or .png)   color
  Depth/NNNNNN.png                  16 bits, mm, aligned to color, 0: unknown
  ImageSets/Main/trainval.txt       names of all images
  labels.txt                        classes
  camera.yaml                       intrinsics, in the format of camera_calibration_parsers
"""

import pathlib
import re

import cv2
import numpy as np
import yaml

from extperfc.atomic_files import WriteError, create_file, make_folder, replace_file
from extperfc.record.frames import Intrinsics

NUMBER = re.compile(r"(\d{6,})\.\w+")
JPEG_QUALITY = 95
FORMATS = ("jpg", "png")


class FolderError(Exception):
    """A folder cannot be recorded into; the text names it and the remedy."""


def camera_yaml(camera):
    """Intrinsics as text."""
    fx, _, cx, _, fy, cy = camera.matrix[:6]

    def matrix(rows, columns, data):
        return {"rows": rows, "cols": columns, "data": [float(value) for value in data]}

    return yaml.safe_dump(
        {
            "image_width": camera.width, "image_height": camera.height, "camera_name": "camera", "camera_matrix":
            matrix(3, 3, camera.matrix), "distortion_model": camera.model, "distortion_coefficients": matrix(
                1, len(camera.distortion), camera.distortion), "rectification_matrix": matrix(
                    3, 3,
                    (1, 0, 0, 0, 1, 0, 0, 0, 1)), "projection_matrix": matrix(3, 4,
                                                                              (fx, 0, cx, 0, 0, fy, cy, 0, 0, 0, 1, 0))
        },
        sort_keys=False,
        default_flow_style=None)


def read_camera_yaml(file):
    """Intrinsics of a file. Raises FolderError."""
    try:
        content = yaml.safe_load(pathlib.Path(file).read_text(encoding="utf-8"))
        distortion = content.get("distortion_coefficients", {}).get("data", ())
        return Intrinsics(int(content["image_width"]), int(content["image_height"]),
                          tuple(float(value) for value in content["camera_matrix"]["data"]),
                          content.get("distortion_model", "plumb_bob"), tuple(float(value) for value in distortion))
    except OSError as error:
        raise FolderError(f"cannot read {file}: {error.strerror}") from None
    except (yaml.YAMLError, AttributeError, KeyError, TypeError, ValueError) as error:
        raise FolderError(
            f"{file} is no camera file ({' '.join(str(error).split())}): correct it, or record into a new folder"
        ) from None


def _encoded(suffix, image, settings=()):
    done, data = cv2.imencode(suffix, image, list(settings))
    if not done:
        raise WriteError(f"OpenCV cannot encode {suffix} images: install python3-opencv of your system")
    return data.tobytes()


class RecordingFolder:
    """Appends images. An image's file is written last, and only when it is whole: a pair is there when its color
    image is."""

    def __init__(self, path, suffix="jpg", classes=()):
        """Makes the folder, or goes on in one that has images already. Raises FolderError and WriteError."""
        self.path, self.suffix = pathlib.Path(path), suffix
        if self.path.exists() and not self.path.is_dir():
            raise FolderError(f"{self.path} is a file: give the name of a folder")
        self.images, self.depth = self.path / "JPEGImages", self.path / "Depth"
        self.sets = self.path / "ImageSets" / "Main"
        for folder in (self.images, self.sets):
            make_folder(folder)
        self._next = self._first_free_number()
        self._camera = read_camera_yaml(self.camera_file) if self.camera_file.exists() else None
        self._add_classes(classes)
        self._listed = self._read_list()

    @property
    def camera_file(self):
        return self.path / "camera.yaml"

    @property
    def set_file(self):
        return self.sets / "trainval.txt"

    def image_files(self):
        """The color images that are there, by number."""
        return sorted(file for file in self.images.iterdir() if NUMBER.fullmatch(file.name))

    def write(self, frame):
        """Writes a frame under the next number; returns its image file. Raises FolderError when its camera is
        another one than that of the folder, and WriteError, after which the folder is as before."""
        self._check_camera(frame)
        name = f"{self._next:06d}"
        depth_file = self.depth / f"{name}.png"
        if frame.depth_mm is not None:
            make_folder(self.depth)
            self._create(depth_file, _encoded(".png", np.uint16(frame.depth_mm)))
        try:
            file = self.images / f"{name}.{self.suffix}"
            self._create(file, _encoded(f".{self.suffix}", frame.color, (cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY)))
        except (WriteError, FolderError):
            if frame.depth_mm is not None:
                depth_file.unlink(missing_ok=True)
            raise
        self._next += 1
        self._list(name)
        return file

    @staticmethod
    def _create(file, data):
        try:
            create_file(file, data)
        except FileExistsError:
            raise FolderError(
                f"{file} appeared meanwhile: another program records into this folder; end it, or give another "
                "folder") from None

    def _first_free_number(self):
        """Behind every number that an image, a depth image or an annotation has."""
        numbers = [int(found[1]) for folder in (self.images, self.depth, self.path / "Annotations") if folder.is_dir()
                   for file in folder.iterdir() if (found := NUMBER.fullmatch(file.name))]
        return max(numbers, default=0) + 1

    def _check_camera(self, frame):
        height, width = frame.color.shape[:2]
        camera = frame.intrinsics
        if camera and (camera.width, camera.height) != (width, height):
            raise FolderError(
                f"the camera info is for {camera.width} x {camera.height} and the image is {width} x {height}: give "
                f"the "
                "--info-topic of the color image")
        if self._camera and (self._camera.width, self._camera.height) != (width, height):
            raise FolderError(
                f"the images are {width} x {height}, but {self.camera_file} is for {self._camera.width} x "
                f"{self._camera.height}: record into a new folder, or set the camera to that size")
        if camera and self._camera and not np.allclose(camera.matrix, self._camera.matrix, rtol=1e-3, atol=0.05):
            raise FolderError(
                f"{self.camera_file} describes another camera (focal length {self._camera.matrix[0]:.1f}, now "
                f"{camera.matrix[0]:.1f} px): record into a new folder")
        if camera and not self._camera:
            replace_file(self.camera_file, camera_yaml(camera).encode())
            self._camera = camera

    def _read_list(self):
        """Names of the set, completed by images that a kill left out of it."""
        listed = self.set_file.read_text().split() if self.set_file.exists() else []
        known = set(listed)
        return listed + [file.stem for file in self.image_files() if file.stem not in known]

    def _list(self, name):
        self._listed.append(name)
        replace_file(self.set_file, "".join(f"{one}\n" for one in self._listed).encode())

    def _add_classes(self, classes):
        file = self.path / "labels.txt"
        present = file.read_text(encoding="utf-8").split("\n") if file.exists() else []
        wanted = list(dict.fromkeys([one.strip() for one in (*present, *classes) if one.strip()]))
        if set(wanted) - set(present):
            replace_file(file, "".join(f"{one}\n" for one in wanted).encode())

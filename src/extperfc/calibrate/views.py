"""Views of a board: camera model, poses of the robot, and the folder that keeps both with the images.

A folder of views holds images and `views.yaml`:

    camera: {width: 640, height: 480, model: plumb_bob, K: [615, 0, 319.5, 0, 615, 239.5, 0, 0, 1], D: [0, 0, 0, 0, 0]}
    board: {kind: chessboard, columns: 9, rows: 6, square_m: 0.025}
    frames: {parent: head, carrier: left_gripper, camera: camera_color_optical_frame}
    views:
      - {image: view_00.png, parent_T_carrier: [x, y, z, qx, qy, qz, qw]}

`frames` may also name the link that the camera's driver hangs its frames on, and where it is:
`mount: camera_link` and `camera_T_mount: [x, y, z, qx, qy, qz, qw]`.
"""

import dataclasses
import math
import pathlib
import typing

import cv2
import numpy
import yaml

from extperfc import robot_description as rd
from extperfc.calibrate import board as boards

FILE = "views.yaml"
MODELS = {
    "plumb_bob": (0, 4, 5),
    "rational_polynomial": (8, 12, 14),
    "equidistant": (4, )
}  # and numbers of coefficients


class ViewsError(ValueError):
    """Views that cannot be used; the text says why and what to do."""


def pose_of_numbers(numbers):
    """4 x 4 of (x, y, z, qx, qy, qz, qw). Raises ViewsError."""
    try:
        values = [float(number) for number in numbers]
        if len(values) != 7 or not all(math.isfinite(value) for value in values):
            raise ValueError("seven finite numbers are needed")
        return rd.transform(values[:3], rd.rotation_of_quaternion(*values[3:]))
    except (TypeError, ValueError) as error:
        raise ViewsError(f"{numbers} is no pose [x, y, z, qx, qy, qz, qw]: {error}") from None


def numbers_of_pose(pose):
    """(x, y, z, qx, qy, qz, qw) of a 4 x 4."""
    return [float(value) for value in (*pose[:3, 3], *rd.quaternion_of_rotation(pose[:3, :3]))]


@dataclasses.dataclass(frozen=True)
class Camera:
    """A calibrated camera; `model` as in sensor_msgs/CameraInfo."""
    width: int
    height: int
    matrix: numpy.ndarray      # 3 x 3 [px]
    distortion: numpy.ndarray
    model: str = "plumb_bob"

    def __post_init__(self):
        if self.model not in MODELS:
            raise ViewsError(f"distortion model '{self.model}' is unknown: use one of {', '.join(MODELS)}")
        if len(self.distortion) not in MODELS[self.model]:
            raise ViewsError(f"{self.model} has {MODELS[self.model]} coefficients, not {len(self.distortion)}")
        if not (numpy.isfinite(self.matrix).all() and min(self.matrix[0, 0], self.matrix[1, 1]) > 0):
            raise ViewsError(
                "the camera is not calibrated: its focal lengths must be positive; run camera_calibration first")

    @property
    def focal(self):
        """(fx, fy) [px]."""
        return numpy.array([self.matrix[0, 0], self.matrix[1, 1]])

    def rays(self, pixels):
        """n x 2: x / z and y / z of what n x 2 [px] see."""
        points = numpy.asarray(pixels, float).reshape(-1, 1, 2)
        undistort = cv2.fisheye.undistortPoints if self.model == "equidistant" else cv2.undistortPoints
        return undistort(points, self.matrix, self._coefficients()).reshape(-1, 2)

    def project(self, points, camera_T_points):
        """n x 2 [px] of n x 3 [m] before the camera."""
        rotation, _ = cv2.Rodrigues(camera_T_points[:3, :3])
        arguments = (numpy.asarray(points, float).reshape(-1, 1, 3), rotation, camera_T_points[:3, 3], self.matrix)
        if self.model == "equidistant":
            return cv2.fisheye.projectPoints(*arguments, self._coefficients())[0].reshape(-1, 2)
        return cv2.projectPoints(*arguments, self._coefficients())[0].reshape(-1, 2)

    def _coefficients(self):
        return numpy.asarray(self.distortion, float) if len(self.distortion) else numpy.zeros(4)

    def as_dict(self):
        return {"width": int(self.width), "height": int(self.height), "model": self.model,
                "K": [float(value) for value in self.matrix.ravel()], "D": [float(value) for value in self.distortion]}


def camera_of_dict(fields):
    """The Camera of an as_dict(). Raises ViewsError."""
    try:
        matrix = numpy.array(fields["K"], float).reshape(3, 3)
        return Camera(int(fields["width"]), int(fields["height"]), matrix, numpy.array(fields.get("D", []), float),
                      fields.get("model", "plumb_bob"))
    except ViewsError:
        raise
    except (KeyError, TypeError, ValueError) as error:
        raise ViewsError(f"camera: needs width, height, K (nine numbers) and D: {error}") from None


@dataclasses.dataclass(frozen=True)
class Frames:
    """Names of the links. The camera is fixed to `parent`, the board to `carrier`; `camera` is the optical frame."""
    parent: str
    carrier: str
    camera: str
    mount: str = ""  # link on which the driver hangs the camera's frames; empty: `camera`
    camera_T_mount: typing.Optional[numpy.ndarray] = None

    def child_T_camera(self):
        """(name of the link to place, link_T_camera)."""
        if self.mount and self.camera_T_mount is not None:
            return self.mount, rd.inverse(self.camera_T_mount)
        return self.camera, numpy.eye(4)

    def as_dict(self):
        fields = {"parent": self.parent, "carrier": self.carrier, "camera": self.camera}
        if self.mount and self.camera_T_mount is not None:
            fields.update(mount=self.mount, camera_T_mount=numbers_of_pose(self.camera_T_mount))
        return fields


def frames_of_dict(fields):
    try:
        names = [str(fields[name]) for name in ("parent", "carrier", "camera")]
        if "mount" not in fields:
            return Frames(*names)
        return Frames(*names, str(fields["mount"]), pose_of_numbers(fields["camera_T_mount"]))
    except (KeyError, TypeError) as error:
        raise ViewsError(f"frames: needs parent, carrier and camera; {error} is missing") from None


@dataclasses.dataclass(frozen=True)
class View:
    """One image of the board."""
    name: str
    parent_T_carrier: numpy.ndarray
    detection: boards.Detection


@dataclasses.dataclass
class ViewSet:
    """All views of a calibration."""
    camera: Camera
    board: object
    frames: Frames
    views: list
    folder: typing.Optional[pathlib.Path] = None
    unseen: list = dataclasses.field(default_factory=list)  # names of images in which the board was not found


def grey_of(image):
    """8-bit grey image of a grey or BGR one."""
    return image if image.ndim == 2 else cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)


class FolderWriter:
    """Writes a folder of views, so that it is complete after every view."""

    def __init__(self, folder, camera, board, frames):
        self.folder = pathlib.Path(folder)
        if (self.folder / FILE).exists():
            raise ViewsError(f"{self.folder} holds views already: name another folder, or solve those")
        self.folder.mkdir(parents=True, exist_ok=True)
        self._fields = {"camera": camera.as_dict(), "board": board.as_dict(), "frames": frames.as_dict(), "views": []}

    def add(self, image, parent_T_carrier):
        """The view's name; the image is BGR or grey."""
        name = f"view_{len(self._fields['views']):02d}.png"
        cv2.imwrite(str(self.folder / name), image)
        self._fields["views"].append({"image": name, "parent_T_carrier": numbers_of_pose(parent_T_carrier)})
        unfinished = self.folder / (FILE + ".new")
        unfinished.write_text(yaml.safe_dump(self._fields, default_flow_style=None, sort_keys=False, width=140))
        unfinished.replace(self.folder / FILE)
        return name


def load(folder):
    """The ViewSet of a folder; looks for the board in every image. Raises ViewsError and BoardError."""
    folder = pathlib.Path(folder)
    fields = _read_yaml(folder / FILE)
    missing = [name for name in ("camera", "board", "frames", "views") if name not in fields]
    if missing:
        raise ViewsError(f"{folder / FILE}: {', '.join(missing)} missing; docs/calibration.md has an example")
    views = ViewSet(camera_of_dict(fields["camera"]), boards.board_of_dict(fields["board"]),
                    frames_of_dict(fields["frames"]), [], folder)
    images = [_read_view(views, item) for item in fields["views"] or []]  # all, before the slow search for boards
    for name, pose, image in images:
        detection = views.board.detect(image)
        if detection is None:
            views.unseen.append(name)
        else:
            views.views.append(View(name, pose, detection))
    return views


def _read_view(views, item):
    """(name, parent_T_carrier, grey image) of an item of the file. Raises ViewsError."""
    if not isinstance(item, dict) or not {"image", "parent_T_carrier"} <= item.keys():
        raise ViewsError(f"{views.folder / FILE}: a view needs image and parent_T_carrier, not {item}")
    pose = pose_of_numbers(item["parent_T_carrier"])
    image = cv2.imread(str(views.folder / item["image"]), cv2.IMREAD_GRAYSCALE)
    if image is None:
        raise ViewsError(f"{views.folder / item['image']} is missing or no image")
    if image.shape != (views.camera.height, views.camera.width):
        raise ViewsError(f"{item['image']} has {image.shape[1]} x {image.shape[0]} pixels, the camera's calibration is for "
                         f"{views.camera.width} x {views.camera.height}")
    return item["image"], pose, image


def _read_yaml(file):
    if not file.is_file():
        raise ViewsError(f"{file.parent} holds no {file.name}: collect views first (extperfc-calibrate collect --help)")
    try:
        fields = yaml.safe_load(file.read_text())
    except yaml.YAMLError as error:
        raise ViewsError(f"{file} is no YAML: {error}") from None
    if not isinstance(fields, dict):
        raise ViewsError(f"{file} should hold camera, board, frames and views")
    return fields

"""A calibration board in the simulated robot's gripper, and poses of the arm in which the camera sees it. No ROS."""

import math

import numpy

from extperfc import robot_description as rd

THICKNESS_M = 0.004
INK_M = 1e-4           # by which dark cells stand out, so that they hide the white below
HOLD_M = 0.09          # of the board's middle from the gripper's frame, along the gripper's z axis
LINK = "calibration_board"
# As a sign in the fingers, which close along y: its x axis is the gripper's, its upper edge points away from the hand.
SIGN = numpy.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
RANGE_M = (0.50, 0.75)  # of the board's middle from the camera
TILT_RAD = (math.radians(12), math.radians(38))
ROLL_RAD = math.radians(45)
INSIDE = 0.9            # fraction of the image around its middle that all corners of the board have to be in


def middle_of(board):
    """board_T_middle of the print."""
    x, y, width, height = board.outline()
    return rd.transform((x + width / 2, y + height / 2, 0))


def nominal_grip(board):
    """gripper_T_board of a board that is held as it should be."""
    return rd.transform((0, 0, HOLD_M), SIGN) @ rd.inverse(middle_of(board))


def _box(size, xyz, rgb):
    numbers = [" ".join(f"{value:.6f}" for value in values) for values in (xyz, size, rgb)]
    return (
        f'<visual><origin xyz="{numbers[0]}"/><geometry><box size="{numbers[1]}"/></geometry>'
        f'<material name="{LINK}_{"_".join(f"{v:.2f}" for v in rgb)}"><color rgba="{numbers[2]} 1"/></material></visual>'
    )


def with_board(urdf, board, carrier, carrier_T_board):
    """The URDF's text with the board fixed to the link `carrier`; dark cells are thin boxes on a white plate."""
    x, y, width, height = board.outline()
    looks = [_box((width, height, THICKNESS_M), (x + width / 2, y + height / 2, THICKNESS_M / 2), (0.95, 0.95, 0.95))]
    looks += [
        _box((w, h, 2 * INK_M), (cx + w / 2, cy + h / 2, 0), (0.03, 0.03, 0.03)) for cx, cy, w, h in board.dark_cells()
    ]
    rpy = " ".join(f"{value:.9f}" for value in rpy_of(carrier_T_board[:3, :3]))
    xyz = " ".join(f"{value:.9f}" for value in carrier_T_board[:3, 3])
    link = (
        f'<link name="{LINK}">{"".join(looks)}</link><joint name="{LINK}_joint" type="fixed"><origin xyz="{xyz}" rpy="{rpy}"/>'
        f'<parent link="{carrier}"/><child link="{LINK}"/></joint>')
    return urdf.replace("</robot>", link + "</robot>")


def rpy_of(rotation):
    from extperfc.calibrate.result import rpy_of_rotation
    return rpy_of_rotation(rotation)


def random_pose(random, board):
    """A camera_T_board with the board before the camera, its front to it, tilted and rolled."""
    z = random.uniform(*RANGE_M)
    tilt_axis = random.uniform(0, 2 * math.pi)
    rotation = (rd.rotation_about((math.cos(tilt_axis), math.sin(tilt_axis), 0), random.uniform(*TILT_RAD)) @
                rd.rotation_about((0, 0, 1), random.uniform(-ROLL_RAD, ROLL_RAD)))
    middle = (random.uniform(-0.3, 0.3) * z, random.uniform(-0.2, 0.2) * z, z)
    return rd.transform(middle, rotation) @ rd.inverse(middle_of(board))


def is_in_image(camera_T_board, board, camera):
    """Whether all of the print is well within the image of a views.Camera."""
    x, y, width, height = board.outline()
    corners = numpy.array([[x, y, 0], [x + width, y, 0], [x, y + height, 0], [x + width, y + height, 0]])
    size = numpy.array([camera.width, camera.height])
    off = numpy.abs(camera.project(corners, camera_T_board) - size / 2)
    return bool((off < INSIDE * size / 2).all())


def arm_poses(kinematics, base_T_camera, board, camera, random):
    """7 joint positions [rad], again and again, in which the board is seen, as far as the robot's description is
    right."""
    last = kinematics.neutral
    while True:
        camera_T_board = random_pose(random, board)
        if not is_in_image(camera_T_board, board, camera):
            continue
        joints = kinematics.solve(base_T_camera @ camera_T_board @ rd.inverse(nominal_grip(board)),
                                  random,
                                  tries=3,
                                  start=last)
        if joints is not None:
            last = joints
            yield joints


def random_offset(random, max_m, max_rad):
    """A 4 x 4 with a translation of 0.5 to 1 times max_m and such a rotation, in random directions."""
    def direction():
        vector = random.normal(size=3)
        return vector / numpy.linalg.norm(vector)
    return rd.transform(random.uniform(0.5, 1) * max_m * direction(),
                        rd.rotation_about(direction(), random.uniform(0.5, 1) * max_rad))

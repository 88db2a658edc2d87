"""The URDF's text from figures.py and looks.py."""

from math import pi

from generator import figures as f
from generator.looks import COLOURS, LOOKS

HEADER = """<?xml version="1.0"?>
<!-- Made by urdf/generate.py from urdf/generator/figures.py: change those and run it again.
     A Baxter on a mobile base with four mecanum wheels, a VLP-16 in the birdcage under the torso and a RealSense D435i
     above the screen. Baxter's frames, limits, masses and arm collision shapes are those of the manufacturer's
     published description (BSD-3-Clause); all meshes are our own. -->
<robot name="mobile_baxter">
"""
SIDES = ("left", "right")


def numbers(values):
    return " ".join(f"{0.0 if abs(v) < 1e-12 else v:.12g}" for v in values)


def origin(xyz=(0, 0, 0), rpy=(0, 0, 0)):
    return f'<origin xyz="{numbers(xyz)}" rpy="{numbers(rpy)}"/>'


def inertial(mass, centre, tensor):
    ixx, ixy, ixz, iyy, iyz, izz = (f"{v:.12g}" for v in tensor)
    return (f'    <inertial>\n      {origin(centre)}\n      <mass value="{mass:.12g}"/>\n      <inertia ixx="{ixx}" '
            f'ixy="{ixy}" ixz="{ixz}" iyy="{iyy}" iyz="{iyz}" izz="{izz}"/>\n    </inertial>\n')


def of_box(mass, size, centre=(0, 0, 0)):
    """A homogeneous box."""
    x, y, z = (mass / 12 * v * v for v in size)
    return inertial(mass, centre, (y + z, 0, 0, x + z, 0, x + y))


def of_cylinder_along_y(mass, radius, length):
    across = mass * (3 * radius ** 2 + length ** 2) / 12
    return inertial(mass, (0, 0, 0), (across, 0, 0, mass * radius ** 2 / 2, 0, across))


def visuals(look, xyz=(0, 0, 0), rpy=(0, 0, 0)):
    return "".join(
        f'    <visual>\n      {origin(xyz, rpy)}\n      <geometry><mesh filename="package://extperfc/urdf/meshes/'
        f'{look}_{part}.stl"/></geometry>\n      <material name="{colour}"/>\n    </visual>\n'
        for part, colour, _ in LOOKS[look])


def collision(geometry, xyz=(0, 0, 0), rpy=(0, 0, 0)):
    return (f"    <collision>\n      {origin(xyz, rpy)}\n      <geometry>{geometry}</geometry>\n    </collision>\n")


def box(size):
    return f'<box size="{numbers(size)}"/>'


def cylinder(radius, length):
    return f'<cylinder radius="{radius:.12g}" length="{length:.12g}"/>'


def sphere(radius):
    return f'<sphere radius="{radius:.12g}"/>'


def link(name, *parts):
    content = "".join(parts)
    return f'  <link name="{name}">\n{content}  </link>\n' if content else f'  <link name="{name}"/>\n'


def frame(name, *parts):
    """A link of Baxter that is a frame, or the skin of its neighbour."""
    return link(name, inertial(*f.FRAME_INERTIAL), *parts)


def joint(name, kind, parent, child, xyz=(0, 0, 0), rpy=(0, 0, 0), *parts):
    content = "".join(f"    {part}\n" for part in parts)
    return (f'  <joint name="{name}" type="{kind}">\n    <parent link="{parent}"/>\n    <child link="{child}"/>\n'
            f"    {origin(xyz, rpy)}\n{content}  </joint>\n")


def fixed(name, parent, child, xyz=(0, 0, 0), rpy=(0, 0, 0)):
    return joint(name, "fixed", parent, child, xyz, rpy)


def axis(xyz):
    return f'<axis xyz="{numbers(xyz)}"/>'


def limit(effort, velocity, lower=None, upper=None):
    bounds = "" if lower is None else f'lower="{lower:.12g}" upper="{upper:.12g}" '
    return f'<limit {bounds}effort="{effort:.12g}" velocity="{velocity:.12g}"/>'


def materials():
    return "".join(f'  <material name="{name}"><color rgba="{numbers(rgb)} 1"/></material>\n'
                   for name, rgb in COLOURS.items())


# ---------------------------------------------------------------------------------------------- mobile base
def base():
    bottom = f.CHASSIS_CLEARANCE - f.FLOOR_TO_AXLE
    size = (*f.FOOTPRINT, f.CHASSIS_TOP - bottom)
    centre = (0, 0, (f.CHASSIS_TOP + bottom) / 2)
    return "".join([
        link("base_footprint"), link("base_link"),
        fixed("base_footprint_joint", "base_footprint", "base_link", (0, 0, f.FLOOR_TO_AXLE)),
        "  <!-- The chassis' collision box holds the wheels, which have none of their own. -->\n",
        link("chassis", of_box(f.CHASSIS_MASS, size, centre), visuals("chassis"), collision(box(size), centre)),
        fixed("chassis_joint", "base_link", "chassis"), *map(wheel, ("front_left", "front_right", "rear_left",
                                                                    "rear_right")),
        link("imu_link"), fixed("imu_joint", "base_link", "imu_link", f.IMU_XYZ), lidar(), birdcage(), link("base"),
        fixed("base_joint", "base_link", "base", (0, 0, f.AXLE_TO_BAXTER))])


def wheel(place):
    end, side = place.split("_")
    x, y = f.WHEEL_XY[0] * (1 if end == "front" else -1), f.WHEEL_XY[1] * (1 if side == "left" else -1)
    # Seen from above, the upper rollers of the four wheels point to a cross's middle.
    look = "wheel_left_handed" if place in ("front_left", "rear_right") else "wheel_right_handed"
    name, body = f"wheel_{place}", of_cylinder_along_y(f.WHEEL_MASS, f.WHEEL_RADIUS, f.WHEEL_WIDTH)
    return link(name, body, visuals(look)) + joint(
        f"{name}_joint", "continuous", "base_link", name, (x, y, 0), (0, 0, 0), axis((0, 1, 0)),
        limit(f.WHEEL_MAX_EFFORT, f.WHEEL_MAX_SPEED))


def lidar():
    size = (2 * f.LIDAR_RADIUS, 2 * f.LIDAR_RADIUS, f.LIDAR_HEIGHT)
    centre = (0, 0, f.LIDAR_HEIGHT / 2)
    return "".join([
        link("velodyne_base", of_box(f.LIDAR_MASS, size, centre), visuals("velodyne_base"),
             collision(cylinder(f.LIDAR_RADIUS, f.LIDAR_HEIGHT), centre)),
        fixed("velodyne_base_joint", "base_link", "velodyne_base", (0, 0, f.LIDAR_MOUNT)), link("velodyne"),
        fixed("velodyne_joint", "velodyne_base", "velodyne", (0, 0, f.LIDAR_SCAN - f.LIDAR_MOUNT))])


def birdcage():
    height = f.PLATE_BOTTOM - f.CHASSIS_TOP
    x, y, z = (*f.POST_XY, f.CHASSIS_TOP + height / 2)
    posts = [collision(cylinder(f.POST_RADIUS, height), (sx * x, sy * y, z)) for sx in (-1, 1) for sy in (-1, 1)]
    plate = (0, 0, f.PLATE_BOTTOM + f.PLATE_SIZE[2] / 2)
    return link("birdcage", of_box(f.BIRDCAGE_MASS, f.PLATE_SIZE, plate), visuals("birdcage"), *posts,
                collision(box(f.PLATE_SIZE), plate)) + fixed("birdcage_joint", "base_link", "birdcage")


# ----------------------------------------------------------------------------------------------- torso, head
def torso():
    boxes = [collision(box(size), xyz) for size, xyz in f.TORSO_BOXES]
    radius, length, xyz = f.PEDESTAL_CYLINDER
    return "".join([
        link("torso", inertial(*f.INERTIALS["torso"]), visuals("torso"), *boxes),
        link("pedestal", inertial(*f.INERTIALS["pedestal"]), visuals("pedestal"),
             collision(cylinder(radius, length), xyz)),
        *[frame(f"{side}_torso_itb", visuals("torso_itb")) for side in SIDES],
        *[frame(name, collision(sphere(radius), xyz)) for name, (radius, xyz) in f.HEAD_SPHERES.items()]])


def head():
    point = collision(sphere(f.POINT_SPHERE))
    return "".join([
        link("head", inertial(*f.INERTIALS["head"]), visuals("head"), point),
        link("screen", inertial(*f.INERTIALS["screen"]), visuals("screen"), point),
        frame("sonar_ring", visuals("sonar_ring"), point),
        *map(frame, ("display", "head_camera", "dummyhead1")),
        joint("head_pan", "revolute", "torso", "head", f.HEAD_PAN["xyz"], (0, 0, 0), axis((0, 0, 1)),
              limit(f.HEAD_MAX_EFFORT, f.HEAD_MAX_SPEED, f.HEAD_PAN["lower"], f.HEAD_PAN["upper"])),
        *[fixed(name, *figures) for name, figures in f.FIXED_JOINTS.items()]])


def depth_camera():
    """Frames named as by the RealSense driver."""
    optical = (-pi / 2, 0, -pi / 2)
    return "".join([
        link("camera_link", of_box(f.CAMERA_MASS, f.CAMERA_SIZE, f.CAMERA_CENTRE), visuals("camera_link"),
             collision(box(f.CAMERA_SIZE), f.CAMERA_CENTRE)),
        fixed("camera_joint", "head", "camera_link", f.CAMERA_XYZ, (0, f.CAMERA_PITCH, 0)),
        *map(link, ("camera_color_frame", "camera_color_optical_frame", "camera_depth_frame",
                    "camera_depth_optical_frame")),
        fixed("camera_color_joint", "camera_link", "camera_color_frame", (0, f.CAMERA_COLOR_Y, 0)),
        fixed("camera_color_optical_joint", "camera_color_frame", "camera_color_optical_frame", (0, 0, 0), optical),
        fixed("camera_depth_joint", "camera_link", "camera_depth_frame"),
        fixed("camera_depth_optical_joint", "camera_depth_frame", "camera_depth_optical_frame", (0, 0, 0), optical)])


# ------------------------------------------------------------------------------------------------------ arms
def arm(side):
    x, y, z = f.ARM_MOUNT["xyz"]
    sign = 1 if side == "left" else -1
    joints = [fixed(f"{side}_torso_arm_mount", "torso", f"{side}_arm_mount", (x, sign * y, z),
                    (0, 0, sign * f.ARM_MOUNT["yaw"]))]
    for name, (parent, child, xyz, rpy, lower, upper, velocity, effort) in f.ARM_JOINTS.items():
        joints.append(joint(f"{side}_{name}", "revolute", f"{side}_{parent}", f"{side}_{child}", xyz, rpy,
                            axis((0, 0, 1)), limit(effort, velocity, lower, upper)))
    for name, (parent, child, xyz, rpy) in f.ARM_FIXED_JOINTS.items():
        joints.append(fixed(f"{side}_{name}", f"{side}_{parent}", f"{side}_{child}", xyz, rpy))
    children = [row[1] for row in f.ARM_JOINTS.values()] + [row[1] for row in f.ARM_FIXED_JOINTS.values()]
    links = [arm_link(side, name) for name in ("arm_mount", *children) if name != "gripper_base"]
    return "".join(links + joints) + gripper(side)


def arm_link(side, name):
    shapes = [collision(cylinder(radius, length), xyz) for radius, length, xyz in f.ARM_CYLINDERS.get(name, [])]
    looks = visuals(name) if name in LOOKS else ""
    return link(f"{side}_{name}", inertial(*f.INERTIALS.get(name, f.FRAME_INERTIAL)), looks, *shapes)


def gripper(side):
    letter = side[0]
    body = collision(cylinder(f.GRIPPER_BODY["radius"], f.GRIPPER_BODY["length"]), (0, 0, 0), (-pi / 2, pi, 0))
    parts = [link(f"{side}_gripper_base", of_box(*f.GRIPPER_BOXES["gripper_base"]), visuals("gripper_base"), body)]
    for finger in ("l", "r"):
        parts.append(finger_links(side, letter, finger))
    return "".join(parts)


def half_turned(xyz):
    return (-xyz[0], -xyz[1], xyz[2])


def finger_links(side, letter, finger):
    """The right finger is the left one rotated by 180 degrees about z; its joint mimics the left one's."""
    rotation, place = ((0, 0, 0), tuple) if finger == "l" else ((0, 0, pi), half_turned)
    name = f"{letter}_gripper_{finger}_finger"
    tip_look = "paddle_tip" if side == "left" else "round_tip"
    tip_shape = box(f.PADDLE_TIP) if side == "left" else cylinder(*f.ROUND_TIP)

    def part(key):
        mass, size, centre = f.GRIPPER_BOXES[key]
        return of_box(mass, size, place(centre))
    bounds = (0, f.FINGER_STROKE) if finger == "l" else (-f.FINGER_STROKE, 0)
    mimic = [] if finger == "l" else [f'<mimic joint="{letter}_gripper_l_finger_joint" multiplier="-1"/>']
    return "".join([
        link(name, part("finger"), visuals("finger", (0, 0, 0), rotation),
             *[collision(box(size), place(xyz)) for size, xyz in f.FINGER_BOXES]),
        link(f"{name}_tip", part("finger_tip"), visuals(tip_look, (0, 0, 0), rotation),
             collision(tip_shape, place(f.TIP_XYZ))),
        joint(f"{name}_joint", "prismatic", f"{side}_gripper_base", name, place(f.FINGER_ORIGIN), (0, 0, 0),
              axis((0, 1, 0)), limit(f.FINGER_EFFORT, f.FINGER_SPEED, *bounds), *mimic),
        fixed(f"{name}_tip_joint", name, f"{name}_tip", place(f.FINGER_TIP))])


def urdf():
    return "".join([HEADER, materials(), base(), torso(), head(), depth_camera(), *map(arm, SIDES), "</robot>\n"])

"""Every figure of the robot. Lengths in m, masses in kg, angles in rad; xyz and rpy as in URDF.

Baxter's frames, limits, masses and collision shapes are those of the manufacturer's published description (Rethink
Robotics, baxter_common 1.2.0, BSD-3-Clause); the base's are those published for the Dataspeed Mobility Base. Figures
marked "own" are chosen here, because none are published or the published ones cannot be right.
"""

from math import pi, radians

HALF_PI = pi / 2

# ---------------------------------------------------------------------------------------------- mobile base
FLOOR_TO_AXLE = 0.1016  # base_link stands at the height of the axles
AXLE_TO_BAXTER = 0.5293
FOOTPRINT = (0.8128, 0.7874)
WHEEL_XY = (0.25275, 0.34025)  # distances of the wheels' centres from the middle
WHEEL_RADIUS = 0.1016
WHEEL_WIDTH = 0.0508
ROLLERS = 12
ROLLER_RADIUS = 0.015875
WHEEL_MAX_SPEED = 18.137  # rad/s
WHEEL_MAX_EFFORT = 30.0  # N m, own
WHEEL_MASS = 2.5  # own
CHASSIS_MASS = 70.0  # own
CHASSIS_TOP = 0.1464  # above the axles, own
CHASSIS_CLEARANCE = 0.030  # above the floor, own
LIDAR_MOUNT = 0.2495  # above the axles
LIDAR_SCAN = 0.2872  # above the axles
LIDAR_RADIUS, LIDAR_HEIGHT, LIDAR_MASS = 0.0516, 0.0717, 0.830
IMU_XYZ = (0.0, 0.0, 0.060)  # from base_link, own
# The birdcage: four posts between the chassis and the plate that carries the torso. Own, except its purpose.
POST_RADIUS = 0.016
POST_XY = (0.235, 0.215)
PLATE_SIZE = (0.56, 0.52, 0.022)
PLATE_BOTTOM = 0.4036  # above the axles; the lidar's highest ring, +15 degrees, passes below its edge
BIRDCAGE_MASS = 8.0

# ----------------------------------------------------------------------------------------- joints of Baxter
# name: (parent, child, xyz, rpy)
FIXED_JOINTS = {
    "torso_t0": ("base", "torso", (0, 0, 0), (0, 0, 0)),
    "collision_head_1": ("base", "collision_head_link_1", (0.11, 0, 0.75), (0, 0, 0)),
    "collision_head_2": ("base", "collision_head_link_2", (0.11, 0, 0.75), (0, 0, 0)),
    "left_torso_itb_fixed": ("torso", "left_torso_itb", (-0.08897, 0.15593, 0.389125), (-HALF_PI, 3.1415, 0)),
    "right_torso_itb_fixed": ("torso", "right_torso_itb", (-0.08897, -0.15593, 0.389125), (HALF_PI, 0, 0)),
    "pedestal_fixed": ("torso", "pedestal", (0, 0, 0), (0, 0, 0)),
    "sonar_s0": ("torso", "sonar_ring", (0.0947, 0, 0.817), (0, 0, 0)),
    "dummy": ("head", "dummyhead1", (0, 0, 0), (0, 0, 0)),
    "head_nod": ("head", "screen", (0.1227, 0, 0), (1.75057, 0, HALF_PI)),
    "head_camera": ("head", "head_camera", (0.12839, 0, 0.06368), (1.75057, 0, HALF_PI)),
    "display_joint": ("screen", "display", (0, -0.016, 0), (0, 0, 0)),
}
HEAD_PAN = {"xyz": (0.06, 0, 0.686), "lower": -1.3963, "upper": 1.3963}
# The published limits of the head, 50000 N m and 10000 rad/s, hold nothing back. Own: what its motor may do.
HEAD_MAX_EFFORT, HEAD_MAX_SPEED = 10.0, 2.0

# Where an arm stands on the torso; y and yaw change sign for the right one.
ARM_MOUNT = {"xyz": (0.024645, 0.219645, 0.118588), "yaw": 0.7854}
# The published effort of s1, 50 N m, does not carry the arm, whose own weight takes 50.2 N m in the pose "neutral": our own
# choice, see docs/robot.md.
S1_MAX_EFFORT = 100
# name: (parent, child, xyz, rpy, lower, upper, velocity, effort); parent and child of one side
ARM_JOINTS = {
    "s0": ("arm_mount", "upper_shoulder", (0.055695, 0, 0.011038), (0, 0, 0), -1.70167993878, 1.70167993878, 1.5, 50),
    "s1": ("upper_shoulder", "lower_shoulder", (0.069, 0, 0.27035), (-HALF_PI, 0, 0), -2.147, 1.047, 1.5,
           S1_MAX_EFFORT),
    "e0": ("lower_shoulder", "upper_elbow", (0.102, 0, 0), (HALF_PI, 0, HALF_PI),
           -3.05417993878, 3.05417993878, 1.5, 50),
    "e1": ("upper_elbow", "lower_elbow", (0.069, 0, 0.26242), (-HALF_PI, -HALF_PI, 0), -0.05, 2.618, 1.5, 50),
    "w0": ("lower_elbow", "upper_forearm", (0.10359, 0, 0), (HALF_PI, 0, HALF_PI), -3.059, 3.059, 4, 15),
    "w1": ("upper_forearm", "lower_forearm", (0.01, 0, 0.2707), (-HALF_PI, -HALF_PI, 0), -1.57079632679, 2.094, 4, 15),
    "w2": ("lower_forearm", "wrist", (0.115975, 0, 0), (HALF_PI, 0, HALF_PI), -3.059, 3.059, 4, 15),
}
# name: (parent, child, xyz, rpy); every name gets the side in front
ARM_FIXED_JOINTS = {
    "e0_fixed": ("lower_shoulder", "upper_elbow_visual", (0.107, 0, 0), (HALF_PI, 0, HALF_PI)),
    "w0_fixed": ("lower_elbow", "upper_forearm_visual", (0.088, 0, 0), (HALF_PI, 0, HALF_PI)),
    "w0_to_itb_fixed": ("upper_forearm", "arm_itb", (-0.0565, 0, 0.12), (-HALF_PI, 0, HALF_PI)),
    "hand": ("wrist", "hand", (0, 0, 0.11355), (0, 0, 0)),
    "hand_camera": ("hand", "hand_camera", (0.03825, 0.012, 0.015355), (0, 0, -HALF_PI)),
    "hand_camera_axis": ("hand", "hand_camera_axis", (0.03825, 0.012, 0.015355), (0, 0, 0)),
    "hand_range": ("hand", "hand_range", (0.032, -0.020245, 0.0288), (0, -HALF_PI, -HALF_PI)),
    "hand_accelerometer": ("hand", "hand_accelerometer", (0.00198, 0.000133, -0.0146), (0, 0, 0)),
    "gripper_base": ("hand", "gripper_base", (0, 0, 0.025), (0, 0, 0)),
    "endpoint": ("gripper_base", "gripper", (0, 0, 0.1327), (0, 0, 0)),
}
# The electric gripper: a finger slides along y, the right one mirrors the left one.
FINGER_ORIGIN = (0, -0.0015, 0.02)  # of the left finger in gripper_base; the right one's y has the other sign
FINGER_STROKE, FINGER_SPEED, FINGER_EFFORT = 0.020833, 5.0, 20.0
FINGER_TIP = (0, 0.01725, 0.1127)  # of the left finger

# ------------------------------------------------------------------------------------------------ inertials
# link: (mass, centre of mass, (ixx, ixy, ixz, iyy, iyz, izz)); arm links have the side in front
INERTIALS = {
    "torso": (35.336455, (0, 0, 0), (1.849155, -0.000354, -0.154188, 1.662671, 0.003292, 0.802239)),
    "pedestal": (60.86397744, (0, 0, 0), (5.0635929, 0.00103417, 0.80199628, 6.08689388, 0.00105311, 4.96191932)),
    "head": (0.547767, (0, 0, 0), (0.004641, 0.000159, 0.000242, 0.003295, -0.001324, 0.003415)),
    "screen": (0.440171, (0, 0, 0), (0.004006, 0.00023, 2e-06, 0.0028, 2.9e-05, 0.001509)),
    "upper_shoulder": (5.70044, (0.01783, 0.00086, 0.19127),
                       (0.04709102262, 0.00012787556, 0.00614870039, 0.03766976455, 0.00078086899, 0.03595988478)),
    "lower_shoulder": (3.22698, (0.06845, 0.00269, -0.00529),
                       (0.01175209419, -0.00030096398, 0.00207675762, 0.0278859752, -0.00018821993, 0.02078749298)),
    "upper_elbow": (4.31272, (-0.00276, 0.00132, 0.18086),
                    (0.02661733557, 0.00029270634, 0.00392189887, 0.02844355207, 0.0010838933, 0.01248008322)),
    "lower_elbow": (2.07206, (0.02611, 0.00159, -0.01117),
                    (0.00711582686, 0.00036036173, 0.0007459496, 0.01318227876, -0.00019663418, 0.00926852064)),
    "upper_forearm": (2.24665, (-0.00168, 0.0046, 0.13952),
                      (0.01667742825, 0.00018403705, 0.00018657629, 0.01675457264, -0.00064732352, 0.0037463115)),
    "lower_forearm": (1.60979, (0.06041, 0.00697, 0.006),
                      (0.00387607152, -0.00044384784, -0.00021115038, 0.00700537914, 0.00015348067, 0.0055275524)),
    "wrist": (0.35093, (0.00198, 0.00125, 0.01855),
              (0.00025289155, 5.75311e-06, -1.59345e-06, 0.0002688601, -5.19818e-06, 0.0003074118)),
    "hand": (0.19125, (0.01093, 0.00042, -0.01532),
             (0.00017588, 1.47073e-06, 2.43633e-05, 0.00021166377, 1.72689e-06, 0.00023745397)),
}
# Published for every frame without a body.
FRAME_INERTIAL = (0.0001, (0, 0, 0), (1e-08, 0, 0, 1e-08, 0, 1e-08))
# Masses of the gripper are published; its published inertias (1e-2 kg m^2 for 20 g, 2e-8 for 300 g) belong to no body
# of this size. Own: those of homogeneous boxes, (mass, size, centre).
GRIPPER_BOXES = {
    "gripper_base": (0.3, (0.058, 0.10, 0.058), (0, 0, 0)),
    "finger": (0.02, (0.01, 0.0135, 0.1127), (0, 0.01725, 0.0615)),
    "finger_tip": (0.01, (0.042, 0.0065, 0.037), (0, -0.0045, -0.015)),
}

# ----------------------------------------------------------------------------------------- collision shapes
# link: list of (radius, length, xyz) of cylinders along z, of one side
ARM_CYLINDERS = {
    "upper_shoulder": [(0.06, 0.2722, (0, 0, 0.1361))],
    "lower_shoulder": [(0.06, 0.12, (0, 0, 0))],
    "upper_elbow": [(0.06, 0.107, (0, 0, -0.0535))],
    "upper_elbow_visual": [(0.06, 0.273, (0, 0, 0.1365))],
    "lower_elbow": [(0.06, 0.1, (0, 0, 0))],
    "upper_forearm": [(0.06, 0.088, (0, 0, -0.044))],
    "upper_forearm_visual": [(0.06, 0.272, (0, 0, 0.136))],
    "lower_forearm": [(0.06, 0.1, (0, 0, 0))],
    "wrist": [(0.06, 0.165, (0, 0, 0))],
    "hand": [(0.04, 0.0464, (0, 0, -0.0232))],
}
HEAD_SPHERES = {"collision_head_link_1": (0.22, (-0.07, -0.04, 0)), "collision_head_link_2": (0.22, (-0.07, 0.04, 0))}
POINT_SPHERE = 0.001  # head, screen and sonar ring: the two large spheres above cover them
GRIPPER_BODY = {"radius": 0.029, "length": 0.1}  # a cylinder along y
# Boxes of the left finger, (size, xyz); the right one's are mirrored.
FINGER_BOXES = [((0.01, 0.0135, 0.1127), (0, 0.01725, 0.0615)), ((0.01, 0.05, 0.017), (-0.005, -0.003, 0.0083))]
TIP_XYZ = (0, -0.0045, -0.015)  # of the left finger's tip
PADDLE_TIP = (0.042, 0.0065, 0.037)  # the left gripper's tips are boxes
ROUND_TIP = (0.008, 0.037)  # the right gripper's are cylinders: radius, length
# Own, inside the shells of looks.py: boxes as (size, xyz), a cylinder as (radius, length, xyz).
TORSO_BOXES = [((0.26, 0.50, 0.10), (-0.015, 0, 0.055)), ((0.20, 0.30, 0.40), (-0.045, 0, 0.30)),
               ((0.17, 0.22, 0.14), (-0.005, 0, 0.57))]
PEDESTAL_CYLINDER = (0.17, 0.10, (-0.02, 0, -0.053))

# ------------------------------------------------------------------------------------------ RealSense D435i
# Own: the camera looks at a table of 0.62 m height, 0.55 to 1.3 m in front of base_link, from 1.51 m above the floor.
CAMERA_XYZ = (0.170, 0.0175, 0.190)  # of camera_link (left infrared camera) in head
CAMERA_PITCH = radians(50)
CAMERA_SIZE = (0.02505, 0.090, 0.025)  # depth, width, height
CAMERA_CENTRE = (-0.0088, -0.0175, 0)  # of the housing in camera_link
CAMERA_COLOR_Y = 0.015
CAMERA_MASS = 0.072

"""What people see: own low-polygon solids for every link, in its frame. LOOKS maps a link to (mesh, colour, solid).

Arms: a housing on each bending joint carries the next link's caps and tube, all of them round about the joint's axis,
so nothing shows through in any pose. Sizes that figures.py does not name are chosen here.
"""

from math import cos, pi, sin, sqrt

from generator import figures as f
from generator import solids as s

COLOURS = {  # red, green, blue
    "red": (0.72, 0.09, 0.075), "charcoal": (0.185, 0.19, 0.205), "graphite": (0.31, 0.32, 0.335),
    "silver": (0.66, 0.67, 0.69), "light_grey": (0.80, 0.81, 0.82), "black": (0.045, 0.045, 0.05),
    "screen_blue": (0.07, 0.21, 0.36), "white": (0.94, 0.95, 0.96), "glass": (0.02, 0.03, 0.06),
}
ARM_SIDES = 20  # corners of an arm's cross-section


# ----------------------------------------------------------------------------------------------------- arms
def along_y(solid):
    return s.moved(solid, rpy=(-pi / 2, 0, 0))


def along_x(solid):
    return s.moved(solid, rpy=(0, pi / 2, 0))


def housing(x, z, radius, half_width):
    """Of a bending joint, about the y axis."""
    return s.moved(along_y(s.cylinder(radius, -half_width, half_width, 24, 0.010)), (x, 0, z))


def caps(radius, half_width):
    """The two discs that a bending link shows outside its parent's housing, about the z axis."""
    top = s.revolved([(radius, half_width - 0.006), (radius, half_width + 0.004), (radius - 0.002, half_width + 0.008),
                      (radius - 0.006, half_width + 0.010)], 24, cap_start=False)
    return top + s.moved(top, rpy=(pi, 0, 0))


def bent_shell(z0, r0, waist, x, z, radius, width):
    """From a round joint at z0 through a waist (z, radius) into the housing at (x, z)."""
    sections = [(z0, 0, r0, r0), (z0 + 0.4 * (waist[0] - z0), 0, r0, r0)]
    for t in (0.0, 0.3, 0.55, 0.8, 1.0):
        across = [waist[1] + t * (0.96 * r - waist[1]) for r in (radius, width)]
        sections.append((waist[0] + t * (z - waist[0]), x * (0.12 + 0.88 * t ** 1.4), *across))
    return s.loft(sections, ARM_SIDES)


def collar(length, r0, r1, start):
    """The tube of a bending link, along x."""
    return along_x(s.loft([(start, 0, r0, r0), (0.6 * length, 0, r0, r0), (length - 0.014, 0, r1, r1)], ARM_SIDES))


def seam(z, radius, height=0.014):
    """The thin ring between two links that twist against each other, along z."""
    return s.cylinder(radius, z, z + height, 22)


def arm():
    foot = s.revolved([(0.086, -0.012), (0.088, 0.0), (0.086, 0.020), (0.074, 0.032)], 28)
    return {
        "upper_shoulder": [
            ("foot", "charcoal", foot),
            ("shell", "red", bent_shell(0.030, 0.071, (0.125, 0.066), 0.069, 0.27035, 0.071, 0.060)),
            ("housing", "charcoal", housing(0.069, 0.27035, 0.073, 0.060))],
        "lower_shoulder": [
            ("caps", "graphite", caps(0.056, 0.060)),
            ("tube", "charcoal", collar(0.102, 0.058, 0.060, 0.03)),
            ("ring", "silver", along_x(seam(0.087, 0.0605)))],
        "upper_elbow": [
            ("shell", "red", bent_shell(0.0, 0.062, (0.120, 0.058), 0.069, 0.26242, 0.064, 0.055)),
            ("housing", "charcoal", housing(0.069, 0.26242, 0.066, 0.055))],
        "lower_elbow": [
            ("caps", "graphite", caps(0.050, 0.055)),
            ("tube", "charcoal", collar(0.10359, 0.052, 0.055, 0.03)),
            ("ring", "silver", along_x(seam(0.0885, 0.0555)))],
        "upper_forearm": [
            ("shell", "red", s.loft([(0.0, 0, 0.056, 0.056), (0.06, -0.002, 0.058, 0.056), (0.15, 0, 0.053, 0.052),
                                     (0.215, 0.006, 0.055, 0.048), (0.2707, 0.01, 0.053, 0.045)], ARM_SIDES)),
            ("housing", "charcoal", housing(0.01, 0.2707, 0.057, 0.047))],
        "arm_itb": [("buttons", "light_grey", s.cylinder(0.018, -0.014, 0.004, 14, 0.003))],
        "lower_forearm": [
            ("caps", "graphite", caps(0.043, 0.047)),
            ("tube", "charcoal", collar(0.115975, 0.044, 0.047, 0.03)),
            ("ring", "silver", along_x(seam(0.1005, 0.0475)))],
        "wrist": [
            ("shell", "graphite", s.revolved([(0.047, 0.0), (0.049, 0.02), (0.050, 0.045), (0.047, 0.062)], 24))],
        "hand": [
            ("cuff", "light_grey", s.revolved([(0.046, -0.052), (0.052, -0.046), (0.053, -0.02), (0.049, -0.002),
                                               (0.044, 0.0)], 24)),
            ("eye", "charcoal", s.moved(s.cylinder(0.011, -0.02, 0.012, 14, 0.003), (0.036, 0.012, 0.0))
             + s.moved(s.box((0.016, 0.020, 0.03), 0.003), (0.034, -0.016, 0.0)))],
        "hand_camera": [("lens", "glass", s.cylinder(0.007, -0.004, -0.001, 12))],
        "gripper_base": [
            ("body", "charcoal", s.moved(s.prism(s.rounded_rectangle(0.058, 0.100, 0.018, 4), -0.025, 0.018, 0.004))),
            ("rail", "silver", s.moved(s.box((0.034, 0.084, 0.008), 0.002), (0, 0, 0.021)))],
    }


def finger():
    blade, foot = f.FINGER_BOXES
    return [("finger", "graphite", s.moved(s.box(blade[0], 0.002), blade[1]) + s.moved(s.box(foot[0], 0.002), foot[1]))]


def tips():
    radius, length = f.ROUND_TIP
    return {"paddle_tip": [("pad", "light_grey", s.moved(s.box(f.PADDLE_TIP, 0.0015), f.TIP_XYZ))],
            "round_tip": [("pad", "light_grey",
                           s.moved(s.cylinder(radius, -length / 2, length / 2, 16, 0.002), f.TIP_XYZ))]}


# ---------------------------------------------------------------------------------------- torso, head, screen
def torso():
    tower = s.loft([(0.0, -0.03, 0.120, 0.145), (0.012, -0.03, 0.128, 0.155), (0.10, -0.035, 0.130, 0.160),
                    (0.25, -0.045, 0.118, 0.152), (0.40, -0.050, 0.106, 0.146), (0.50, -0.036, 0.098, 0.130),
                    (0.58, -0.004, 0.088, 0.104), (0.635, 0.036, 0.072, 0.076), (0.662, 0.055, 0.056, 0.058)], 32, 2.6)
    chest = s.loft([(0.135, 0.034, 0.064, 0.118), (0.150, 0.036, 0.070, 0.124), (0.26, 0.028, 0.064, 0.116),
                    (0.40, 0.018, 0.056, 0.106), (0.49, 0.026, 0.052, 0.096), (0.560, 0.048, 0.050, 0.080),
                    (0.575, 0.052, 0.044, 0.072)], 32, 2.6)
    display = s.moved(s.box((0.010, 0.085, 0.028), 0.004), (0.0975, 0, 0.215), (0, -0.06, 0))
    return [("tower", "charcoal", tower), ("chest", "red", chest), ("shelf", "graphite", shelf(0.098, 0.030, 0.112)),
            ("trim", "red", shelf(0.103, 0.052, 0.092)), ("badge", "light_grey", display)]


def shelf(radius, z0, z1):
    """The plate under both arms."""
    outline = []
    for x, y, r in ((0.064, 0.259, radius), (0.064, -0.259, radius), (-0.12, 0.09, radius - 0.04),
                    (-0.12, -0.09, radius - 0.04)):
        outline += [(x + r * cos(2 * pi * i / 20), y + r * sin(2 * pi * i / 20)) for i in range(20)]
    return s.prism(s.hull(outline), z0, z1, 0.010)


def torso_button():
    ring = s.revolved([(0.036, -0.012), (0.036, 0.006), (0.030, 0.010)], 24)
    return [("ring", "silver", ring), ("knob", "light_grey", s.cylinder(0.017, 0.004, 0.018, 14, 0.004))]


def pedestal():
    trunk = s.loft([(-0.108, -0.02, 0.175, 0.190), (-0.096, -0.02, 0.175, 0.190), (-0.060, -0.025, 0.140, 0.165),
                    (-0.010, -0.03, 0.122, 0.148), (0.004, -0.03, 0.122, 0.148)], 32, 2.6)
    return [("trunk", "graphite", trunk)]


def head():
    neck = s.revolved([(0.054, -0.030), (0.052, 0.0), (0.060, 0.018), (0.070, 0.04), (0.072, 0.085), (0.062, 0.108),
                       (0.040, 0.120)], 28)
    arm_to_screen = s.moved(s.box((0.075, 0.060, 0.050), 0.010), (0.080, 0, 0.005), (0, 0.1, 0))
    x, _, z = f.CAMERA_XYZ
    mast = s.moved(s.box((0.016, 0.034, 0.090), 0.003), (0.022, 0, 0.150))
    boom = s.moved(s.box((x - 0.022, 0.026, 0.012), 0.003), ((x + 0.012) / 2, 0, z))
    return [("neck", "charcoal", neck + arm_to_screen), ("bracket", "graphite", mast + boom)]


def sonar_ring():
    rim = s.revolved([(0.088, -0.014), (0.094, -0.010), (0.094, 0.010), (0.088, 0.014)], 36)
    eyes = []
    for i in range(12):
        angle = 2 * pi * (i + 0.5) / 12
        disc = s.moved(s.cylinder(0.0075, 0.090, 0.0955, 8), rpy=(0, pi / 2, angle))
        eyes += disc
    return [("rim", "graphite", rim), ("eyes", "light_grey", eyes)]


def plate(outline, z0, z1):
    return s.skin([[(x, y, z) for x, y in outline] for z in (z0, z1)])


def screen():
    """x to the robot's left, y up, z to the front; the robot looks friendly."""
    body = s.prism(s.rounded_rectangle(0.300, 0.196, 0.022, 5), -0.022, 0.008, 0.006)
    panel = plate(s.rounded_rectangle(0.262, 0.158, 0.010, 3), 0.004, 0.0086)
    eyes, pupils, shine, brows = [], [], [], []
    for side in (-1, 1):
        x = side * 0.060
        eyes += s.moved(plate(s.ellipse(0.030, 0.036, 28), 0.008, 0.0092), (x, -0.004, 0))
        pupils += s.moved(plate(s.ellipse(0.015, 0.019, 22), 0.008, 0.0098), (x, -0.012, 0))
        shine += s.moved(plate(s.ellipse(0.005, 0.006, 12), 0.008, 0.0104), (x + 0.006, -0.004, 0))
        brows += s.moved(plate(s.rounded_rectangle(0.058, 0.009, 0.004, 3), 0.008, 0.0092), (x, 0.049, 0),
                         (0, 0, side * 0.02))
    return [("body", "charcoal", body), ("panel", "screen_blue", panel), ("eyes", "white", eyes + brows),
            ("pupils", "glass", pupils), ("shine", "white", shine)]


# ------------------------------------------------------------------------------------------------ mobile base
def chassis():
    length, width = f.FOOTPRINT
    bottom, top = f.CHASSIS_CLEARANCE - f.FLOOR_TO_AXLE, f.CHASSIS_TOP
    hull = s.moved(s.prism(s.rounded_rectangle(length - 0.05, 0.560, 0.05, 5), bottom, top - 0.030, 0.012))
    deck = s.prism(s.rounded_rectangle(length - 0.012, width - 0.012, 0.10, 6), top - 0.038, top, 0.008)
    bumper = s.prism(s.rounded_rectangle(length, width, 0.105, 6), top - 0.031, top - 0.009, 0.004)
    skirts = []
    for side in (-1, 1):
        skirts += s.moved(s.box((0.05, 0.50, 0.10), 0.014), (side * (length / 2 - 0.028), 0, -0.01))
    pillar = s.revolved([(0.075, top - 0.004), (0.070, top + 0.008), (0.052, top + 0.020),
                         (0.050, f.LIDAR_MOUNT - 0.006), (0.056, f.LIDAR_MOUNT)], 24)
    lamps = []
    for side in (-1, 1):
        lamps += s.moved(s.box((0.006, 0.11, 0.016), 0.002), (length / 2 - 0.003, side * 0.16, -0.005))
    return [("hull", "charcoal", hull), ("deck", "graphite", deck), ("bumper", "red", bumper),
            ("skirts", "black", skirts), ("pillar", "graphite", pillar), ("lamps", "white", lamps)]


def birdcage():
    posts = []
    foot = s.revolved([(0.030, 0), (0.030, 0.008), (0.018, 0.014)], 16)
    for sx in (-1, 1):
        for sy in (-1, 1):
            x, y = sx * f.POST_XY[0], sy * f.POST_XY[1]
            posts += s.tube((x, y, f.CHASSIS_TOP - 0.002), (x, y, f.PLATE_BOTTOM + 0.002), f.POST_RADIUS, 14)
            posts += s.moved(foot, (x, y, f.CHASSIS_TOP - 0.001))
    length, width, height = f.PLATE_SIZE
    plate_ = s.prism(s.rounded_rectangle(length, width, 0.06, 6), f.PLATE_BOTTOM, f.PLATE_BOTTOM + height, 0.006)
    return [("posts", "silver", posts), ("plate", "charcoal", plate_)]


def roller():
    """A barrel along z whose turned copies make the wheel a circle."""
    to_middle = f.WHEEL_RADIUS - f.ROLLER_RADIUS
    half = f.WHEEL_WIDTH / 2 * sqrt(2) * 0.93
    profile = []
    for i in range(5):
        t = half * (i / 2 - 1)
        profile.append((0.98 * (f.WHEEL_RADIUS - sqrt(to_middle ** 2 + t * t / 2)), t))
    return s.revolved(profile, 8)


def wheel(slant):
    """About y. `slant` is +1 where the rollers on top point to the front and left, -1: to the front and right."""
    to_middle = f.WHEEL_RADIUS - f.ROLLER_RADIUS
    rollers = []
    for i in range(f.ROLLERS):
        # On top of the wheel: along x, turned about z by 45 degrees; then around the wheel.
        one = s.moved(s.moved(roller(), rpy=(0, pi / 2, 0)), (0, 0, to_middle), (0, 0, slant * pi / 4))
        rollers += s.moved(one, rpy=(0, 2 * pi * i / f.ROLLERS, 0))
    half = f.WHEEL_WIDTH / 2
    rims = []
    for y in (-half, half - 0.005):
        rims += along_y(s.moved(s.cylinder(0.068, 0, 0.005, 24), (0, 0, y)))
    hub = along_y(s.revolved([(0.020, -half - 0.008), (0.030, -half - 0.004), (0.058, -half + 0.004),
                              (0.062, -half + 0.01), (0.062, half - 0.01), (0.058, half - 0.004), (0.030, half + 0.004),
                              (0.020, half + 0.008)], 20))
    return [("rollers", "black", rollers), ("rims", "silver", rims), ("hub", "red", hub)]


def lidar():
    """In velodyne_base, which lies under the housing."""
    r, h = f.LIDAR_RADIUS, f.LIDAR_HEIGHT
    base = s.revolved([(r - 0.002, 0.0), (r, 0.002), (r, 0.017), (r - 0.004, 0.0195)], 32)
    window = s.cylinder(r - 0.0035, 0.019, h - 0.014, 32)
    top = s.revolved([(r - 0.004, h - 0.0145), (r, h - 0.012), (r, h - 0.003), (r - 0.003, h)], 32)
    return [("base", "silver", base + top), ("window", "glass", window)]


def depth_camera():
    """In camera_link, whose x axis looks ahead."""
    depth, width, height = f.CAMERA_SIZE
    body = s.prism(s.rounded_rectangle(width, height, 0.0124, 6), -depth / 2, depth / 2 - 0.001, 0.002)
    body = s.moved(body, f.CAMERA_CENTRE, (pi / 2, 0, pi / 2))
    front_x = f.CAMERA_CENTRE[0] + depth / 2
    front = s.moved(plate(s.rounded_rectangle(width - 0.005, height - 0.006, 0.0092, 5), -0.002, 0.0),
                    (front_x, f.CAMERA_CENTRE[1], 0), (pi / 2, 0, pi / 2))
    eyes = []
    for y, radius in ((0.0, 0.0045), (-0.05, 0.0045), (f.CAMERA_COLOR_Y, 0.0038), (-0.029, 0.003)):
        eyes += s.moved(along_x(s.cylinder(radius, -0.001, 0.0006, 12)), (front_x, y, 0))
    return [("body", "silver", body), ("front", "black", front), ("eyes", "screen_blue", eyes)]


LOOKS = {
    "torso": torso(), "torso_itb": torso_button(), "pedestal": pedestal(), "head": head(), "sonar_ring": sonar_ring(),
    "screen": screen(), "chassis": chassis(), "birdcage": birdcage(), "wheel_left_handed": wheel(1),
    "wheel_right_handed": wheel(-1), "velodyne_base": lidar(), "camera_link": depth_camera(), **arm(),
    "finger": finger(), **tips(),
}


def meshes():
    """Every mesh file's name and solid."""
    return {f"{link}_{part}.stl": solid for link, parts in LOOKS.items() for part, _, solid in parts}

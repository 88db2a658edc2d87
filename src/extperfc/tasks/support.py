"""The surface that an object stands on, as a depth camera sees it."""

import numpy
import rospy
import sensor_msgs.msg

from extperfc.arm import hands, robot_state
from extperfc.arm.connection import WAIT_S
from extperfc.record.frames import depth_of
from extperfc.tasks.arm_leaves import scene
from extperfc.tasks.blackboard import read
from extperfc.tasks.find import point_of
from extperfc.tasks.leaf import Leaf
from extperfc.tasks.search import BASE_FRAME, Lidar
from extperfc.tasks.tops import middle_of, strips, table_at

IMAGES = "camera/aligned_depth_to_color"
PIXEL_STEP = 3
NEAR_M = 0.25        # from the object, on the floor plan: where the surface's height is looked for
BELOW_M = 0.2        # from the object's middle down to the lowest surface
BIN_M = 0.01         # of heights
THICK_M = 0.03       # of the box; and what counts as the surface: within half of it
LOWER_M = 0.004      # than the surface: depth is that uncertain, and an object must not seem to stick in it
REACH_M = 0.7        # from the object, of the box's borders at most
MIN_POINTS = 60
TABLE_M = 0.4        # from the object to the next square of its table that the lidar has seen
BODY_M = 0.55        # from the base's middle: no table is there
SETTLE_S = 2.0       # of ROS time: the arm node's next images have taken away the points that are the box's now


def surface_below(points, place):
    """(size, middle) of a flat box below a point: the most frequent height of the points (N x 3) below it, as far as points at
    this height are seen around. Axes as those of the points; z is up. Raises ValueError without a surface."""
    offset = points[:, :2] - place[:2]
    around = numpy.abs(offset).max(axis=1) < REACH_M
    below = (points[:, 2] < place[2]) & (points[:, 2] > place[2] - BELOW_M)
    heights = points[around & below & (numpy.hypot(*offset.T) < NEAR_M), 2]
    if len(heights) < MIN_POINTS:
        raise ValueError(f"no surface is seen below ({place[0]:.2f}, {place[1]:.2f}, {place[2]:.2f}), but {len(heights)} points")
    counts, edges = numpy.histogram(heights, bins=max(1, round(BELOW_M / BIN_M)), range=(place[2] - BELOW_M, place[2]))
    best = int(numpy.argmax(counts))
    height = float(numpy.median(heights[numpy.abs(heights - edges[best:best + 2].mean()) <= BIN_M]))
    surface = points[around & (numpy.abs(points[:, 2] - height) < THICK_M / 2), :2]
    low, high = numpy.percentile(surface, 1, axis=0), numpy.percentile(surface, 99, axis=0)
    size = (*(float(v) for v in high - low), THICK_M)
    return size, (*(float(v) for v in (low + high) / 2), height - LOWER_M - THICK_M / 2)


def points_of(depth_mm, info):
    """N x 3 [m] in the camera's optical frame: of every PIXEL_STEP-th pixel with a depth. info: sensor_msgs/CameraInfo."""
    depth = depth_mm[::PIXEL_STEP, ::PIXEL_STEP] / 1000.0
    rows, columns = numpy.nonzero(depth > 0)
    z = depth[rows, columns]
    x = (columns * PIXEL_STEP - info.K[2]) / info.K[0] * z
    y = (rows * PIXEL_STEP - info.K[5]) / info.K[4] * z
    return numpy.column_stack([x, y, z])


def beyond(squares, base_T_frame, size, middle):
    """The squares whose middles lie neither on a box of surface_below() nor at the robot itself."""
    def is_beyond(square):
        x, y = (base_T_frame @ (*middle_of(square), 0.0, 1.0))[:2]
        on_box = abs(x - middle[0]) < size[0] / 2 and abs(y - middle[1]) < size[1] / 2
        return not on_box and numpy.hypot(x, y) > BODY_M
    return {square for square in squares if is_beyond(square)}


class SeeSupport(Leaf):
    """Adds what an object stands on, or shall stand on, to the arm node's scene, as a flat box that the depth camera has seen;
    so grippers may come nearer to it than to a cloud of points. The base must stand, with the place before the camera. What the
    lidar has seen of the same table outside of the image (a leaf Search or SeeAround of this frame listens to it) is added at the
    same height: an arm swings that far.

    point: the object's middle, (x, y, z) in `frame`, a Found in its own frame, or a Key.
    """

    def __init__(self, point, frame=None, object_name="support", name=None):
        super().__init__(name or "see what it stands on")
        self.point, self.frame, self.object_name = point, frame, object_name

    def begin(self):
        self._until = None

    def step(self):
        if self._until is None:
            self._add()
            self._until = rospy.Time.now() + rospy.Duration(SETTLE_S)
        return True if rospy.Time.now() >= self._until else None

    def _add(self):
        point = read(self.point)
        frame = point.pose.header.frame_id if hasattr(point, "pose") else self.frame or hands.of().frame
        base_T_frame = robot_state.frames().matrix(BASE_FRAME, frame, WAIT_S)
        place = (base_T_frame @ (*point_of(point), 1.0))[:3]
        size, middle = surface_below(self._seen(), place)
        arms = scene()
        for old in arms.objects:
            if old.startswith(f"{self.object_name}_"):
                arms.remove(old)
        arms.add_box(self.object_name, size, middle, BASE_FRAME)
        rest = self._rest(frame, base_T_frame, point_of(point), size, middle)
        for number, (rest_size, rest_middle) in enumerate(rest):
            arms.add_box(f"{self.object_name}_{number}", rest_size, rest_middle, frame)
        self.feedback_message = f"{size[0]:.2f} x {size[1]:.2f} m, {middle[2] + size[2] / 2:.3f} m high, and {len(rest)} strips beside it"

    @staticmethod
    def _rest(frame, base_T_frame, place, size, middle):
        """[(size, middle)] of boxes in `frame`: the table outside of what the camera sees."""
        lidar = Lidar.known(frame)
        table = table_at(lidar.heights(), place[:2], TABLE_M) if lidar else set()
        height = float((numpy.linalg.inv(base_T_frame) @ (*middle, 1.0))[2])
        return [((*flat, size[2]), (*at, height)) for flat, at in strips(beyond(table, base_T_frame, size, middle))]

    @staticmethod
    def _seen():
        """Points of one depth image in BASE_FRAME."""
        try:
            info = rospy.wait_for_message(f"{IMAGES}/camera_info", sensor_msgs.msg.CameraInfo, WAIT_S)
            image = rospy.wait_for_message(f"{IMAGES}/image_raw", sensor_msgs.msg.Image, WAIT_S)
        except rospy.ROSException:
            raise ValueError(f"no depth image on {rospy.resolve_name(IMAGES)}/image_raw within {WAIT_S:g} s") from None
        base_T_camera = robot_state.frames().matrix(BASE_FRAME, image.header.frame_id, WAIT_S)
        points = points_of(depth_of(image), info)
        return points @ base_T_camera[:3, :3].T + base_T_camera[:3, 3]

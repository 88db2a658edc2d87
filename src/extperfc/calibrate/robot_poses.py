"""parent_T_carrier at the time of an image: by tf, or by joint states and a robot's description."""

import bisect
import pathlib

import numpy

from extperfc import robot_description as rd
from extperfc.calibrate import views

MAX_GAP_S = 0.25  # between joint states on both sides of an image


class JointPoses:
    """Forward kinematics of joint states, interpolated. Messages may name some of the joints only."""

    def __init__(self, urdf, parent, carrier, keep=2000):
        try:
            self._robot = rd.RobotDescription(urdf)
        except ValueError as error:
            raise views.ViewsError(str(error)) from None
        for link in (parent, carrier):
            if link not in self._robot.links:
                raise views.ViewsError(f"the robot's description has no link {link}")
        self._parent, self._carrier, self._keep = parent, carrier, keep
        self._needed = set(self._robot.joints_above(parent)) ^ set(self._robot.joints_above(carrier))
        self._tracks = {name: ([], []) for name in self._needed}  # stamps [s], values

    def add(self, message):
        """A sensor_msgs/JointState; one that is older than the one before is left out."""
        stamp = message.header.stamp.to_sec()
        for name, position in zip(message.name, message.position):
            stamps, values = self._tracks.get(name, (None, None))
            if stamps is None or (stamps and stamp <= stamps[-1]):
                continue
            stamps.append(stamp)
            values.append(position)
            if len(stamps) > 2 * self._keep:
                del stamps[:self._keep], values[:self._keep]

    def at(self, stamp_s):
        """parent_T_carrier; None where joint states are missing around this time."""
        positions = {}
        for name, (stamps, values) in self._tracks.items():
            after = bisect.bisect_left(stamps, stamp_s)
            if after == len(stamps) or (after == 0 and stamps[0] != stamp_s):
                return None
            before = max(after - 1, 0)
            if stamps[after] - stamps[before] > MAX_GAP_S:
                return None
            positions[name] = float(numpy.interp(stamp_s, stamps[before:after + 1], values[before:after + 1]))
        poses = self._robot.link_poses(positions)
        return rd.inverse(poses[self._parent]) @ poses[self._carrier]


class TfPoses:
    """Lookup in a tf2 BufferCore."""

    def __init__(self, buffer, parent, carrier):
        self._buffer, self._parent, self._carrier = buffer, parent, carrier

    def lookup(self, target, source, stamp):
        """target_T_source at a rospy time; None where tf does not know it."""
        import tf2_ros
        try:
            found = self._buffer.lookup_transform_core(target, source, stamp).transform
        except tf2_ros.TransformException:
            return None
        t, q = found.translation, found.rotation
        return rd.transform((t.x, t.y, t.z), rd.rotation_of_quaternion(q.x, q.y, q.z, q.w))

    def at(self, stamp_s):
        """parent_T_carrier; None where tf does not know it."""
        import rospy
        return self.lookup(self._parent, self._carrier, rospy.Time.from_sec(stamp_s))


def read_urdf(file):
    try:
        return pathlib.Path(file).read_text()
    except OSError as error:
        raise views.ViewsError(f"{file}: {error.strerror}") from None

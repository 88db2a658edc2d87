"""The simulated robot drives through the office and maps it; the map and the poses are compared with the truth."""

import math
import os
import pathlib
import re
import tempfile
import time
import unittest

import cv2
import numpy as np

from generated_services import find_services
from office_drive import ARRIVED_M, STEPS, Deadline, Plan, command
from ros_session import RosSession

REPO = pathlib.Path(__file__).resolve().parents[2]
WS = pathlib.Path(os.environ.get("EXTPERFC_WS", REPO / ".ws"))
OUT = WS / "mapping_office"      # images and figures of the last run
SECONDS = 170                    # for everything after the start
# Both loops of corridors, rooms in the north, south and east, and back. Rooms whose doors the chassis cannot pass are
# seen from the corridor.
GOALS = [(0, 3.4), (-9, 3.4), (-9, 6.5), (-9, 3.4), (-11, 3.4), (-11, -3.4), (-8.5, -3.4), (-8.5, -6.2), (-8.5, -3.4),
         (-3.2, -3.4), (-3.2, -0.8), (-3.2, -3.4), (0, -3.4), (0, 0), (0, -3.4), (8, -3.4), (11, -3.4), (11, 0),
         (13, 0), (11, 0), (11, 3.4), (3, 3.4), (3, 6.0), (-2.5, 7.2), (-3, 3.4), (0, 3.4), (0, 0)]
MIN_GOALS = 20                   # that the robot must have reached; doors are 7 cm wider on each side than its chassis
BLOCKED_STEPS = 20               # of a tenth of a second, that the robot waits
TOLERANCE_CELLS = 1              # a cell counts as right when a right one is among its eight neighbours
# Recall cannot be full: the truth shows all that stands between 0.1 and 1.5 m above each cell, also the tops of tables,
# under which the scan looks through to the wall.
MIN_PRECISION, MIN_RECALL, MIN_F_SCORE = 0.97, 0.65, 0.80
MAX_MEAN_ERROR_M, MAX_ERROR_M, MAX_ERROR_DEG = 0.08, 0.25, 2.0


def world_with(folder, walks):
    """The office with people who walk there and back, instead of its own."""
    text = (REPO / "config" / "worlds" / "office.yaml").read_text()
    text = re.sub(r"\npeople:\n(?:  .*\n?)+", "\n", text)
    people = [f"  - {{name: person_{i}, path: [{list(a)}, {list(b)}], speed: {0.5 + 0.035 * i:.2f}}}\n"
              for i, (a, b) in enumerate(walks)]
    file = folder / "office_of_the_test.yaml"
    file.write_text(text + ("\npeople:\n" + "".join(people) if people else ""))
    return file


def compose(a, b):
    c, s = math.cos(a[2]), math.sin(a[2])
    return a[0] + c * b[0] - s * b[1], a[1] + s * b[0] + c * b[1], math.remainder(a[2] + b[2], 2 * math.pi)


def inverse(a):
    c, s = math.cos(a[2]), math.sin(a[2])
    return -c * a[0] - s * a[1], s * a[0] - c * a[1], -a[2]


def pose_of(message):
    return (message.position.x, message.position.y,
            2 * math.atan2(message.orientation.z, message.orientation.w))


class Newest(dict):
    """Poses by stamp [ns] that a callback adds and others read."""

    latest = 0

    def add(self, stamp, pose):
        self[stamp] = pose
        self.latest = max(self.latest, stamp)


class Robot:
    """The simulated robot and the mapper, through ROS."""

    def __init__(self, deadline_s):
        import rospy
        from geometry_msgs.msg import PoseWithCovarianceStamped, Twist
        from nav_msgs.msg import OccupancyGrid, Odometry

        find_services()
        from extperfc.srv import StepSimulation
        self.truth, self.estimates, self.true_map, self.goal, self.steps = Newest(), Newest(), None, None, 0
        self.last_pose, self.still = None, 0
        self.deadline = Deadline(deadline_s, self.where)
        rospy.Subscriber("sim/truth/odom", Odometry, self._on_truth, queue_size=100)
        rospy.Subscriber("pose", PoseWithCovarianceStamped, self._on_pose, queue_size=100)
        rospy.Subscriber("sim/truth/map", OccupancyGrid, lambda message: setattr(self, "true_map", message))
        self.velocity = rospy.Publisher("cmd_vel", Twist, queue_size=1)
        self.twist = Twist
        rospy.wait_for_service("sim/step", 60)
        rospy.wait_for_service("mapper/save_map", 60)
        self.step_service = rospy.ServiceProxy("sim/step", StepSimulation, persistent=True)
        self.stamp = 0
        self.deadline.wait("the true map", lambda: self.true_map is not None, 30)
        self.deadline.wait("a listener of cmd_vel", lambda: self.velocity.get_num_connections() > 0, 30)

    def _on_truth(self, message):
        self.truth.add(message.header.stamp.to_nsec(), pose_of(message.pose.pose))

    def _on_pose(self, message):
        self.estimates.add(message.header.stamp.to_nsec(), pose_of(message.pose.pose))

    def where(self):
        newest = self.estimates.latest * 1e-9
        return (f"simulated {self.stamp * 1e-9:.1f} s in {self.steps} steps, goal {self.goal}, robot at "
                f"{self.pose() if self.truth else 'an unknown pose'}, {len(self.estimates)} poses of the mapper up to {newest:.1f} s")

    def pose(self):
        return self.truth[self.truth.latest]

    def path(self):
        """True poses in the order of time."""
        return [self.truth[stamp] for stamp in sorted(set(self.truth))]

    def step(self, velocity=(0, 0, 0)):
        """A tenth of a second. The mapper may be one sweep behind, since tf may come with the next step only."""
        message = self.twist()
        message.linear.x, message.linear.y, message.angular.z = velocity
        self.velocity.publish(message)
        before = self.stamp
        answer = self.step_service(STEPS)
        if not answer.success:
            raise RuntimeError("sim/step: " + answer.message)
        self.stamp, self.steps = answer.stamp.to_nsec(), self.steps + 1
        self.deadline.check()
        self.deadline.wait("the truth", lambda: self.truth.latest >= self.stamp - 25_000_000, 10)
        if self.steps > 5:
            self.deadline.wait("the mapper's pose", lambda: self.estimates.latest >= before - 110_000_000, 10)

    def drive(self, plan, goal, among_people):
        """True when the goal was reached; tries another path where an obstacle stops the robot, and the same one again where
        it may be a person."""
        self.goal = goal
        for _ in range(10 if among_people else 3):
            path = plan.path(self.pose()[:2], goal)
            if path is None:
                print(f"no path to {goal} for the chassis", flush=True)
                return False
            held_at = self.follow(plan, path, goal, among_people)
            if held_at is None:
                return True
            print(f"stopped on the path to {goal} at {self.pose()}", flush=True)
            if not among_people:
                plan.block(*held_at)
        return False

    def stood(self):
        return self.last_pose is not None and math.dist(self.pose()[:2], self.last_pose[:2]) < 0.003

    def is_blocked(self, velocity):
        """Whether the robot stood still in the last three steps though it was to drive."""
        self.still = self.still + 1 if self.stood() and math.hypot(*velocity[:2]) > 0.1 else 0
        self.last_pose = self.pose()
        blocked = self.still >= 3
        if blocked:
            self.still = 0
        return blocked

    def follow(self, plan, path, goal, among_people):
        """None at the goal, or the point of the path that could not be reached. Among people the robot stops when something
        blocks it, and waits until it has gone; otherwise its wheels would spin."""
        at, farthest, progress = 0, -1, self.steps
        while math.dist(self.pose()[:2], goal) > ARRIVED_M:
            held = self.steps - progress
            velocity, at = command(plan, path, at, self.pose(), back=held >= 40)
            self.step(velocity)
            if among_people and self.is_blocked(velocity):
                for _ in range(BLOCKED_STEPS):
                    self.step()
            if at > farthest:
                farthest, progress = at, self.steps
            if self.steps - progress > 55:
                return path[min(len(path) - 1, farthest + 6)]
        return None


class Comparison:
    """The map beside the truth, both in the truth's frame."""

    def __init__(self, true_map, found, true_T_map):
        self.truth = np.array(true_map.data, np.int8).reshape(true_map.info.height, true_map.info.width)
        cells = np.array(found.data, np.int8).reshape(found.info.height, found.info.width)
        self.found = self._moved(cells, found.info, true_map.info, true_T_map)

    def _moved(self, cells, info, true_info, true_T_map):
        """The found map in the true map's cells: each takes what lies at its middle."""
        side = true_info.resolution
        rows, columns = np.mgrid[0:self.truth.shape[0], 0:self.truth.shape[1]]
        x = true_info.origin.position.x + (columns + 0.5) * side
        y = true_info.origin.position.y + (rows + 0.5) * side
        a = inverse(true_T_map)
        c, s = math.cos(a[2]), math.sin(a[2])
        column = np.floor((a[0] + c * x - s * y - info.origin.position.x) / info.resolution).astype(int)
        row = np.floor((a[1] + s * x + c * y - info.origin.position.y) / info.resolution).astype(int)
        inside = (row >= 0) & (column >= 0) & (row < cells.shape[0]) & (column < cells.shape[1])
        moved = np.full(self.truth.shape, -1, np.int8)
        moved[inside] = cells[row[inside], column[inside]]
        return moved

    def scores(self):
        """Precision, recall and F-score of occupied cells. What counts for recall: the true obstacles' cells that border
        on true free space which the robot has seen."""
        near = np.ones((2 * TOLERANCE_CELLS + 1,) * 2, np.uint8)
        true_occupied, occupied = (self.truth >= 65).astype(np.uint8), (self.found >= 65).astype(np.uint8)
        seen_free = ((self.found >= 0) & (self.found < 25) & (self.truth >= 0) & (self.truth < 65)).astype(np.uint8)
        surface = (true_occupied > 0) & (cv2.dilate(seen_free, np.ones((3, 3), np.uint8)) > 0)
        precision = (cv2.dilate(true_occupied, near)[occupied > 0] > 0).mean()
        recall = (cv2.dilate(occupied, near)[surface] > 0).mean()
        return float(precision), float(recall), float(2 * precision * recall / (precision + recall))

    def image(self, file):
        """Above the truth, in the middle the map, below both: black right, red wrong, blue missing."""
        def grey(cells):
            image = np.full(cells.shape, 128, np.uint8)
            image[(cells >= 0) & (cells < 65)] = 255
            image[cells >= 65] = 0
            return cv2.cvtColor(image, cv2.COLOR_GRAY2BGR)
        both = grey(np.where(self.found < 0, -1, 0))
        right = cv2.dilate((self.truth >= 65).astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
        both[self.truth >= 65] = (255, 160, 80)
        both[(self.found >= 65) & right] = (0, 0, 0)
        both[(self.found >= 65) & ~right] = (0, 0, 255)
        gap = np.zeros((6, self.truth.shape[1], 3), np.uint8)
        stacked = [np.flipud(one) for one in (grey(self.truth), grey(self.found), both)]
        cv2.imwrite(str(file), np.vstack([stacked[0], gap, stacked[1], gap, stacked[2]]))


class OfficeCase(unittest.TestCase):
    """A drive through the office with its checks."""

    max_error_m, max_error_deg = MAX_ERROR_M, MAX_ERROR_DEG

    def map_the_office(self, out, walks, rounds, seconds, min_goals):
        out.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory() as folder, RosSession(out / "launch.log") as session:
            session.launch("extperfc", "sim_mapping.launch", world=world_with(pathlib.Path(folder), walks),
                           paused="true", rviz="false")
            robot = self.connect(session, seconds)
            begin = time.monotonic()
            plan = Plan(robot.true_map)
            for _ in range(8):
                robot.step()
            goals = GOALS * rounds
            reached = sum(robot.drive(plan, goal, among_people=bool(walks)) for goal in goals)
            for _ in range(5):
                robot.step()
            path_m = sum(math.dist(a[:2], b[:2]) for a, b in zip(robot.path(), robot.path()[1:]))
            print(f"{reached} of {len(goals)} goals, {path_m:.0f} m, {robot.stamp * 1e-9:.0f} simulated s in "
                  f"{time.monotonic() - begin:.0f} s", flush=True)
            self.assertGreaterEqual(reached, min_goals)
            true_T_map = self.check_poses(robot, out)
            self.check_map(robot, true_T_map, pathlib.Path(folder), out)

    def connect(self, session, seconds):
        session.join("office_test")
        return Robot(seconds)

    def check_poses(self, robot, out):
        """Errors against the truth over time; returns where the map lies in the true map."""
        both = sorted(set(robot.truth) & set(robot.estimates))
        self.assertGreater(len(both), 0.9 * (robot.steps - 10), "the mapper lost scans")
        true_T_map = compose(robot.truth[both[0]], inverse(robot.estimates[both[0]]))
        errors = []
        for stamp in both:
            found, truth = compose(true_T_map, robot.estimates[stamp]), robot.truth[stamp]
            errors.append((stamp * 1e-9, math.dist(found[:2], truth[:2]),
                           math.degrees(abs(math.remainder(found[2] - truth[2], 2 * math.pi)))))
        np.savetxt(out / "pose_errors.csv", errors, delimiter=",", header="stamp_s,error_m,error_deg", fmt="%.4f")
        metres, degrees = np.array(errors)[:, 1], np.array(errors)[:, 2]
        print(f"pose error of {len(both)} scans: mean {metres.mean():.3f} m {degrees.mean():.2f} deg, "
              f"max {metres.max():.3f} m {degrees.max():.2f} deg, at the end {metres[-1]:.3f} m", flush=True)
        self.assertLess(metres.mean(), MAX_MEAN_ERROR_M)
        self.assertLess(metres.max(), self.max_error_m)
        self.assertLess(degrees.max(), self.max_error_deg)
        return true_T_map

    def check_map(self, robot, true_T_map, folder, out):
        import rospy
        from nav_msgs.srv import GetMap

        from extperfc.srv import SaveMap
        saved = rospy.ServiceProxy("mapper/save_map", SaveMap)(str(folder / "office"))
        self.assertTrue(saved.success, saved.message)
        found = rospy.ServiceProxy("dynamic_map", GetMap)().map
        comparison = Comparison(robot.true_map, found, true_T_map)
        comparison.image(out / "comparison.png")
        precision, recall, f_score = comparison.scores()
        print(f"occupied cells within {TOLERANCE_CELLS} cell: precision {precision:.3f}, recall {recall:.3f}, "
              f"F-score {f_score:.3f}; images: {out}", flush=True)
        self.assertGreater(precision, MIN_PRECISION)
        self.assertGreater(recall, MIN_RECALL)
        self.assertGreater(f_score, MIN_F_SCORE)
        pgm = (folder / "office.pgm").read_bytes()
        self.assertTrue(pgm.startswith(b"P5"), pgm[:20])
        self.assertGreater((folder / "office.session").stat().st_size, 1000)


class MappingOffice(OfficeCase):
    def test_the_map_of_a_drive_is_the_true_one(self):
        """At night: people and the robot would block each other."""
        self.map_the_office(OUT, walks=[], rounds=1, seconds=SECONDS, min_goals=MIN_GOALS)


if __name__ == "__main__":
    unittest.main()

"""The simulated robot with a navigator, as a client sees it: goals, what it drove, and what it touched."""

import math
import threading
import time

import numpy

from driven_contacts import PERSON_RADIUS_M, count_episodes, distance_to_footprint
from pose_errors import Pose
from ros_session import Stalled
from sim_robot import planar

BUMP_M = PERSON_RADIUS_M + 0.1  # of a person's middle from the footprint, where the base stands against that person
LOST = 9
DONE = (2, 3, 4, 5, 8)  # preempted, succeeded, aborted, rejected, recalled


class Drive:
    """What happened on the path to one goal."""

    def __init__(self, goal, state, text, samples, people, planned_m, bumps=(), said=()):
        self.goal, self.state, self.text, self.planned_m = goal, state, text, planned_m
        self.said = said        # (stamp, what the navigator said)
        self.bumps = bumps      # stamps at which the base began to stand against something
        self.samples = samples  # (stamp, Pose) of the truth
        self.people = people    # (stamp, [(x, y), ...])

    @property
    def reached(self):
        return self.state == 3

    @property
    def seconds(self):
        return self.samples[-1][0] - self.samples[0][0] if len(self.samples) > 1 else 0.0

    @property
    def driven_m(self):
        return sum(math.hypot(b.x - a.x, b.y - a.y) for (_, a), (_, b) in zip(self.samples[::5], self.samples[5::5]))

    def error(self):
        """Distance and angle to the goal at the end [m], [rad]."""
        here = self.samples[-1][1]
        return (math.hypot(here.x - self.goal.x, here.y - self.goal.y),
                abs(math.remainder(here.yaw - self.goal.yaw, 2 * math.pi)))

    def contacts(self, true_map):
        """How often the footprint began to touch the true map, or stood against something that is no person. A base that
        meets something stands before it is inside: the map alone would not show it."""
        touched = count_episodes([true_map.touches(pose) for _, pose in self.samples])
        return max(touched, sum(not self._at_person(stamp, BUMP_M) for stamp in self.bumps))

    def contact_places(self, true_map):
        """Where and when each contact with the true map, or each stand against something, began, and what the navigator said then."""
        flags = [true_map.touches(pose) for _, pose in self.samples]
        begun = [stamp for (stamp, _), before, now in zip(self.samples, [False, *flags], flags) if now and not before]
        return [*(self._moment(stamp, "touches") for stamp in begun),
                *(self._moment(stamp, "stands before a person" if self._at_person(stamp, BUMP_M) else "stands against something")
                  for stamp in self.bumps)]

    def _moment(self, stamp, what):
        pose = min(self.samples, key=lambda entry: abs(entry[0] - stamp))[1]
        before = [text for said_at, text in self.said if said_at <= stamp]
        return {"what": what, "time_s": stamp, "x": pose.x, "y": pose.y, "yaw": pose.yaw, "navigator": before[-1] if before else ""}

    def _at_person(self, stamp, within_m):
        """Whether a person stood within this distance of the footprint."""
        if not self.people:
            return False
        people = min(self.people, key=lambda entry: abs(entry[0] - stamp))[1]
        pose = min(self.samples, key=lambda entry: abs(entry[0] - stamp))[1]
        return any(distance_to_footprint(pose, x, y) < within_m for x, y in people)

    def person_contacts(self):
        """How often a person and the footprint began to touch while the robot drove, and while it stood."""
        driving = standing = 0
        was_near, stamps = False, [stamp for stamp, _ in self.samples]
        for stamp, people in self.people:
            index = min(int(numpy.searchsorted(stamps, stamp)), len(stamps) - 1)
            pose = self.samples[index][1]
            near = any(distance_to_footprint(pose, x, y) < PERSON_RADIUS_M for x, y in people)
            before = self.samples[max(0, index - 5)]
            moved = math.hypot(pose.x - before[1].x, pose.y - before[1].y)
            moving = moved / max(1e-3, stamps[index] - before[0]) > 0.05
            driving += near and not was_near and moving
            standing += near and not was_near and not moving
            was_near = near
        bumped = sum(self._at_person(stamp, BUMP_M) for stamp in self.bumps)
        return max(driving, bumped), standing


class NavRobot:
    """One per process; call after rospy.init_node. `alive()` is false when what it talks to has ended."""

    def __init__(self, alive=lambda: True):
        import actionlib_msgs.msg
        import extperfc.msg
        import move_base_msgs.msg
        import nav_msgs.msg
        import rospy
        import std_msgs.msg
        import vision_msgs.msg

        self.rospy, self.messages, self.alive = rospy, move_base_msgs.msg, alive
        self.lock = threading.Lock()
        self.samples, self.people, self.paths, self.bumps, self.said = [], [], [], [], []
        self.status = None  # the navigator's
        self.last_twist = None
        self.states = {}    # of goals, by id
        self.listed, self.lost = set(), set()  # ids of goals that the navigator knew, and those that it knew no more
        self.map = None
        self.number = 0
        self.goal_publisher = rospy.Publisher("move_base/goal", move_base_msgs.msg.MoveBaseActionGoal, queue_size=5)
        self.cancel_publisher = rospy.Publisher("move_base/cancel", actionlib_msgs.msg.GoalID, queue_size=5)
        rospy.Subscriber("move_base/result", move_base_msgs.msg.MoveBaseActionResult, self._on_result)
        rospy.Subscriber("move_base/status", actionlib_msgs.msg.GoalStatusArray, self._on_goals)
        rospy.Subscriber("move_base/global_plan", nav_msgs.msg.Path, self._on_path)
        rospy.Subscriber("navigation_status", extperfc.msg.NavigationStatus, self._on_status)
        rospy.Subscriber("sim/truth/odom", nav_msgs.msg.Odometry, self._on_truth, queue_size=200)
        rospy.Subscriber("sim/truth/blocked", std_msgs.msg.Bool, self._on_blocked)
        rospy.Subscriber("sim/truth/map", nav_msgs.msg.OccupancyGrid, self._on_map)
        rospy.Subscriber("sim/truth/objects", vision_msgs.msg.Detection3DArray, self._on_objects, queue_size=20)
        self.person_ids = None

    def _on_map(self, message):
        self.map = message

    def _on_truth(self, message):
        with self.lock:
            self.samples.append((message.header.stamp.to_sec(), planar(message.pose.pose)))

    def _on_blocked(self, message):
        with self.lock:
            if message.data and self.samples:
                self.bumps.append(self.samples[-1][0])

    def _on_objects(self, message):
        if self.person_ids is None:
            classes = self.rospy.get_param("simulator/classes", [])
            self.person_ids = {i for i, name in enumerate(classes) if name == "person"}
        found = [(d.bbox.center.position.x, d.bbox.center.position.y) for d in message.detections
                 if d.results and d.results[0].id in self.person_ids]
        with self.lock:
            self.people.append((message.header.stamp.to_sec(), found))

    def _on_path(self, message):
        points = numpy.array([(p.pose.position.x, p.pose.position.y) for p in message.poses])
        with self.lock:
            self.paths.append(points)

    def _on_status(self, message):
        self.status = message
        text = f"{message.state}: {message.reason}" if message.reason else message.state
        with self.lock:
            if self.samples and (not self.said or self.said[-1][1] != text):
                self.said.append((self.samples[-1][0], text))

    def _on_result(self, message):
        with self.lock:
            self.states[message.status.goal_id.id] = (message.status.status, message.status.text)

    def _on_goals(self, message):
        known = {status.goal_id.id for status in message.status_list}
        with self.lock:
            self.lost |= self.listed - known
            self.listed = known

    def now(self):
        with self.lock:
            return self.samples[-1][0] if self.samples else 0.0

    def pose(self):
        with self.lock:
            return self.samples[-1][1]

    def wait(self, condition, what, real_s=60.0):
        deadline = time.monotonic() + real_s
        while not condition():
            if time.monotonic() > deadline or self.rospy.is_shutdown() or not self.alive():
                raise Stalled(f"waited {real_s:.0f} s for {what}" if self.alive() else "roslaunch has ended")
            time.sleep(0.01)

    def ready(self):
        """Until everything was heard once and the navigator has all its data."""
        self.wait(lambda: self.map is not None and self.now() > 0, "the simulator's map and truth", 120)
        self.wait(lambda: self.status is not None and self.goal_publisher.get_num_connections() > 0, "the navigator", 60)

    def send(self, goal, frame="map"):
        """Sends a goal; returns its id."""
        self.number += 1
        message = self.messages.MoveBaseActionGoal()
        message.goal_id.id = f"trial_{self.number}"
        message.goal.target_pose.header.frame_id = frame
        pose = message.goal.target_pose.pose
        pose.position.x, pose.position.y = goal.x, goal.y
        pose.orientation.z, pose.orientation.w = math.sin(goal.yaw / 2), math.cos(goal.yaw / 2)
        self.goal_publisher.publish(message)
        return message.goal_id.id

    def cancel(self):
        import actionlib_msgs.msg
        self.cancel_publisher.publish(actionlib_msgs.msg.GoalID())

    def drive(self, goal, limit_s=300.0, real_s=600.0, meanwhile=None, frame="map"):
        """Drives to a goal and returns the Drive. `limit_s`: of simulated time; cancelled afterwards. `meanwhile` is called
        with every true pose until it returns True."""
        self.forget()
        begin, deadline = self.now(), time.monotonic() + real_s
        name = self.send(goal, frame)
        cancelled = False
        while True:
            with self.lock:
                state, lost = self.states.get(name), name in self.lost
            if lost and not state:
                state = (LOST, "the navigator began anew and lost the goal")
                break
            if state and state[0] in DONE:
                break
            if not self.alive():
                raise Stalled("roslaunch has ended")
            if time.monotonic() > deadline:
                state = (LOST, f"no end after {real_s:.0f} s of real time")
                break
            if not cancelled and self.now() - begin > limit_s:
                cancelled = True
                self.cancel()
            if meanwhile and meanwhile(self.pose()):
                meanwhile = None
            time.sleep(0.01)
        if cancelled and state[0] != LOST:
            state = (state[0], f"not reached in {limit_s:.0f} s: {self.status.reason}")
        return self.recorded(goal, *state)

    def forget(self):
        """What was heard before now, but for the present pose."""
        with self.lock:
            del self.samples[:-1], self.people[:], self.paths[:], self.bumps[:], self.said[:]
            self.lost.clear()

    def recorded(self, goal, state, text):
        """The Drive since forget()."""
        with self.lock:
            planned = float(numpy.linalg.norm(numpy.diff(self.paths[0], axis=0), axis=1).sum()) if self.paths else 0.0
            return Drive(goal, state, text, list(self.samples), list(self.people), planned, list(self.bumps), list(self.said))


def random_goal(rng, places, here, min_m=3.0):
    """A Pose at one of the places (x, y), not too near."""
    while True:
        x, y = places[rng.randrange(len(places))]
        if math.hypot(x - here.x, y - here.y) > min_m:
            return Pose(float(x), float(y), rng.uniform(-math.pi, math.pi))

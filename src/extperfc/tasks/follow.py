"""Leaves that follow a person."""

import math
import threading

import rospy

import extperfc.msg
import extperfc.srv
from extperfc.arm import robot_state
from extperfc.arm.errors import ArmError
from extperfc.tasks.base_leaves import GoTo
from extperfc.tasks.blackboard import read, write
from extperfc.tasks.leader import WALKS_M_S, Leader, NamedFace, Person, is_other_goal
from extperfc.tasks.leaf import Leaf
from extperfc.tasks.search import base_pose

FRAME = "odom"
SEND_S = 0.7         # of ROS time, between two goals
SERVICE_WAIT_S = 10.0  # of real time
OLD_S = 1.0          # of ROS time: older scans and faces do not count
TRANSFORM_S = 0.1    # of real time
RETRY_S = 2.0        # of ROS time, between attempts at one that was not reached
ARRIVED_M = 0.4
FARTHER_M, MAX_FARTHER_M = 0.4, 2.0  # from the leader, after each goal that was not reached
AHEAD_S, CLOSEST_M = 1.2, 0.7  # a goal is so much nearer to who walks away, but never nearer than this
DETOUR_M = 6.0       # who is in sight is not followed on a path that is so much longer than the straight line:
DETOUR_WAIT_S = 8.0  # what stands between, mostly a person, goes away within this time of ROS
LAST_SEEN_M = 0.3    # who is lost is sought from so near to where they were seen last


class _People:
    """The newest `move_base/people_tracks`, the faces with names of the newest `faces`, and how far the robot drives."""

    def __init__(self):
        self._lock, self._tracks, self._faces, self._navigator = threading.Lock(), None, None, None
        rospy.Subscriber("move_base/people_tracks", extperfc.msg.TrackArray, self._on_tracks, queue_size=1)
        rospy.Subscriber("faces", extperfc.msg.FaceArray, self._on_faces, queue_size=1)
        rospy.Subscriber("navigation_status", extperfc.msg.NavigationStatus, self._on_navigator, queue_size=1)

    def _on_tracks(self, message):
        with self._lock:
            self._tracks = message

    def _on_faces(self, message):
        with self._lock:
            self._faces = message

    def _on_navigator(self, message):
        with self._lock:
            self._navigator = message

    def left_m(self):
        """Of the path that the robot is on; None: it is on none."""
        with self._lock:
            return self._navigator.distance_left if self._navigator and self._navigator.state == "controlling" else None

    def tracks(self, now):
        """[Person] in FRAME; empty without a scan."""
        with self._lock:
            message = self._tracks
        if message is None or abs((now - message.header.stamp).to_sec()) > OLD_S:
            return []
        return [Person(one.id, (one.pose.pose.position.x, one.pose.pose.position.y), (one.velocity.x, one.velocity.y),
                       one.last_seen == message.header.stamp) for one in message.tracks]

    def faces(self, now):
        """[NamedFace] in FRAME of an image that was not asked for before."""
        with self._lock:
            message, self._faces = self._faces, None
        if message is None or abs((now - message.header.stamp).to_sec()) > OLD_S:
            return []
        named = [face for face in message.faces if face.name and face.has_position]
        if not named:
            return []
        try:
            frame_T_camera = robot_state.frames().matrix(FRAME, message.header.frame_id, TRANSFORM_S, message.header.stamp)
        except ArmError:
            return []
        places = [frame_T_camera @ (face.position.x, face.position.y, face.position.z, 1.0) for face in named]
        return [NamedFace(face.name, (float(place[0]), float(place[1]))) for face, place in zip(named, places)]


class Follow(Leaf):
    """Follows a person at `distance_m` until `seconds` of ROS time have passed since it began.

    name: of an enrolled face; "": the first person who walks before the base within `meet_m`. Who is out of sight is sought
    where they were seen last; after `lost_s` the leaf fails. The Leader is written under `key`. Needs people by the navigator
    (topic `move_base/people_tracks`), and for names the nodelet `faces`.
    """

    _people = None

    def __init__(self, name="", key="leader", distance_m=1.2, seconds=math.inf, meet_m=3.5, lost_s=30.0, title=None):
        super().__init__(title or f"follow {name or 'a person'}")
        self.person, self.key, self.distance_m, self.seconds = name, key, distance_m, seconds
        self.meet_m, self.lost_s = meet_m, lost_s

    def setup(self, **_):
        Follow._people = Follow._people or _People()

    def begin(self):
        self.setup()
        self.leader, self._motion, self.goal, self._farther_m = Leader(self.person), None, None, 0.0
        self._detour_since = None
        self.people = []
        self._begin = self._next = rospy.Time.now()
        write(self.key, self.leader)

    def step(self):
        now = rospy.Time.now()
        if (now - self._begin).to_sec() > self.seconds:
            if not self.leader.known:
                raise ValueError(f"{self.person or 'a person'} was not seen within {self.seconds:g} s")
            return True
        self.people = self._people.tracks(now)
        self.leader.hear(self._people.faces(now), self.people, now.to_sec())
        robot = base_pose(FRAME)
        if self.leader.known:
            self.leader.update(self.people, now.to_sec())
            self._go(robot, now)
        else:
            self._meet(robot, now)
        return None

    def _meet(self, robot, now):
        self.feedback_message = f"waits for {self.person or 'a person'}"
        person = self.leader.named(self.people) if self.person else self._first(robot)
        if person is not None:
            rospy.loginfo("follows %s at (%.2f, %.2f)", self.person or "a person", *person.position)
            self.leader.choose(person, now.to_sec())

    def _first(self, robot):
        """Who walks before the base; the nearest."""
        def is_before(one):
            bearing = math.atan2(one.position[1] - robot[1], one.position[0] - robot[0]) - robot[2]
            return math.dist(one.position, robot[:2]) < self.meet_m and abs(math.remainder(bearing, 2 * math.pi)) < 1.0

        walking = [one for one in self.people if one.seen and one.speed > WALKS_M_S and is_before(one)]
        return min(walking, key=lambda one: math.dist(one.position, robot[:2]), default=None)

    def _go(self, robot, now):
        unseen, lost = self.leader.unseen_s(now.to_sec()), self.leader.is_lost(now.to_sec())
        who = self.person or "the person"
        self.feedback_message = (f"{who} is out of sight for {unseen:.0f} s" if lost else
                                 f"{math.dist(robot[:2], self.leader.position):.1f} m behind {who}")
        if unseen > self.lost_s:
            raise ValueError(f"{who} is out of sight for {unseen:.0f} s")
        seek = lost and not self.leader.stands
        distance_m = LAST_SEEN_M if seek else self._apart_m(robot)
        goal = self.leader.behind(robot[:2], distance_m + self._farther_m, in_sight=not lost)
        failed = self._failed(robot)
        if not lost and self._would_leave(robot, now):
            self._motion.cancel()
            self._motion, self.goal, self._next = None, None, now + rospy.Duration(RETRY_S)
        if now >= self._next and (is_other_goal(goal, self.goal) or failed):
            self._farther_m = min(MAX_FARTHER_M, self._farther_m + FARTHER_M) if failed else 0.0
            self._next = now + rospy.Duration(RETRY_S if failed else SEND_S)
            self.goal = goal
            self._motion = GoTo(goal, FRAME).motion()

    def _apart_m(self, robot):
        """Between the base's next goal and where the leader is now: less from who walks away and will be gone when the base
        arrives; who comes is waited for."""
        dx, dy = self.leader.position[0] - robot[0], self.leader.position[1] - robot[1]
        apart_m = max(1e-6, math.hypot(dx, dy))
        leaves_m_s = (dx * self.leader.velocity[0] + dy * self.leader.velocity[1]) / apart_m
        if leaves_m_s < -WALKS_M_S:
            return max(self.distance_m, apart_m)
        return max(CLOSEST_M, self.distance_m - AHEAD_S * max(0.0, leaves_m_s))

    def _would_leave(self, robot, now):
        """The robot has begun a long detour to who is in sight, and has not yet waited for the direct path."""
        left_m = self._people.left_m()
        if self._motion is None or self._motion.done or left_m is None:
            return False
        if left_m < math.dist(robot[:2], self.goal[:2]) + DETOUR_M:
            self._detour_since = None
            return False
        self._detour_since = self._detour_since or now
        return (now - self._detour_since).to_sec() < DETOUR_WAIT_S

    def _failed(self, robot):
        """The last goal ended elsewhere."""
        return self._motion is not None and self._motion.done and math.dist(robot[:2], self.goal[:2]) > ARRIVED_M


class EnrollFace(Leaf):
    """Gives the nearest face before the camera a name, by the nodelet `faces`; that person should look into the camera."""

    START = "is the nodelet faces running (roslaunch extperfc faces.launch)?"

    def __init__(self, name, samples=0, timeout_s=15.0, title=None):
        super().__init__(title or f"enroll {name}")
        self.person, self.samples, self.timeout_s = name, samples, timeout_s

    def begin(self):
        self._answer, self._problem = None, ""
        threading.Thread(target=self._ask, daemon=True).start()

    def _ask(self):
        try:
            rospy.wait_for_service("faces/enroll", SERVICE_WAIT_S)
            service = rospy.ServiceProxy("faces/enroll", extperfc.srv.EnrollFace)
            self._answer = service(read(self.person), self.samples, rospy.Duration(self.timeout_s))
        except (rospy.ROSException, rospy.ServiceException) as error:
            self._problem = f"{rospy.resolve_name('faces/enroll')} does not answer: {error}; {self.START}"

    def step(self):
        if self._problem:
            raise ValueError(self._problem)
        if self._answer is None:
            return None
        if not self._answer.success:
            raise ValueError(f"{read(self.person)} was not enrolled: {self._answer.message}")
        self.feedback_message = f"{self._answer.total} samples"
        return True

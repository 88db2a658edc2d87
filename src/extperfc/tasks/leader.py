"""Who is followed, from scan to scan, and where to stand behind them. Without ROS; all positions in one frame that stands still
and does not jump (odom)."""

import math
from dataclasses import dataclass

import numpy

TRAIL_STEP_M = 0.1       # between points of the trail
TRAIL_M = 15.0           # of it are kept
GATE_M = 0.6             # from where the leader should be to who is taken for the leader again
GATE_GROWS_M_S = 0.9     # while the leader is not seen: a person may walk into any direction
MAX_GATE_M = 3.0
STARTS_M = 0.9           # the gate of a leader who stood: it walks on from there, and is seen to walk after some steps
PREDICT_S = 1.0          # the leader is expected to walk straight on for so long
WALKS_M_S = 0.25         # who is slower may be furniture
WALK_S, WALK_M = 0.7, 0.3  # so long, so far: that somebody walks is certain
HISTORY_S = 1.5          # of the people around
SWAPPED_S = 4.0          # a leader who stands for less may be furniture that was taken for the leader when passed
FACE_M = 0.6             # from a face to the person it belongs to, on the floor
APART_M = 0.5            # who is seen so far from the walking leader, both for so long, is another person for as long as the
APART_S = 0.5            # track lasts
OWN_FACE_S = 3.0         # a name holds so long without being seen again when another name is seen


@dataclass(frozen=True)
class Person:
    """Of one scan. position and velocity: (x, y) [m, m/s]."""
    track: int
    position: tuple
    velocity: tuple = (0.0, 0.0)
    seen: bool = True  # False: predicted

    @property
    def speed(self):
        return math.hypot(*self.velocity)


@dataclass(frozen=True)
class NamedFace:
    """A recognised face above a place (x, y)."""
    name: str
    position: tuple


class Leader:
    """The person who is followed.

    name: "" for who comes first; else who has this face. lost: how often the leader was out of sight for longer than
    lost_s and had to be found again.
    """

    def __init__(self, name="", lost_s=1.0):
        self.name, self.lost_s = name, lost_s
        self.track, self.position, self.velocity = None, None, (0.0, 0.0)
        self.trail, self.lost, self._seen_at, self._names, self._face = [], 0, None, {}, None
        self._walked_at, self._history, self._beside = None, {}, {}

    def choose(self, person, now):
        """Begins to follow a person."""
        self.track, self.trail, self._walked_at = person.track, [], now
        self._take(person, now)

    @property
    def known(self):
        return self.position is not None

    def unseen_s(self, now):
        return now - self._seen_at

    def is_lost(self, now):
        return self.unseen_s(now) > self.lost_s

    @property
    def stands(self):
        """When last seen. Who stands becomes a part of the map, and is a person no more for who looks for what it lacks."""
        return math.hypot(*self.velocity) < WALKS_M_S

    def hear(self, faces, people, now):
        """Faces tell who is who: a name is that of the nearest person below it. The leader's is one without a person, too."""
        self._face = next((face for face in faces if self.name and face.name == self.name), None)
        for face in faces:
            near = min(people, key=lambda one: math.dist(one.position, face.position), default=None)
            if near is not None and math.dist(near.position, face.position) < FACE_M:
                self._names[near.track] = (face.name, now)
        tracks = {one.track for one in people}
        self._names = {track: said for track, said in self._names.items() if track in tracks}

    def named(self, people):
        """The person with the leader's name; a face alone is a person, too. None: not seen."""
        if not self.name:
            return None
        found = next((one for one in people if self._names.get(one.track, ("", 0))[0] == self.name), None)
        return Person(None, self._face.position) if found is None and self._face is not None else found

    def update(self, people, now):
        """People of a scan, after hear(). Without a leader: who is taken is for choose() to say."""
        self._remember(people, now)
        person = next((one for one in people if one.track == self.track), None)
        if person is not None and self._is_another(person, now):
            person, self.track = None, None
        if person is None:
            person = self.named(people) or self._near([one for one in people if not self._was_beside(one)], now)
        elif WALK_S < now - self._walked_at < SWAPPED_S:
            person = self._near([one for one in people if one is not person], now) or person
        if person is not None and person.seen:
            if self.is_lost(now):
                self.lost += 1
            self.track = person.track
            self._take(person, now)
            self._note_others(person, people, now)

    def _note_others(self, leader, people, now):
        """Who is seen beside the walking leader is another person, also when the leader is out of sight later."""
        present = {one.track for one in people}
        self._beside = {track: when for track, when in self._beside.items() if track in present and track != leader.track}
        if leader.speed > WALKS_M_S:
            for one in people:
                if one.seen and math.dist(one.position, leader.position) > APART_M:
                    self._beside[one.track] = (self._beside.get(one.track, (now, now))[0], now)

    def _was_beside(self, person):
        """For long enough: where another person comes between, two tracks may be the leader's for some scans."""
        first, last = self._beside.get(person.track, (0.0, 0.0))
        return last - first > APART_S

    def _remember(self, people, now):
        self._history = {one.track: [*self._history.get(one.track, []), (now, one.position)] for one in people if one.seen}
        for seen in self._history.values():
            while now - seen[0][0] > HISTORY_S:
                del seen[0]

    def _walks(self, person):
        """For certain."""
        seen = self._history.get(person.track, [])
        return len(seen) > 1 and seen[-1][0] - seen[0][0] >= WALK_S and math.dist(seen[0][1], seen[-1][1]) >= WALK_M

    def _is_another(self, person, now):
        name, when = self._names.get(person.track, (self.name, now))
        return bool(self.name) and name != self.name and now - when < OWN_FACE_S

    def _near(self, people, now):
        """Who may be the leader, by where and how they walk."""
        unseen = max(self.unseen_s(now), now - self._walked_at)
        gate = STARTS_M if unseen > SWAPPED_S and self.stands else min(MAX_GATE_M, GATE_M + GATE_GROWS_M_S * unseen)
        near = [one for one in people if self._astray_m(one, now) < gate and not self._is_another(one, now)
                and (self._walks(one) or self.is_lost(now) and self.stands and math.dist(one.position, self.position) < GATE_M)]
        return min(near, key=lambda one: self._astray_m(one, now), default=None)

    def _astray_m(self, person, now):
        """How far a person is from where the leader may be by walking straight on: surely for PREDICT_S, later perhaps."""
        unseen, speed = self.unseen_s(now), math.hypot(*self.velocity)
        low_m, high_m = speed * min(unseen, PREDICT_S), speed * unseen
        offset = numpy.subtract(person.position, self.position)
        ahead = numpy.array(self.velocity) / speed if speed > 0 else numpy.zeros(2)
        along_m = min(high_m, max(low_m, float(offset @ ahead)))
        return float(numpy.linalg.norm(offset - along_m * ahead))

    def _take(self, person, now):
        self.position, self.velocity, self._seen_at = person.position, person.velocity, now
        if person.speed > WALKS_M_S or self._walked_at is None:
            self._walked_at = now
        if not self.trail or math.dist(self.trail[-1], person.position) > TRAIL_STEP_M:
            self.trail.append(person.position)
            while len(self.trail) > TRAIL_M / TRAIL_STEP_M:
                del self.trail[0]

    def behind(self, robot, distance_m, in_sight=False):
        """(x, y, yaw): where to stand to follow at a distance, for a robot at (x, y): a place where the leader has walked, so
        that it is free, or between the robot and there; where the robot is when it is near enough. It looks at the leader.

        in_sight: the leader is seen now. Then it is no place beyond a leader who came towards the robot, but one before."""
        place = tuple(robot)
        away_m = math.dist(robot, self.position)
        if away_m > distance_m:
            place = self._on_trail(place, distance_m)
            if in_sight and math.dist(robot, place) > away_m:
                place = tuple(p + distance_m / away_m * (r - p) for p, r in zip(self.position, robot))
        return (*place, math.atan2(self.position[1] - place[1], self.position[0] - place[0]))

    def _on_trail(self, robot, distance_m):
        """The last place of the path from the robot along the trail that is so far from the leader as the crow flies."""
        path = [robot, *self.trail]
        for earlier, later in zip(reversed(path[:-1]), reversed(path[1:])):
            far, near = math.dist(earlier, self.position), math.dist(later, self.position)
            if far >= distance_m:
                part = 0.0 if far - near < 1e-6 else min(1.0, max(0.0, (distance_m - near) / (far - near)))
                return tuple(float(v) for v in numpy.array(later) + part * (numpy.array(earlier) - numpy.array(later)))
        return robot


def is_other_goal(goal, sent, move_m=0.3, yaw_rad=0.35):
    """Whether a goal (x, y, yaw) differs so much from the one that was sent that it is worth another."""
    return (sent is None or math.dist(goal[:2], sent[:2]) > move_m
            or abs(math.remainder(goal[2] - sent[2], 2 * math.pi)) > yaw_rad)

"""Following a person, with people, faces and a base that are made up."""

import math
import pathlib
import sys
import types
import unittest
from unittest import mock

REPO = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(REPO / "src"))

try:
    import py_trees
except ModuleNotFoundError:
    raise unittest.SkipTest("py_trees is not installed: tools/setup fetches it") from None

import rospy  # noqa: E402

from extperfc import tasks  # noqa: E402
from extperfc.tasks import follow  # noqa: E402
from extperfc.tasks.leader import Leader, NamedFace, Person, is_other_goal  # noqa: E402

RUNNING, SUCCESS, FAILURE = (py_trees.common.Status.RUNNING, py_trees.common.Status.SUCCESS, py_trees.common.Status.FAILURE)
SPEED = 0.6


def walk(leader, corners, start_s=0.0, track=7):
    """Leads along straight lines at SPEED, ten scans a second; returns the time at the end."""
    now = start_s
    for (x0, y0), (x1, y1) in zip(corners, corners[1:]):
        length = math.dist((x0, y0), (x1, y1))
        velocity = (SPEED * (x1 - x0) / length, SPEED * (y1 - y0) / length)
        for step in range(int(10 * length / SPEED)):
            person = Person(track, (x0 + 0.1 * step * velocity[0], y0 + 0.1 * step * velocity[1]), velocity)
            if leader.known:
                leader.update([person, Person(99, (5.0, 5.0))], now)
            else:
                leader.choose(person, now)
            now += 0.1
    return now


class TheLeader(unittest.TestCase):
    def setUp(self):
        self.leader = Leader()

    def test_one_stands_behind_on_the_path_that_was_walked(self):
        walk(self.leader, [(0, 0), (4, 0), (4, 3)])
        x, y, yaw = self.leader.behind((1.0, 0.0), 1.2)
        self.assertAlmostEqual(4.0, x, delta=0.02)
        self.assertAlmostEqual(1.2, math.dist((x, y), self.leader.position), delta=0.02)
        self.assertAlmostEqual(math.pi / 2, yaw, delta=0.05)

    def test_who_is_near_enough_stays_and_looks(self):
        walk(self.leader, [(0, 0), (4, 0)])
        at = self.leader.position
        x, y, yaw = self.leader.behind((at[0], at[1] - 1.0), 1.2)
        self.assertEqual((at[0], at[1] - 1.0), (x, y))
        self.assertAlmostEqual(math.pi / 2, yaw)

    def test_a_leader_who_has_not_walked_yet_is_driven_to(self):
        self.leader.choose(Person(1, (3.0, 0.0)), 0.0)
        x, y, yaw = self.leader.behind((0.0, 0.0), 1.2)
        self.assertAlmostEqual(1.8, x)
        self.assertEqual((0.0, 0.0), (y, yaw))

    def test_who_comes_to_the_robot_is_not_passed(self):
        walk(self.leader, [(8, 0), (2.5, 0)])
        x, y, yaw = self.leader.behind((0.0, 0.0), 1.2, in_sight=True)
        self.assertAlmostEqual(self.leader.position[0] - 1.2, x)
        self.assertEqual((0.0, 0.0), (y, yaw))
        self.assertGreater(self.leader.behind((0.0, 0.0), 1.2)[0], 3.0)  # out of sight: where they came from

    def test_who_walked_straight_on_out_of_sight_is_found_far_away(self):
        now = walk(self.leader, [(0, 0), (4, 0)])
        self.leader.update([], now + 9.0)
        for step in range(12):  # has walked 5 m meanwhile
            self.leader.update([Person(70, (9.0 + 0.05 * step, 0.3), (SPEED, 0.0)), Person(8, (4.0, 5.0 + 0.05 * step))], now + 9.1 + 0.1 * step)
        self.assertEqual(70, self.leader.track)

    def test_the_trail_is_bounded(self):
        walk(self.leader, [(0, 0), (40, 0)])
        self.assertLess(len(self.leader.trail), 160)
        self.assertGreater(self.leader.trail[0][0], 20)

    def test_others_who_cross_are_not_followed(self):
        now = walk(self.leader, [(0, 0), (4, 0)])
        for step in range(20):
            now += 0.1
            crossing = Person(8, (4.0 + 0.06 * step, 1.0 - 0.1 * step), (0.0, -1.0))
            self.leader.update([crossing, Person(7, (4.0 + 0.06 * step, 0.0), (0.6, 0.0))], now)
        self.assertEqual(7, self.leader.track)
        self.assertAlmostEqual(0.0, self.leader.position[1])
        self.assertEqual(0, self.leader.lost)

    def test_a_leader_with_two_tracks_for_a_moment_goes_on_with_the_second(self):
        """Somebody comes between: the first track jumps to what is behind, and the leader's returns begin a second one."""
        now = walk(self.leader, [(0, 0), (3, 0)])
        for step in range(30):
            own = Person(8, (3.0 + 0.1 * step * SPEED, 0.0), (SPEED, 0.0))
            jumped = [Person(7, (3.7, 0.3), (1.2, 0.3), seen=step < 2)] if step < 8 else []
            self.leader.update([own, *jumped], now + 0.1 * step)
        self.assertEqual(8, self.leader.track)
        self.assertFalse(self.leader.is_lost(now + 2.9))

    def test_who_walked_beside_the_leader_is_not_taken_for_the_leader_later(self):
        now, x = 0.0, 0.0
        for _ in range(30):
            x, now = x + 0.1 * SPEED, now + 0.1
            leader, other = Person(7, (x, 0.0), (SPEED, 0.0)), Person(8, (x, 1.0), (SPEED, 0.0))
            if self.leader.known:
                self.leader.update([leader, other], now)
            else:
                self.leader.choose(leader, now)
        for _ in range(30):
            x, now = x + 0.1 * SPEED, now + 0.1
            self.leader.update([Person(8, (x, 0.5), (SPEED, 0.0))], now)
        self.assertEqual(7, self.leader.track, "walks on where the leader would be, but is known to be another")
        for _ in range(20):
            x, now = x + 0.1 * SPEED, now + 0.1
            self.leader.update([Person(8, (x, 0.5), (SPEED, 0.0)), Person(9, (x, 0.0), (SPEED, 0.0))], now)
        self.assertEqual(9, self.leader.track, "a new number may be the leader")

    def test_who_comes_into_sight_again_with_another_number_is_found(self):
        now = walk(self.leader, [(0, 0), (4, 0)])
        self.leader.update([], now + 2.0)
        self.assertTrue(self.leader.is_lost(now + 2.0))
        for step in range(10):
            self.leader.update([Person(8, (4.5, 1.0 + 0.06 * step), (0.0, 0.6))], now + 2.0 + 0.1 * step)
        self.assertEqual((8, 1), (self.leader.track, self.leader.lost))

    def test_furniture_that_was_taken_for_the_leader_is_left_for_who_walks_on(self):
        now = walk(self.leader, [(0, 0), (4, 0)])
        for step in range(25):
            self.leader.update([Person(7, (4.0, 0.1)), Person(8, (4.0 + 0.06 * step, 0.0), (0.6, 0.0))], now + 0.1 * step)
        self.assertEqual(8, self.leader.track)

    def test_a_leader_who_stands_is_not_left_for_who_passes_later(self):
        now = walk(self.leader, [(0, 0), (4, 0)])
        for step in range(50):
            self.leader.update([Person(7, (4.0, 0.0))], now + 0.1 * step)
        for step in range(50):
            self.leader.update([Person(7, (4.0, 0.0)), Person(8, (2.0 + 0.06 * step, 0.8), (0.6, 0.0))], now + 5.0 + 0.1 * step)
        self.assertEqual(7, self.leader.track)

    def test_furniture_and_who_is_far_are_not_taken_for_the_leader(self):
        now = walk(self.leader, [(0, 0), (4, 0)])
        for step in range(10):
            jitter = 0.02 * (step % 2)
            self.leader.update([Person(8, (4.5 + jitter, 1.0), (0.4, 0.0)), Person(9, (9.5 + 0.06 * step, 0.0), (0.6, 0.0))],
                               now + 2.0 + 0.1 * step)
        self.assertTrue(self.leader.is_lost(now + 3.0))

    def test_a_prediction_is_not_a_sighting(self):
        now = walk(self.leader, [(0, 0), (4, 0)])
        before = self.leader.position
        self.leader.update([Person(7, (4.5, 0.0), (0.6, 0.0), seen=False)], now + 1.5)
        self.assertEqual(before, self.leader.position)
        self.assertTrue(self.leader.is_lost(now + 1.5))


class Names(unittest.TestCase):
    def setUp(self):
        self.leader = Leader("anna")
        self.now = walk(self.leader, [(0, 0), (4, 0)])

    def see(self, people, faces=()):
        self.now += 0.1
        self.leader.hear(faces, people, self.now)
        self.leader.update(people, self.now)

    def test_the_name_finds_the_leader_wherever_it_is(self):
        self.now += 20
        people = [Person(20, (4.3, 0.0), (0.5, 0.0)), Person(21, (12.0, 9.0), (0.0, 0.0))]
        self.see(people, [NamedFace("anna", (12.2, 9.1)), NamedFace("ben", (4.3, 0.1))])
        self.assertEqual(21, self.leader.track)

    def test_who_turns_out_to_be_another_is_left(self):
        ben = Person(7, (4.1, 0.0), (0.5, 0.0))
        self.see([ben], [NamedFace("ben", (4.1, 0.0))])
        self.assertIsNone(self.leader.track)
        for step in range(10):
            self.see([ben, Person(8, (4.4 + 0.05 * step, 0.5), (0.5, 0.0))])
        self.assertEqual(8, self.leader.track)

    def test_a_name_far_from_everybody_belongs_to_none_of_them(self):
        self.see([Person(7, (4.1, 0.0), (0.5, 0.0))], [NamedFace("ben", (4.1, 2.0))])
        self.assertEqual(7, self.leader.track)

    def test_a_face_alone_shows_where_the_leader_is(self):
        self.now += 5
        self.see([], [NamedFace("anna", (5.0, 1.0))])
        self.assertEqual((5.0, 1.0), self.leader.position)
        self.assertFalse(self.leader.is_lost(self.now))

    def test_names_of_who_is_gone_are_forgotten(self):
        for track in range(100, 200):
            self.see([Person(track, (9.0, 9.0))], [NamedFace("ben", (9.0, 9.0))])
        self.assertEqual(1, len(self.leader._names))


class Goals(unittest.TestCase):
    def test_which_are_worth_a_new_one(self):
        self.assertTrue(is_other_goal((0, 0, 0), None))
        self.assertFalse(is_other_goal((0.1, 0, 0.1), (0, 0, 0)))
        self.assertTrue(is_other_goal((0.5, 0, 0), (0, 0, 0)))
        self.assertFalse(is_other_goal((0, 0, math.pi), (0, 0, -math.pi)))


class FakeMotion:
    def __init__(self):
        self.done, self.cancelled = False, False

    def cancel(self):
        self.cancelled = True


class TheLeaf(unittest.TestCase):
    """The base goes to its goals at 0.8 m/s in straight lines."""

    def setUp(self):
        self.seconds, self.robot, self.goals, self.people, self.faces, self.motions = 100.0, (0.0, 0.0, 0.0), [], [], [], []
        self.left_m = None
        source = types.SimpleNamespace(tracks=lambda now: self.people, faces=lambda now: self.faces, left_m=lambda: self.left_m)
        for patched in (mock.patch.object(rospy.Time, "now", lambda: rospy.Time.from_sec(self.seconds)),
                        mock.patch.object(follow, "base_pose", lambda frame: self.robot),
                        mock.patch.object(follow, "_People", lambda: source), mock.patch.object(rospy, "loginfo"),
                        mock.patch.object(tasks.Follow, "_people", None),
                        mock.patch.object(tasks.GoTo, "motion", lambda leaf: self.drive(leaf))):
            patched.start()
            self.addCleanup(patched.stop)

    def drive(self, leaf):
        self.assertEqual("odom", leaf.frame)
        self.goals.append((self.seconds, leaf.pose))
        self.motions.append(FakeMotion())
        return self.motions[-1]

    def tick(self, leaf):
        leaf.tick_once()
        self.seconds += 0.1
        if self.goals and not self.motions[-1].done and not self.motions[-1].cancelled:
            (x, y, _), (gx, gy, yaw) = self.robot, self.goals[-1][1]
            far = math.dist((x, y), (gx, gy))
            part = 1.0 if far < 0.08 else 0.08 / far
            self.robot = (x + part * (gx - x), y + part * (gy - y), yaw)
            self.motions[-1].done = part == 1.0
        return leaf.status

    def lead(self, leaf, points, track=3):
        """A person walks from point to point; the distances to the base."""
        distances = []
        for (x0, y0), (x1, y1) in zip(points, points[1:]):
            steps = int(math.dist((x0, y0), (x1, y1)) / 0.06)
            velocity = (10 * (x1 - x0) / steps, 10 * (y1 - y0) / steps)
            for i in range(steps):
                place = (x0 + i * (x1 - x0) / steps, y0 + i * (y1 - y0) / steps)
                self.people = [Person(track, place, velocity)]
                if self.tick(leaf) != RUNNING:
                    return distances
                distances.append(math.dist(place, self.robot[:2]))
        return distances

    def test_it_follows_at_the_distance_and_not_with_every_scan_a_goal(self):
        leaf = tasks.Follow(distance_m=1.2)
        distances = self.lead(leaf, [(1.5, 0.0), (6.0, 0.0), (6.0, 5.0)])
        self.assertTrue(all(follow.CLOSEST_M < distance < 2.5 for distance in distances[30:]), distances)
        self.assertLess(len(self.goals), len(distances) / 6)
        self.assertTrue(all(b[0] - a[0] > 0.65 for a, b in zip(self.goals, self.goals[1:])))

    def test_who_comes_is_not_driven_to_nearer_than_the_distance(self):
        leaf = tasks.Follow(distance_m=1.2)
        distances = self.lead(leaf, [(3.4, 0.0), (1.6, 0.0)])
        self.people = [Person(3, (1.6, 0.0), (0.0, 0.0))]
        for _ in range(20):
            self.tick(leaf)
            distances.append(math.dist((1.6, 0.0), self.robot[:2]))
        self.assertGreater(min(distances), 1.1)

    def test_it_waits_for_who_walks_before_it(self):
        leaf = tasks.Follow()
        for person in (Person(1, (-2.0, 0.0), (0.6, 0.0)), Person(2, (2.0, 0.0), (0.1, 0.0)), Person(3, (9.0, 0.0), (0.6, 0.0)),
                       Person(4, (2.0, 0.0), (0.6, 0.0), seen=False)):
            self.people = [person]
            self.tick(leaf)
        self.assertFalse(leaf.leader.known)
        self.people = [Person(5, (2.0, 0.5), (0.0, 0.6))]
        self.tick(leaf)
        self.assertEqual(5, leaf.leader.track)

    def test_it_waits_for_a_name(self):
        leaf = tasks.Follow("anna")
        self.people = [Person(5, (2.0, 0.5), (0.0, 0.6)), Person(6, (3.0, 1.0))]
        self.tick(leaf)
        self.assertFalse(leaf.leader.known)
        self.faces = [NamedFace("anna", (3.1, 1.1))]
        self.tick(leaf)
        self.assertEqual(6, leaf.leader.track)

    def test_it_waits_for_a_face_that_no_person_of_the_scan_has(self):
        leaf = tasks.Follow("anna")
        self.faces = [NamedFace("anna", (2.2, 0.1))]
        self.tick(leaf)
        self.assertEqual((2.2, 0.1), leaf.leader.position)
        self.faces = []
        self.lead(leaf, [(2.2, 0.1), (6.0, 0.0)], track=9)
        self.assertEqual(9, leaf.leader.track)

    def test_a_long_detour_to_who_is_in_sight_is_taken_late(self):
        leaf = tasks.Follow()
        self.lead(leaf, [(1.5, 0.0), (3.0, 0.0)])
        here, self.left_m, begun = self.robot, 25.0, self.seconds
        self.lead(leaf, [(3.0, 0.0), (6.6, 0.0)])
        self.assertLess(math.dist(here[:2], self.robot[:2]), 0.5)
        self.assertTrue(any(motion.cancelled for motion in self.motions))
        while self.seconds < begun + follow.DETOUR_WAIT_S:
            self.tick(leaf)
        self.lead(leaf, [(6.6, 0.0), (8.0, 0.0)])
        self.assertFalse(self.motions[-1].cancelled)
        self.assertGreater(math.dist(here[:2], self.robot[:2]), 0.5)
        self.left_m = 1.0
        self.lead(leaf, [(8.0, 0.0), (9.0, 0.0)])
        self.assertIsNone(leaf._detour_since)

    def test_who_is_lost_is_sought_where_they_were_last(self):
        leaf = tasks.Follow()
        self.lead(leaf, [(1.5, 0.0), (6.0, 0.0)])
        self.people = []
        for _ in range(100):
            self.tick(leaf)
        self.assertLess(math.dist(self.robot[:2], leaf.leader.position), 0.5)
        self.assertIn("out of sight", leaf.feedback_message)
        self.lead(leaf, [(6.5, 0.5), (6.5, 2.0)], track=4)
        self.assertEqual((RUNNING, 1), (leaf.status, leaf.leader.lost))

    def test_who_stood_when_they_were_seen_last_is_not_run_over(self):
        leaf = tasks.Follow(distance_m=1.2)
        self.lead(leaf, [(1.5, 0.0), (6.0, 0.0)])
        self.people = [Person(3, (6.0, 0.0), (0.0, 0.0))]
        for _ in range(20):
            self.tick(leaf)
        self.people = []
        for _ in range(100):
            self.tick(leaf)
        self.assertGreaterEqual(math.dist(self.robot[:2], (6.0, 0.0)), follow.CLOSEST_M)

    def test_it_fails_when_the_leader_is_lost_for_good(self):
        leaf = tasks.Follow(lost_s=10)
        self.lead(leaf, [(1.5, 0.0), (3.0, 0.0)])
        self.people = []
        for _ in range(110):
            if self.tick(leaf) != RUNNING:
                break
        self.assertEqual(FAILURE, leaf.status)
        self.assertIn("the person is out of sight for 10 s", leaf.feedback_message)

    def test_it_ends_after_its_time(self):
        leaf = tasks.Follow(seconds=5)
        self.lead(leaf, [(1.5, 0.0), (5.0, 0.0)])
        self.assertEqual(SUCCESS, leaf.status)
        nobody = tasks.Follow("anna", seconds=5)
        for _ in range(60):
            if self.tick(nobody) != RUNNING:
                break
        self.assertEqual((FAILURE, "anna was not seen within 5 s"), (nobody.status, nobody.feedback_message))

    def test_a_goal_that_was_not_reached_is_sent_again(self):
        leaf = tasks.Follow()
        self.lead(leaf, [(1.5, 0.0), (4.0, 0.0)])
        self.robot, self.motions[-1].done, sent = (0.0, 0.0, 0.0), True, len(self.goals)
        self.people = [Person(3, (4.0, 0.0), (0.3, 0.0))]
        for _ in range(30):
            self.motions[-1].done = True
            self.tick(leaf)
        self.assertEqual(sent + 2, len(self.goals), "not with every tick")

    def test_the_base_stops_when_it_is_left(self):
        leaf = tasks.Follow()
        self.lead(leaf, [(1.5, 0.0), (4.0, 0.0)])
        self.motions[-1].done = False
        leaf.stop(py_trees.common.Status.INVALID)
        self.assertTrue(self.motions[-1].cancelled)


if __name__ == "__main__":
    unittest.main()

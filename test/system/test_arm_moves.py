"""The arm node with the simulated robot: motions, scene, and everything that goes wrong, by the Python client."""

import math
import pathlib
import sys
import tempfile
import threading
import time
import unittest

REPO = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(REPO / "src"), str(REPO / "tools" / "lib")]

import geometry_msgs.msg  # noqa: E402
import rospy  # noqa: E402
import simulated_robot  # noqa: E402
import std_msgs.msg  # noqa: E402
import std_srvs.srv  # noqa: E402
from sensor_msgs.msg import JointState  # noqa: E402
from trajectory_msgs.msg import JointTrajectory  # noqa: E402

import extperfc.arm  # noqa: E402
from extperfc.msg import ArmCode  # noqa: E402
from extperfc.robot_description import RobotDescription  # noqa: E402
from extperfc.srv import SetFault  # noqa: E402

MAX_SKEW_S = 0.01
AHEAD = (0.70, 0.25, 0.30, math.pi, 0.0, 0.0)  # the left gripper looks down, in the frame `base`


class ArmMoves(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        simulated_robot.launch(cls, "test_arm_moves", "sim_arm.launch", world="empty", markers="false", start_pose="neutral")
        cls.left, cls.both = (extperfc.arm.Arm(side, wait_s=60) for side in ("left", "both"))
        cls.right = extperfc.arm.Arm("right", wait_s=60)
        cls.left.joints  # noqa: B018  waits for the robot

    def setUp(self):
        simulated_robot.set_pace(simulated_robot.QUICK)
        self.left.scene.clear()
        self.enable()
        self.both.move_to("neutral", timeout=60)

    def real_time(self):
        """From here on reactions have the time that they have on a robot."""
        simulated_robot.set_pace(1.0)

    def enable(self):
        """Whatever the test before has left behind: in the end the robot moves."""
        enable = rospy.Publisher("robot/set_super_enable", std_msgs.msg.Bool, queue_size=1, latch=True)
        self.call(std_srvs.srv.Trigger, "arm/stop")
        deadline = time.monotonic() + 20
        while True:
            enable.publish(True)
            try:
                return self.left.move_to({"w2": 0.0}, timeout=20)
            except extperfc.arm.ArmError as error:
                if error.code not in (ArmCode.NO_JOINT_STATES, ArmCode.ROBOT_NOT_ENABLED, ArmCode.ROBOT_STOPPED):
                    raise
                if error.code == ArmCode.ROBOT_STOPPED:
                    rospy.Publisher("robot/set_super_reset", std_msgs.msg.Empty, queue_size=1, latch=True).publish()
                    time.sleep(0.3)
                self.assertLess(time.monotonic(), deadline, str(error))
                time.sleep(0.1)

    def call(self, service_type, name, **fields):
        rospy.wait_for_service(name, 20)
        return rospy.ServiceProxy(name, service_type)(**fields)

    def fails(self, code, what, *args, **options):
        """The call fails with the code and a message; returns it."""
        with self.assertRaises(extperfc.arm.ArmError) as caught:
            what(*args, **options)
        self.assertEqual(extperfc.arm.errors.NAMES[code], caught.exception.name, caught.exception.message)
        self.assertTrue(caught.exception.message)
        return caught.exception.message

    def tool(self):
        return self.left.tool_pose("base").pose.position

    def slow(self, goal="untuck", **options):
        """A motion of some seconds in real time that has begun."""
        self.real_time()
        motion = self.left.move_to(goal, wait=False, velocity_scale=0.15, **options)
        deadline = time.monotonic() + 20
        while motion.feedback is None or motion.feedback.executed < 0.1:
            self.assertFalse(motion.done)
            self.assertLess(time.monotonic(), deadline)
            time.sleep(0.01)
        return motion

    def stands(self):
        """Waits until the left arm does not move."""
        deadline = time.monotonic() + 10
        before = self.left.joints
        while True:
            time.sleep(0.3)
            now = self.left.joints
            if max(abs(now[name] - before[name]) for name in now) < 1e-3:
                return
            before = now
            self.assertLess(time.monotonic(), deadline, "the arm goes on")

    # What goes well.

    def test_named_states_of_one_arm_and_both(self):
        for state in ("untuck", "tuck", "neutral"):
            result = self.both.move_to(state, timeout=60)
            self.assertEqual(1.0, result.executed)
        self.assertAlmostEqual(0.75, self.left.joints["left_e1"], delta=0.02)

    def test_a_pose_of_the_tool(self):
        self.left.move_to(AHEAD, frame="base", timeout=60)
        time.sleep(0.2)
        for value, wanted in zip((self.tool().x, self.tool().y, self.tool().z), AHEAD):
            self.assertAlmostEqual(wanted, value, delta=0.01)

    def test_both_tools_at_once(self):
        mirrored = (AHEAD[0], -AHEAD[1]) + AHEAD[2:]
        self.both.move_to({"left": AHEAD, "right": mirrored}, frame="base", timeout=60)
        time.sleep(0.2)
        self.assertAlmostEqual(-AHEAD[1], self.right.tool_pose("base").pose.position.y, delta=0.01)

    def test_both_arms_move_at_the_same_time(self):
        """Both wrists turn by the same angle: what one is ahead of the other, over their speed, is the skew."""
        seen = []
        joints = rospy.Subscriber("robot/joint_states", JointState, seen.append)
        self.addCleanup(joints.unregister)
        self.real_time()
        self.both.move_to({"left_w2": 1.0, "right_w2": 1.0}, timeout=60)
        wrists = [(message.header.stamp.to_sec(), *(message.position[message.name.index(name)]
                                                    for name in ("left_w2", "right_w2"))) for message in seen]
        skews = []
        for (t0, left0, _), (t1, left, right) in zip(wrists, wrists[1:]):
            speed = (left - left0) / (t1 - t0) if t1 > t0 else 0.0
            if speed > 0.2:
                skews.append(abs(left - right) / speed)
        self.assertGreater(len(skews), 20)
        self.assertLess(max(skews), MAX_SKEW_S)

    def test_a_plan_is_shown_before_the_arm_moves(self):
        shown = []
        display = rospy.Subscriber("arm/display_trajectory", JointTrajectory,
                                   lambda message: shown.append((message, self.left.joints["left_w2"])))
        self.addCleanup(display.unregister)
        self.real_time()
        self.left.move_to({"w2": -0.7}, timeout=60)
        at_start = [where for message, where in shown
                    if abs(dict(zip(message.joint_names, message.points[-1].positions))["left_w2"] + 0.7) < 1e-3]
        self.assertEqual(1, len(at_start))
        self.assertGreater(at_start[0], -0.35, "it was shown when the motion was over")

    def test_a_straight_line(self):
        self.left.move_to(AHEAD, frame="base", timeout=60)
        down = AHEAD[:2] + (AHEAD[2] - 0.1,) + AHEAD[3:]
        plan = self.left.plan(down, frame="base", linear=True)
        self.assertEqual(1.0, plan.fraction)
        seen, done = [], threading.Event()

        def look():
            while not done.is_set():
                seen.append(self.tool())
                time.sleep(0.05)

        self.real_time()
        watcher = threading.Thread(target=look)
        watcher.start()
        try:
            self.left.execute(plan, timeout=60)
        finally:
            done.set()
            watcher.join()
        self.assertGreater(len(seen), 3)
        for place in seen:
            self.assertLess(math.hypot(place.x - AHEAD[0], place.y - AHEAD[1]), 0.01)

    def test_a_level_cup(self):
        self.left.move_to(AHEAD, frame="base", timeout=60)
        there = (AHEAD[0] - 0.05, AHEAD[1] + 0.25, AHEAD[2] + 0.1) + AHEAD[3:]
        plan = self.left.plan(there, frame="base", constraints=self.left.keep_level("base"))
        self.left.execute(plan, timeout=60)

    def test_a_plan_that_is_executed_later(self):
        plan = self.left.plan("untuck")
        self.assertGreater(plan.duration_s, 0.5)
        self.left.execute(plan, timeout=60)
        self.fails(ArmCode.START_MOVED, self.left.execute, plan)

    def test_things_are_avoided_and_carried(self):
        self.left.move_to(AHEAD, frame="base", timeout=60)
        self.left.scene.add_box("wall", (0.02, 0.02, 0.8), (0.7, 0.05, 0.3), frame="base")
        plan = self.left.plan((0.7, -0.12, 0.3) + AHEAD[3:], frame="base", planning_time=10.0)
        self.assertGreater(plan.duration_s, 0.3)
        self.left.scene.add_box("rod", (0.02, 0.02, 0.4), (0.0, 0.0, 0.15), frame="left_gripper")
        self.left.scene.attach("rod", "left_gripper", ("l_gripper_l_finger", "l_gripper_r_finger", "l_gripper_l_finger_tip",
                                                       "l_gripper_r_finger_tip", "left_gripper_base", "left_hand"))
        self.assertEqual("left_gripper", self.left.scene.objects["rod"].link)
        self.left.move_to("neutral", timeout=60)
        self.left.scene.detach("rod")
        self.assertEqual("", self.left.scene.objects["rod"].link)

    def test_meshes_count_as_their_hulls(self):
        joints = self.left.solve_ik(AHEAD, frame="base")
        corners = [(x, y, z) for x in (-0.05, 0.05) for y in (-0.05, 0.05) for z in (-0.05, 0.05)]
        sides = [(0, 1, 3), (4, 5, 7), (0, 1, 5), (2, 3, 7)]  # a box that is open on two sides
        with tempfile.NamedTemporaryFile("w", suffix=".obj") as file:
            file.writelines(f"v {x} {y} {z}\n" for x, y, z in corners)
            file.writelines(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in sides)
            file.flush()
            self.left.scene.add_mesh("vase", file.name, (AHEAD[0], AHEAD[1], AHEAD[2] + 1.0), frame="base", label="vase")
            self.assertTrue(self.left.check(joints).free)
            self.left.scene.add_mesh("vase", file.name, AHEAD[:3], frame="base", label="vase")
        found = self.left.check(joints)
        self.assertFalse(found.free)
        self.assertIn("vase", (found.first, found.second))
        self.assertEqual(4, len(self.left.scene.objects["vase"].meshes[0].triangles))
        self.fails(ArmCode.NO_GRASP, self.left.pick, "vase")

    def test_inverse_kinematics_and_states(self):
        joints = self.left.solve_ik(AHEAD, frame="base")
        self.assertEqual(7, len(joints))
        self.assertTrue(self.left.check(joints).free)
        self.left.scene.add_box("block", (0.1, 0.1, 0.1), AHEAD[:3], frame="base")
        found = self.left.check(joints)
        self.assertFalse(found.free)
        self.assertIn("block", (found.first, found.second))
        self.assertLess(found.distance, 0.0)
        self.fails(ArmCode.GOAL_IN_COLLISION, self.left.solve_ik, AHEAD, frame="base")

    def test_jogging(self):
        self.left.move_to(AHEAD, frame="base", timeout=60)
        before = self.tool()
        self.real_time()
        self.left.jog(twist=(0.0, 0.0, -0.05, 0.0, 0.0, 0.0), frame="base", duration=1.0)
        self.stands()
        self.assertLess(self.tool().z, before.z - 0.02)
        self.assertAlmostEqual(before.x, self.tool().x, delta=0.01)
        before = self.left.joints
        self.left.jog(joints={"w2": 0.3}, duration=1.0)
        self.stands()
        self.assertGreater(self.left.joints["left_w2"], before["left_w2"] + 0.1)
        # A plate below: the hand stops before it.
        simulated_robot.set_pace(simulated_robot.QUICK)
        self.left.move_to(AHEAD, frame="base", timeout=60)
        self.real_time()
        self.left.scene.add_box("plate", (0.4, 0.4, 0.02), (AHEAD[0], AHEAD[1], AHEAD[2] - 0.08), frame="base")
        self.left.jog(twist=(0.0, 0.0, -0.1, 0.0, 0.0, 0.0), frame="base", duration=2.5)
        self.stands()
        self.assertTrue(self.left.check().free)
        self.assertLess(self.tool().z, AHEAD[2] - 0.03)

    # Bad input.

    def test_goals_that_make_no_sense(self):
        move = self.left.move_to
        self.fails(ArmCode.GOAL_UNREACHABLE, move, (3.0, 0.0, 0.3), frame="base")
        self.fails(ArmCode.UNKNOWN_FRAME, move, (0.5, 0.0, 0.3, 0, 0, 0), frame="atlantis")
        self.fails(ArmCode.GOAL_OUTSIDE_LIMITS, move, {"s0": 3.0})
        nowhere = geometry_msgs.msg.PoseStamped()
        nowhere.header.frame_id = "base"
        nowhere.pose.position.x = math.nan
        nowhere.pose.orientation.w = 1.0
        request = extperfc.msg.MoveArmGoal()
        request.request.group = "left_arm"
        request.request.tool_goals = [extperfc.msg.ToolGoal(pose=nowhere)]
        send = lambda: self.left._move(request, True, 20)  # noqa: E731  past the client's own checks
        self.assertIn("not finite", self.fails(ArmCode.INVALID_REQUEST, send))
        request.request = extperfc.msg.ArmRequest(group="tail", named_state="neutral")
        self.assertIn("left_arm", self.fails(ArmCode.INVALID_REQUEST, send))
        request.request = extperfc.msg.ArmRequest(group="left_arm")
        self.assertIn("0 goals", self.fails(ArmCode.INVALID_REQUEST, send))
        request.request.named_state = "yoga"
        self.assertIn("neutral", self.fails(ArmCode.INVALID_REQUEST, send))

    def test_collisions_at_the_ends(self):
        self.left.scene.add_box("block", (0.1, 0.1, 0.1), AHEAD[:3], frame="base")
        self.assertIn("block", self.fails(ArmCode.GOAL_IN_COLLISION, self.left.move_to, AHEAD, frame="base"))
        self.left.scene.add_box("block", (0.1, 0.1, 0.1), (0.0, 0.0, 0.0), frame="left_gripper")
        self.assertIn("block", self.fails(ArmCode.START_IN_COLLISION, self.left.move_to, "untuck"))

    def test_objects_that_make_no_sense(self):
        scene = self.left.scene
        self.fails(ArmCode.INVALID_REQUEST, scene.remove, "ghost")
        self.fails(ArmCode.INVALID_REQUEST, scene.attach, "ghost", "left_gripper")
        self.fails(ArmCode.INVALID_REQUEST, scene.add_box, "left_gripper", (1, 1, 1), (0, 0, 0))
        scene.add_box("kept", (0.1, 0.1, 0.1), (2, 0, 0))
        self.fails(ArmCode.INVALID_REQUEST, scene.add_box, "lost", (0.1, 0.1, 0.1), (2, 0, 0), frame="atlantis")
        self.fails(ArmCode.INVALID_REQUEST, scene.attach, "kept", "third_hand")
        self.assertEqual(["kept"], list(scene.objects))

    # What goes wrong on the way.

    def test_something_comes_into_the_way(self):
        goal = self.left.solve_ik(AHEAD, frame="base")
        motion = self.slow({name[5:]: value for name, value in goal.items()}, replans=0)
        self.left.scene.add_box("block", (0.15, 0.15, 0.15), AHEAD[:3], frame="base")
        self.assertIn("block", self.fails(ArmCode.PATH_BLOCKED, motion.wait, 20))
        self.stands()
        self.assertTrue(self.left.check().free)

    def test_another_way_is_found(self):
        # From one side of a place to the other; then a post stands where the hand would come along.
        robot = RobotDescription.from_file(REPO / "urdf" / "mobile_baxter.urdf")
        left, right = (0.62, 0.55, 0.25) + AHEAD[3:], (0.62, 0.0, 0.25) + AHEAD[3:]
        self.left.move_to(left, frame="base", timeout=60)
        plan = self.left.plan(right, frame="base")
        middle = dict(zip(plan.trajectory.joint_names, plan.trajectory.points[len(plan.trajectory.points) // 2].positions))
        x, y, z = robot.link_poses(middle, frame="base")["left_gripper"][:3, 3]
        self.real_time()
        motion = self.left.move_to(right, frame="base", wait=False, velocity_scale=0.1, replans=3, planning_time=10.0)
        while motion.feedback is None or motion.feedback.executed < 0.05:
            time.sleep(0.01)
        self.left.scene.add_box("post", (0.1, 0.1, 0.2), (x, y, z), frame="base")
        deadline = time.monotonic() + 90
        while motion.feedback.stage == "executing" and not motion.done and time.monotonic() < deadline:
            time.sleep(0.01)
        simulated_robot.set_pace(simulated_robot.QUICK)
        result = motion.wait(90)
        self.assertGreaterEqual(result.replans, 1)
        self.assertEqual(1.0, result.executed)

    def test_emergency_stop(self):
        motion = self.slow()
        rospy.Publisher("robot/set_super_stop", std_msgs.msg.Empty, queue_size=1, latch=True).publish()
        self.fails(ArmCode.ROBOT_STOPPED, motion.wait, 20)
        self.stands()
        self.fails(ArmCode.ROBOT_STOPPED, self.left.move_to, "neutral")

    def test_not_enabled(self):
        motion = self.slow()
        rospy.Publisher("robot/set_super_enable", std_msgs.msg.Bool, queue_size=1, latch=True).publish(False)
        self.fails(ArmCode.ROBOT_NOT_ENABLED, motion.wait, 20)

    def test_a_joint_that_does_not_follow(self):
        self.call(SetFault, "sim/set_fault", kind="joint_stuck", target="left_s1", value=0.0, duration_s=0.0)
        try:
            self.fails(ArmCode.NOT_FOLLOWING, self.left.move_to, "tuck", timeout=60)
            self.stands()
        finally:
            self.call(SetFault, "sim/set_fault", kind="none", target="", value=0.0, duration_s=0.0)

    def test_two_goals_at_once(self):
        first = self.slow()
        second = self.right.move_to("untuck", timeout=60)
        self.assertEqual(1.0, second.executed)
        self.fails(ArmCode.PREEMPTED, first.wait, 20)

    def test_cancel_and_stop(self):
        motion = self.slow()
        motion.cancel()
        self.fails(ArmCode.CANCELLED, motion.wait, 20)
        self.stands()
        motion = self.slow("neutral")
        self.left.stop()
        self.fails(ArmCode.CANCELLED, motion.wait, 20)
        self.stands()


if __name__ == "__main__":
    unittest.main()

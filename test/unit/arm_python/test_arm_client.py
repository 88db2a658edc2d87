"""The Python client of the arm node, with servers that are not there."""

import gc
import threading
import types
import unittest
from unittest import mock

import rospy
from actionlib import CommState
from actionlib_msgs.msg import GoalStatus
from control_msgs.msg import GripperCommandResult
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

import extperfc.srv
from extperfc import robot_description as rd
from extperfc.arm import client, connection, hands, robot_state
from extperfc.arm.errors import ArmError, ClientCode
from extperfc.msg import ArmCode, MoveArmResult, PickResult, PlanResult, SceneObject


class FakeHandle:
    """A goal of an action client."""

    def __init__(self, result=None, state=GoalStatus.SUCCEEDED, text=""):
        self.result, self.state, self.text, self.cancelled = result, state, text, False
        self.comm_state = CommState.ACTIVE

    def get_comm_state(self):
        return self.comm_state

    def get_result(self):
        return self.result

    def get_terminal_state(self):
        return self.state

    def get_goal_status_text(self):
        return self.text

    def cancel(self):
        self.cancelled = True


def ended(result=None, state=GoalStatus.SUCCEEDED, text=""):
    """A motion that has ended so."""
    motion = connection.Motion()
    handle = FakeHandle(result, state, text)
    motion.started(handle)
    handle.comm_state = CommState.DONE
    motion.on_transition(handle)
    return motion


class Motions(unittest.TestCase):
    def tearDown(self):
        connection._motions.clear()

    def started(self, connected=lambda: True):
        motion, handle = connection.Motion(connected), FakeHandle(MoveArmResult())
        motion.started(handle)
        return motion, handle

    def finish(self, motion, handle):
        handle.comm_state = CommState.DONE
        motion.on_transition(handle)

    def test_success(self):
        result = MoveArmResult(executed=1.0)
        self.assertIs(result, ended(result).wait())

    def test_what_the_node_says_is_raised(self):
        result = MoveArmResult(code=ArmCode.GOAL_IN_COLLISION, message="left_hand touches table")
        with self.assertRaises(ArmError) as caught:
            ended(result, GoalStatus.ABORTED).wait()
        error = caught.exception
        self.assertEqual((5, "GOAL_IN_COLLISION", "left_hand touches table"), (error.code, error.name, error.message))
        self.assertEqual("GOAL_IN_COLLISION: left_hand touches table", str(error))
        self.assertIs(result, error.result)

    def test_an_empty_result_of_a_refused_goal_is_no_success(self):
        for result, state, name in ((MoveArmResult(), GoalStatus.REJECTED, "REJECTED"), (None, GoalStatus.LOST, "REJECTED"),
                                    (MoveArmResult(), GoalStatus.PREEMPTED, "CANCELLED"),
                                    (MoveArmResult(), GoalStatus.RECALLED, "CANCELLED")):
            with self.assertRaises(ArmError) as caught:
                ended(result, state, "no").wait()
            self.assertEqual((name, "no"), (caught.exception.name, caught.exception.message))

    def test_timeout_cancels(self):
        motion, handle = self.started()
        with mock.patch.object(connection, "STOP_S", 0.0), self.assertRaises(ArmError) as caught:
            motion.wait(timeout=0.06)
        self.assertEqual(ClientCode.TIMEOUT, caught.exception.code)
        self.assertTrue(handle.cancelled)

    def test_ctrl_c_cancels(self):
        def interrupt():
            raise KeyboardInterrupt
        motion, handle = self.started(interrupt)
        with mock.patch.object(connection, "STOP_S", 0.0), self.assertRaises(KeyboardInterrupt):
            motion.wait()
        self.assertTrue(handle.cancelled)

    def test_a_node_that_goes_away_is_noticed(self):
        motion, _ = self.started(lambda: False)
        with mock.patch.object(connection, "LOST_S", 0.0), self.assertRaises(ArmError) as caught:
            motion.wait()
        self.assertEqual("CONNECTION_LOST", caught.exception.name)

    def test_a_result_that_never_comes_is_noticed(self):
        motion, handle = self.started()
        handle.comm_state = CommState.WAITING_FOR_RESULT
        with mock.patch.object(connection, "RESULT_S", 0.0), self.assertRaisesRegex(ArmError, "CONNECTION_LOST"):
            motion.wait()

    def test_the_end_of_the_program_cancels_what_still_moves(self):
        moving, handle = self.started()
        done, done_handle = self.started()
        self.finish(done, done_handle)
        connection._cancel_all()
        self.assertEqual((True, False), (handle.cancelled, done_handle.cancelled))
        self.finish(moving, handle)

    def test_a_goal_is_cancelled_when_it_is_acknowledged(self):
        motion, handle = self.started()
        handle.comm_state = CommState.WAITING_FOR_GOAL_ACK
        motion.cancel()
        self.assertFalse(handle.cancelled)
        handle.comm_state = CommState.PENDING
        motion.on_transition(handle)
        self.assertTrue(handle.cancelled)
        self.finish(motion, handle)

    def test_a_motion_that_nobody_holds_is_cancelled_at_the_end(self):
        handle = FakeHandle(MoveArmResult())
        connection.Motion().started(handle)
        gc.collect()
        connection._cancel_all()
        self.assertTrue(handle.cancelled)

    def test_waiting_in_one_thread_and_ending_in_another(self):
        motion, handle = self.started()
        heard = []
        motion.when_done(heard.append)
        timer = threading.Timer(0.05, self.finish, (motion, handle))
        timer.start()
        motion.wait(timeout=30)
        timer.join()
        motion.when_done(heard.append)  # at once
        self.assertEqual([motion, motion], heard)

    def test_no_result_before_the_end(self):
        motion, handle = self.started()
        with self.assertRaises(ArmError):
            motion.result()
        self.finish(motion, handle)


class Names(unittest.TestCase):
    URDF = """<robot name="r"><link name="chassis"/><link name="mast"/><link name="tip"/><link name="finger"/>
        <joint name="lift" type="prismatic"><parent link="chassis"/><child link="mast"/><axis xyz="0 0 1"/>
          <limit lower="0" upper="1" effort="1" velocity="1"/></joint>
        <joint name="arm_roll" type="continuous"><parent link="mast"/><child link="tip"/><axis xyz="1 0 0"/></joint>
        <joint name="pinch" type="prismatic"><parent link="tip"/><child link="finger"/><axis xyz="0 1 0"/>
          <limit lower="0" upper="0.04" effort="1" velocity="1"/></joint></robot>"""
    GRIPPERS = [{"name": "arm", "group": "arm", "tip": "tip", "finger_joint": "pinch", "action": "hand/move"}]

    def test_the_node_and_the_description_say_what_there_is(self):
        found = hands.from_parameters(self.GRIPPERS, self.URDF)
        self.assertEqual(("arm", ("lift", "arm_roll"), "chassis"), (*found.names, found["arm"].joints, found.frame))
        self.assertEqual("arm", found.group("both"), "of one arm there is no group of both")
        self.assertEqual(["arm_roll", "lift", "pinch"], [found.full_name(joint, "arm") for joint in ("roll", "lift", "pinch")])
        self.assertEqual((), hands.from_parameters(self.GRIPPERS, "")["arm"].joints)

    def test_the_description_may_stand_in_a_namespace_above(self):
        for there in ("/lab/first/robot_description", "/lab/robot_description", "/robot_description"):
            parameters = {there: self.URDF, "/lab/first/arm/grippers": self.GRIPPERS}
            with mock.patch.multiple(rospy, has_param=parameters.__contains__, resolve_name=lambda name: f"/lab/{name}",
                                     get_param=lambda name, default=None, known=parameters: known.get(f"/lab/{name}", known.get(name, default))), \
                    mock.patch.dict(hands._known, clear=True):
                self.assertEqual(("lift", "arm_roll"), hands.of("first")["arm"].joints, there)

    def test_a_joint_that_several_arms_have_needs_its_arm(self):
        self.assertEqual("both_arms", hands.BAXTER.group("both"))
        with self.assertRaisesRegex(ValueError, "left_s0 or right_s0"):
            hands.BAXTER.full_name("s0", "both")
        with self.assertRaisesRegex(ValueError, "must be left or right or both"):
            hands.BAXTER.named("middle")


class FakeServers:
    """Actions and services by name: `answers` holds what they answer, `asked` what they were asked."""

    def __init__(self):
        self.answers, self.asked = {}, []

    def action(self, _namespace, name, _type, *_, **__):
        def send(goal):
            self.asked.append((name, goal))
            return ended(*self.answers[name])
        return types.SimpleNamespace(send=send)

    def service(self, _namespace, name, _type, *_):
        def call(**fields):
            self.asked.append((name, fields))
            return self.answers[name]
        return call


class Arms(unittest.TestCase):
    def setUp(self):
        self.servers, self.hands = FakeServers(), hands.BAXTER
        self.joints = robot_state.JointListener.__new__(robot_state.JointListener)
        self.joints._positions, self.joints._heard, self.joints.topic = {}, threading.Condition(), "/joint_states"
        self.rotation = rd.rotation_of_rpy(0, 1.5707963267948966, 0)
        frames = types.SimpleNamespace(rotation=lambda *_: self.rotation)
        for owner, name, fake in ((connection, "ensure_node", lambda: None), (connection, "Action", self.servers.action),
                                  (connection, "Service", self.servers.service), (robot_state, "joints", lambda _: self.joints),
                                  (robot_state, "frames", lambda: frames), (hands, "of", lambda namespace="": self.hands)):
            patch = mock.patch.object(owner, name, fake)
            patch.start()
            self.addCleanup(patch.stop)

    def test_no_arm(self):
        with self.assertRaisesRegex(ArmError, "middle"):
            client.Arm("middle", wait_s=0.0)
        self.hands = hands.Hands([hands.BAXTER["left"]], "base")
        with self.assertRaisesRegex(ValueError, "must be left$"):
            client.Arm("middle")

    def test_a_robot_with_one_arm(self):
        tool = hands.Hand("claw", "manipulator", "claw_tip", "claw/move", ("lift", "claw_roll"))
        self.hands = hands.Hands([tool], "chassis")
        self.servers.answers["move_arm"] = (MoveArmResult(),)
        client.Arm("both").move_to((0.3, 0.0, 0.5, 0.0, 0.0, 0.0))
        asked = self.servers.asked[-1][1].request
        self.assertEqual(("manipulator", "claw_tip", "chassis"),
                         (asked.group, asked.tool_goals[0].link, asked.tool_goals[0].pose.header.frame_id))
        client.Arm("claw").move_to({"roll": 0.5, "lift": 0.1})
        self.assertEqual(["claw_roll", "lift"], self.servers.asked[-1][1].request.joint_goal.name)
        self.servers.answers["claw/move"] = (GripperCommandResult(stalled=True, position=40.0),)
        self.assertTrue(client.Arm("both").close())
        self.servers.answers["pick"] = (PickResult(object="can"),)
        client.Arm("claw").pick("can", place_at=(0.3, 0.1, 0.2))
        self.assertEqual(("claw", "chassis"), (self.servers.asked[-1][1].arm, self.servers.asked[-1][1].place_at[0].header.frame_id))

    def test_move(self):
        self.servers.answers["move_arm"] = (MoveArmResult(executed=1.0),)
        result = client.Arm("left").move_to((0.7, 0.3, 0.1), linear=True, replans=1, velocity_scale=0.3)
        (name, goal), = self.servers.asked
        self.assertEqual(("move_arm", "left_arm", 1, 0.3, 1), (
            name, goal.request.group, goal.request.motion, goal.request.velocity_scale, goal.replans))
        self.assertEqual(1.0, result.executed)

    def test_move_without_waiting(self):
        self.servers.answers["move_arm"] = (MoveArmResult(code=ArmCode.PATH_BLOCKED),)
        motion = client.Arm("both").tuck(wait=False)
        self.assertTrue(motion.done)
        self.assertEqual("tuck", self.servers.asked[0][1].request.named_state)
        with self.assertRaises(ArmError):
            motion.wait()

    def test_plan_then_execute(self):
        trajectory = JointTrajectory(joint_names=["left_s0"], points=[
            JointTrajectoryPoint(positions=[0.0]), JointTrajectoryPoint(positions=[1.0], time_from_start=rospy.Duration(2.5))])
        self.servers.answers["plan"] = (PlanResult(trajectory=trajectory, fraction=1.0, planning_time=0.01, message="good"),)
        self.servers.answers["move_arm"] = (MoveArmResult(),)
        arm = client.Arm("left")
        plan = arm.plan({"s0": 1.0}, start={"s0": 0.0})
        self.assertEqual((2.5, 1.0, 0.01, "good"), (plan.duration_s, plan.fraction, plan.planning_time_s, plan.message))
        self.assertEqual(["left_s0"], self.servers.asked[0][1].request.start.name)
        arm.execute(plan)
        self.assertEqual(trajectory, self.servers.asked[1][1].trajectory)
        with self.assertRaises(ValueError):
            arm.execute(JointTrajectory())

    def test_pick_and_place(self):
        self.servers.answers["pick"] = (PickResult(object="cube_1", arm="right"),)
        self.assertEqual("cube_1", client.Arm("both").pick("cube", lift=0.1).object)
        self.assertEqual(("cube", "", 0.1), (lambda g: (g.object, g.arm, g.lift))(self.servers.asked[0][1]))
        self.servers.answers["place"] = (types.SimpleNamespace(code=ArmCode.NOTHING_HELD, message="the gripper is empty"),)
        with self.assertRaisesRegex(ArmError, "NOTHING_HELD: the gripper is empty"):
            client.Arm("right").place((0.7, -0.3, 0), frame="torso")
        goal = self.servers.asked[1][1]
        self.assertEqual(("right", "torso", True), (goal.arm, goal.pose.header.frame_id, goal.any_yaw))

    def test_stop(self):
        self.servers.answers["arm/stop"] = types.SimpleNamespace(success=True, message="")
        client.Arm("left").stop()
        self.servers.answers["arm/stop"] = types.SimpleNamespace(success=False, message="jammed")
        with self.assertRaisesRegex(ArmError, "jammed"):
            client.Arm("left").stop()

    def test_grippers(self):
        left, right = (f"robot/end_effector/{side}_gripper/gripper_action" for side in ("left", "right"))
        self.servers.answers[left] = (GripperCommandResult(stalled=False, reached_goal=True),)
        self.servers.answers[right] = (GripperCommandResult(stalled=True, position=40.0),)
        self.assertEqual((False, True, True), tuple(client.Arm(side).close() for side in ("left", "right", "both")))
        self.assertEqual(4, len(self.servers.asked))  # both of both
        self.servers.answers[right] = (GripperCommandResult(stalled=True, position=0.0),)  # its fingers press on each other
        self.assertFalse(client.Arm("right").close())
        client.Arm("left").open(40)
        self.assertEqual((left, 40.0), (self.servers.asked[-1][0], self.servers.asked[-1][1].command.position))
        self.servers.answers[left] = (GripperCommandResult(), GoalStatus.ABORTED, "a finger is stuck")
        with self.assertRaisesRegex(ArmError, "GRIPPER_FAILED: left gripper: a finger is stuck"):
            client.Arm("left").open()
        with self.assertRaises(ValueError):
            client.Arm("left").open(101)

    def test_joints(self):
        self.joints.on_message(JointState(name=["left_s0", "head_pan"], position=[1.0, 2.0]))
        self.joints.on_message(JointState(name=["right_s0", "left_s0"], position=[3.0, 4.0]))
        self.assertEqual({"left_s0": 4.0}, client.Arm("left").joints)
        self.assertEqual({"left_s0": 4.0, "right_s0": 3.0}, client.Arm("both").joints)

    def test_no_joints(self):
        with self.assertRaises(ArmError) as caught:
            client.Arm("left", wait_s=0.01).joints
        self.assertEqual("NO_JOINT_STATES", caught.exception.name)

    def test_ik_and_check(self):
        arm = client.Arm("left")
        answer = extperfc.srv.SolveArmIkResponse(joints=JointState(name=["left_s0"], position=[0.5]))
        self.servers.answers["arm/solve_ik"] = answer
        self.assertEqual({"left_s0": 0.5}, arm.solve_ik((0.7, 0.3, 0.1), seed={"s0": 0}))
        fields = self.servers.asked[-1][1]
        self.assertEqual(("left_arm", "left_gripper", ["left_s0"]), (fields["group"], fields["goal"].link, fields["seed"].name))
        answer.code, answer.message = ArmCode.GOAL_UNREACHABLE, "0.2 m too far"
        with self.assertRaisesRegex(ArmError, "GOAL_UNREACHABLE: 0.2 m too far"):
            arm.solve_ik((3, 0, 0))
        self.servers.answers["arm/check_state"] = extperfc.srv.CheckArmStateResponse(
            code=ArmCode.START_IN_COLLISION, first="left_hand", second="table", distance=-0.01)
        found = arm.check({"s0": 0})
        self.assertEqual((False, "left_hand", "table", -0.01), (found.free, found.first, found.second, found.distance))

    def test_keep_level_is_the_vertical_in_the_hand(self):
        """The tool is turned by 90 degrees about y: base's z is its -x."""
        kept = client.Arm("both").keep_level()
        self.assertEqual(["left_gripper", "right_gripper"], [one.link for one in kept])
        for value, expected in zip((kept[0].axis.x, kept[0].axis.y, kept[0].axis.z), (-1, 0, 0)):
            self.assertAlmostEqual(expected, value)

    def test_jog_needs_one_arm_and_one_command(self):
        with self.assertRaises(ValueError):
            client.Arm("both").jog(joints={"left_s0": 0.1})
        for wrong in ({}, {"twist": (0,) * 6, "joints": {"s0": 0.1}}):
            with self.assertRaises(ValueError):
                client.Arm("left").jog(**wrong)

    def test_jog_repeats_and_stops(self):
        sent = []
        listener = types.SimpleNamespace(get_num_connections=lambda: 1, publish=lambda m: sent.append(
            (list(m.joint_names), list(m.velocities))))
        now = mock.patch.object(rospy.Time, "now", lambda: rospy.Time(1))
        with mock.patch.object(rospy, "Publisher", lambda *_, **__: listener), now:
            client.Arm("left").jog(joints={"s0": 0.1}, duration=0.05)
        self.assertGreaterEqual(len(sent), 2)
        self.assertEqual(((["left_s0"], [0.1]), (["left_s0"], [0.0])), (sent[0], sent[-1]))

    def test_scene(self):
        scene = client.Arm("left").scene
        self.servers.answers["arm/apply_scene"] = types.SimpleNamespace(success=True, message="")
        scene.add_box("table", (0.8, 1.2, 0.04), (0.9, 0, -0.2), label="furniture")
        made, = self.servers.asked[-1][1]["objects"]
        self.assertEqual((SceneObject.ADD, "table", "furniture", "base", [0.8, 1.2, 0.04]), (
            made.operation, made.name, made.label, made.pose.header.frame_id, made.primitives[0].dimensions))
        scene.add_cone("cone", 0.1, 0.3, (1, 0, 0))
        made, = self.servers.asked[-1][1]["objects"]
        primitive = made.primitives[0]
        self.assertEqual((0.3, 0.1), (primitive.dimensions[primitive.CONE_HEIGHT], primitive.dimensions[primitive.CONE_RADIUS]))
        scene.attach("cone", "left_gripper", ["l_gripper_l_finger"])
        made, = self.servers.asked[-1][1]["objects"]
        self.assertEqual((SceneObject.ATTACH, "left_gripper"), (made.operation, made.link))
        scene.clear()
        self.assertEqual("", self.servers.asked[-1][1]["objects"][0].name)
        asked = len(self.servers.asked)
        for wrong in (lambda: scene.remove(""), lambda: scene.add_sphere("ball", 0.0, (0, 0, 0)),
                      lambda: scene.add_box("box", (1, 2), (0, 0, 0)), lambda: scene.add_box("", (1, 1, 1), (0, 0, 0))):
            with self.assertRaises(ValueError):
                wrong()
        self.assertEqual(asked, len(self.servers.asked))

    def test_a_scene_that_is_refused(self):
        scene = client.Arm("left").scene
        self.servers.answers["arm/apply_scene"] = types.SimpleNamespace(success=False, message="no frame nowhere")
        with self.assertRaisesRegex(ArmError, "no frame nowhere"):
            scene.add_sphere("ball", 0.1, (0, 0, 0), frame="nowhere")
        self.servers.answers["arm/get_scene"] = extperfc.srv.GetSceneResponse(objects=[SceneObject(name="ball")])
        self.assertEqual(["ball"], list(scene.objects))


class Errors(unittest.TestCase):
    def test_every_code_has_its_name(self):
        self.assertEqual("GOAL_UNREACHABLE", ArmError(ArmCode.GOAL_UNREACHABLE, "").name)
        self.assertEqual("NOT_RUNNING", ArmError(ClientCode.NOT_RUNNING, "").name)
        self.assertEqual("CODE_1234", ArmError(1234, "").name)


if __name__ == "__main__":
    unittest.main()

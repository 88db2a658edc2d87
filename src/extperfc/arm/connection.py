"""Connections to the node: actions and services that wait for it, motions that end with the program."""

import signal
import sys
import threading
import time

import actionlib
import rosgraph
import rospy
from actionlib_msgs.msg import GoalStatus

from extperfc.arm.errors import ArmError, ClientCode
from extperfc.msg import ArmCode

WAIT_S = 5.0                # for a node to answer, in real time
STOP_S = 2.0                # for a cancelled motion to end
LOST_S = 2.0                # without a connection: the node is gone
RESULT_S = 5.0              # between an action's last status and its result
SETTLE_S = 0.05             # a server uses a connection a little after it said so
UNNAMED = "unknown"         # rospy's name for a caller that it has not met yet
LEAVE_S = 0.2               # for a cancellation to leave the process
START = "is the arm node running (roslaunch extperfc arm.launch)?"

_motions = set()            # active; referenced here, since a caller may drop a motion that still moves
_hook_set = False


def _cancel_all():
    """Cancels all motions when the program ends."""
    moving = [motion for motion in list(_motions) if not motion.done]
    for motion in moving:
        motion.cancel(at_once=True)
    if moving:
        time.sleep(LEAVE_S)  # messages leave in another thread


def _end_on_signals():
    """Signals that would kill the process at once, e.g. of a closed terminal, end it in order: what moves is cancelled."""
    if threading.current_thread() is not threading.main_thread():
        return  # Python sets handlers there alone
    for number in (signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) == signal.SIG_DFL:
            signal.signal(number, lambda received, _frame: sys.exit(128 + received))


def ensure_node(name="arm_client"):
    """Makes this process a ROS node if it is not one yet. Raises ArmError where there is no master."""
    global _hook_set
    if not rospy.core.is_initialized():
        if not rosgraph.is_master_online():
            raise ArmError(ClientCode.NOT_RUNNING, f"no ROS master at {rosgraph.get_master_uri()}")
        # Ctrl-C stays Python's own: it ends a motion, not the node.
        rospy.init_node(name, anonymous=True, disable_signals=True)
    if not _hook_set:
        rospy.on_shutdown(_cancel_all)
        _end_on_signals()
        _hook_set = True


def join(namespace, name):
    return f"{namespace.rstrip('/')}/{name}" if namespace else name


class Service:
    """A service; the first call waits for it, and so does the one after a failure. Raises ArmError."""

    def __init__(self, namespace, name, service_type, wait_s=WAIT_S):
        self._name, self._type, self._wait_s, self._proxy = join(namespace, name), service_type, wait_s, None

    def __call__(self, **fields):
        name = rospy.resolve_name(self._name)
        try:
            if self._proxy is None:
                rospy.wait_for_service(name, timeout=self._wait_s)
                self._proxy = rospy.ServiceProxy(name, self._type)
            return self._proxy(**fields)
        except rospy.ServiceException as error:
            self._proxy = None
            raise ArmError(ClientCode.CONNECTION_LOST, f"{name} ended without an answer: {error}") from None
        except rospy.ROSException:
            self._proxy = None
            raise ArmError(ClientCode.NOT_RUNNING, f"no service {name} after {self._wait_s:g} s: {START}") from None


class Motion:
    """An active goal. It is cancelled when the program ends."""

    def __init__(self, connected=lambda: True):
        self._connected, self._handle, self._ended, self.feedback = connected, None, threading.Event(), None
        self._callbacks, self._lock, self._cancel_wanted = [], threading.Lock(), False
        _motions.add(self)

    def started(self, handle):
        self._handle = handle

    def on_transition(self, handle):
        """Called by the action client, in its thread."""
        self._handle = handle
        state = handle.get_comm_state()
        if state == actionlib.CommState.DONE:
            _motions.discard(self)
            with self._lock:
                self._ended.set()
                callbacks, self._callbacks = self._callbacks, []
            for call in callbacks:
                call(self)
        elif self._cancel_wanted and state != actionlib.CommState.WAITING_FOR_GOAL_ACK:
            self._cancel_wanted = False
            handle.cancel()

    def on_feedback(self, _handle, feedback):
        self.feedback = feedback

    def when_done(self, call):
        """call(motion), in another thread, when it has ended; at once if it has."""
        with self._lock:
            if not self._ended.is_set():
                self._callbacks.append(call)
                return
        call(self)

    @property
    def done(self):
        return self._ended.is_set()

    def cancel(self, at_once=False):
        """Asks the node to stop; returns without waiting for it.

        A goal that was not acknowledged yet is cancelled when it is: the action client takes a goal for lost that it
        has cancelled and does not find in the next status. at_once does without, for programs that end.
        """
        if self._handle is None or self.done:
            return
        self._cancel_wanted = True
        if at_once or self._handle.get_comm_state() != actionlib.CommState.WAITING_FOR_GOAL_ACK:
            self._cancel_wanted = False
            self._handle.cancel()

    def wait(self, timeout=None):
        """Waits for the end and returns the action's result. timeout: in seconds of real time; None: unlimited.

        Raises ArmError: what the node said, or TIMEOUT, after which the motion was cancelled. Ctrl-C cancels too.
        """
        try:
            self._await(None if timeout is None else time.monotonic() + timeout, timeout)
        except KeyboardInterrupt:
            self.cancel()
            self._ended.wait(STOP_S)
            raise
        return self.result()

    def _await(self, deadline, timeout):
        last_connected = last_moving = time.monotonic()
        while not self._ended.wait(0.05):
            now = time.monotonic()
            if self._connected():
                last_connected = now
            elif now > last_connected + LOST_S:
                _motions.discard(self)
                raise ArmError(ClientCode.CONNECTION_LOST, "connection to the arm node lost")
            if self._handle.get_comm_state() != actionlib.CommState.WAITING_FOR_RESULT:
                last_moving = now
            elif now > last_moving + RESULT_S:
                _motions.discard(self)
                raise ArmError(ClientCode.CONNECTION_LOST, "the motion ended, but its result was lost")
            if rospy.is_shutdown():
                raise ArmError(ClientCode.CONNECTION_LOST, "this program's ROS node has shut down")
            if deadline is not None and now > deadline:
                self.cancel()
                self._ended.wait(STOP_S)
                raise ArmError(ClientCode.TIMEOUT, f"not done after {timeout:g} s; cancelled")

    def result(self):
        """The action's result. Raises ArmError if the motion failed or is not finished."""
        if not self.done:
            raise ArmError(ClientCode.TIMEOUT, "not finished yet")
        result, state = self._handle.get_result(), self._handle.get_terminal_state()
        code = getattr(result, "code", 0)
        if result is None or (code == 0 and state != GoalStatus.SUCCEEDED):
            # A goal that was refused or lost comes back with an empty result, whose code is 0.
            recalled = state in (GoalStatus.RECALLED, GoalStatus.PREEMPTED)
            raise ArmError(ArmCode.CANCELLED if recalled else ClientCode.REJECTED, self._handle.get_goal_status_text() or
                           f"the goal ended as {GoalStatus.to_string(state)}", result)
        if code != 0:
            raise ArmError(code, result.message, result)
        return result


class Action:
    """An action; goals wait for its server. Raises ArmError."""

    def __init__(self, namespace, name, action_type, wait_s=WAIT_S, start=START):
        self._name, self._wait_s, self._start = rospy.resolve_name(join(namespace, name)), wait_s, start
        self._client, self._settled = actionlib.ActionClient(self._name, action_type), False

    def connected(self):
        """Counted in connections, since the status comes by simulated time, which may stand still. One that rospy has
        just begun counts for it already, but has no caller's name yet."""
        client = self._client
        listened = all(end.get_num_connections() > 0 for end in (client.pub_goal, client.pub_cancel))
        return listened and all(any(found.callerid_pub != UNNAMED for found in end.impl.connections)
                                for end in (client.status_sub, client.result_sub, client.feedback_sub))

    def send(self, goal):
        """Returns the Motion."""
        deadline = time.monotonic() + self._wait_s
        while not self.connected():
            if time.monotonic() > deadline:
                raise ArmError(ClientCode.NOT_RUNNING, f"no action {self._name} after {self._wait_s:g} s: {self._start}")
            time.sleep(0.01)
        if not self._settled:
            time.sleep(SETTLE_S)
            self._settled = True
        motion = Motion(self.connected)
        motion.started(self._client.send_goal(goal, motion.on_transition, motion.on_feedback))
        return motion

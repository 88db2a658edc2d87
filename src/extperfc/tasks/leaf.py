"""What all leaves have in common."""

import py_trees
import rospy
import std_msgs.msg

from extperfc.arm.errors import ArmError
from extperfc.tasks.blackboard import read

Status = py_trees.common.Status


class Leaf(py_trees.behaviour.Behaviour):
    """A leaf whose errors are failures with a message instead of exceptions out of the tree.

    Write begin() and step(). step() returns True: succeeded, False: failed, None: still running; both may raise ArmError,
    ValueError (invalid numbers) and KeyError (a blackboard's value that was not written). `feedback_message` is what people
    read.
    """

    _motion = None  # an extperfc.arm.connection.Motion that the leaf waits for; cancelled when the leaf ends before it

    def begin(self):
        """Called when the leaf becomes active."""

    def step(self):
        raise NotImplementedError

    def initialise(self):
        self.feedback_message, self._error = "", None
        self._attempt(self.begin)

    def update(self):
        done = None if self._error else self._attempt(self.step)
        if self._error:
            self.feedback_message = self._error
            return Status.FAILURE
        return {True: Status.SUCCESS, False: Status.FAILURE, None: Status.RUNNING}[done]

    def terminate(self, new_status):
        if self._motion is not None and not self._motion.done:
            self._motion.cancel()

    def _attempt(self, call):
        try:
            return call()
        except (ArmError, KeyError, ValueError) as error:
            self._error = str(error.args[0] if isinstance(error, KeyError) else error)
            return None


class ActionLeaf(Leaf):
    """A leaf that lasts as long as an action. Write motion(), which sends the goal and returns an
    extperfc.arm.connection.Motion, and succeeded(result) where the result matters. A tree that leaves it early cancels it."""

    def motion(self):
        raise NotImplementedError

    def succeeded(self, result):
        """Called with the action's result."""

    def begin(self):
        self._motion = None
        self._motion = self.motion()

    def step(self):
        if not self._motion.done:
            self.feedback_message = getattr(self._motion.feedback, "stage", "")
            return None
        result = self._motion.result()
        self.feedback_message = getattr(result, "message", "")
        self.succeeded(result)
        return True


class Say(Leaf):
    """Publishes a text on `task/say` (std_msgs/String, latched) and logs it. Braces take from `values`, which may be Keys:
    Say("a {shape}", shape=Key("what"))."""

    _publisher = None

    def __init__(self, text, name=None, **values):
        super().__init__(name or "say")
        self.text, self.values = text, values

    def step(self):
        if Say._publisher is None:
            Say._publisher = rospy.Publisher("task/say", std_msgs.msg.String, queue_size=20, latch=True)
        text = self.text.format(**{name: read(value) for name, value in self.values.items()}) if self.values else self.text
        Say._publisher.publish(text)
        rospy.loginfo("%s", text)
        self.feedback_message = text
        return True


class Wait(Leaf):
    """Waits for some seconds of ROS time."""

    def __init__(self, seconds, name=None):
        super().__init__(name or f"wait {seconds:g} s")
        if not seconds >= 0:
            raise ValueError(f"Wait: {seconds} s must not be negative")
        self.seconds = seconds

    def begin(self):
        self._end = rospy.Time.now() + rospy.Duration(self.seconds)

    def step(self):
        return True if rospy.Time.now() >= self._end else None


class GiveUp(Leaf):
    """Fails with a reason."""

    def __init__(self, why, name=None):
        super().__init__(name or "give up")
        self.why = why

    def step(self):
        self.feedback_message = self.why
        return False

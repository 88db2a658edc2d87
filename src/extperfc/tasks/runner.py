"""Ticks a tree."""

import time

import py_trees
import rospy
import std_msgs.msg

Status = py_trees.common.Status
PERIOD_S = 0.1  # of real time, between ticks


class Failures:
    """What leaves said when they failed, in that order: composites with memory reset what failed before. A leaf that begins
    again or succeeds later is left out."""

    def __init__(self):
        self._said = {}

    def note(self, root):
        """Call after each tick."""
        for leaf in root.iterate():
            if leaf.children:
                continue
            if leaf.status == Status.FAILURE:
                self._said[leaf.id] = f"{leaf.name}: {leaf.feedback_message}"
            elif leaf.status in (Status.RUNNING, Status.SUCCESS):
                self._said.pop(leaf.id, None)

    def __str__(self):
        return "; ".join(self._said.values())


def run(root, period_s=PERIOD_S, alive=lambda: not rospy.is_shutdown(), on_tick=None):
    """Ticks a tree until it ends; returns (succeeded, why not). What is active is cancelled when `alive()` is false, when the program is interrupted, and by exceptions. on_tick(root) is called after each tick.

    The tree with its states is on the topic `task/tree` (std_msgs/String, latched), whenever it changes.
    """
    publisher = rospy.Publisher("task/tree", std_msgs.msg.String, queue_size=1, latch=True)
    tree = py_trees.trees.BehaviourTree(root)
    tree.setup(timeout=60.0)
    shown, failures = None, Failures()
    try:
        while alive():
            tree.tick()
            failures.note(root)
            text = py_trees.display.unicode_tree(root, show_status=True)
            if text != shown:
                shown = text
                publisher.publish(text)
            if on_tick is not None:
                on_tick(root)
            if root.status in (Status.SUCCESS, Status.FAILURE):
                succeeded = root.status == Status.SUCCESS
                return succeeded, "" if succeeded else str(failures)
            time.sleep(period_s)
        return False, "stopped"
    finally:
        if root.status == Status.RUNNING:
            root.stop(Status.INVALID)

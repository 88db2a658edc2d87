"""Moves the robot's arms from Python; the nodelet extperfc/arm plans and executes.

    import extperfc.arm
    left = extperfc.arm.Arm("left")
    left.move_to("neutral")
    left.move_to((0.7, 0.3, 0.1))                        # the tool, in the frame `base` [m], with its present orientation
    left.scene.add_box("table", (0.8, 1.2, 0.04), (0.9, 0, -0.2))
    left.pick("cube")

Lengths in metres, angles in radians, times in seconds, orientations as roll, pitch, yaw about the fixed axes or as
quaternions x, y, z, w. Failures raise ArmError with the code, its name, and the node's message.
"""

from extperfc.arm.client import Arm, Plan, StateCheck
from extperfc.arm.connection import Motion
from extperfc.arm.errors import ArmError, ClientCode
from extperfc.arm.goals import (keep_axis, keep_line, keep_orientation, keep_plane, keep_relative, matrix_of_pose,
                                pose_stamped)
from extperfc.arm.scene import Scene

__all__ = ["Arm", "ArmError", "ClientCode", "Motion", "Plan", "Scene", "StateCheck", "keep_axis", "keep_line",
           "keep_orientation", "keep_plane", "keep_relative", "matrix_of_pose", "pose_stamped"]

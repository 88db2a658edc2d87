"""A robot's description (URDF) with a camera where a calibration found it."""

import re

import numpy

from extperfc import robot_description as rd
from extperfc.calibrate.result import rpy_of_rotation
from extperfc.calibrate.views import ViewsError


def _joint_to_change(robot, parent, child):
    """The fixed joint nearest to `parent` on the fixed chain from parent to child, and joint_child_T_child."""
    above = {joint.child: joint for joint in robot.joints.values()}
    if child not in robot.links or parent not in robot.links:
        raise ViewsError(f"the URDF has no link {child if child not in robot.links else parent}")
    chain, link = [], child
    while link != parent:
        joint = above.get(link)
        if joint is None:
            raise ViewsError(
                f"in the URDF {child} does not hang on {parent}: calibrate with --camera-on {robot.root}, or a link "
                f"between {robot.root} and {child}")
        if joint.kind != "fixed":
            raise ViewsError(
                f"joint {joint.name} between {parent} and {child} moves: calibrate with --camera-on {joint.child}")
        chain.append(joint)
        link = joint.parent
    last_T_child = numpy.eye(4)
    for joint in chain[:-1]:
        last_T_child = joint.parent_T_joint @ last_T_child
    return chain[-1], last_T_child


def with_camera(urdf, parent, child, parent_T_child):
    """The URDF's text with the fixed joint below `parent` changed so that parent_T_child holds; nothing else changes.
    Raises views.ViewsError."""
    try:
        robot = rd.RobotDescription(urdf)
    except ValueError as error:
        raise ViewsError(str(error)) from None
    joint, last_T_child = _joint_to_change(robot, parent, child)
    pose = parent_T_child @ rd.inverse(last_T_child)
    origin = (f'<origin xyz="{" ".join(f"{value:.6f}" for value in pose[:3, 3])}" '
              f'rpy="{" ".join(f"{value:.6f}" for value in rpy_of_rotation(pose[:3, :3]))}"/>')
    element = re.search(rf'<joint\b[^>]*\bname="{re.escape(joint.name)}"[^>]*>.*?</joint>', urdf, re.DOTALL)
    if element is None:
        raise ViewsError(f"joint {joint.name} is written in an unusual form: change its origin by hand to {origin}")
    text = element[0]
    if "<origin" in text:
        text = re.sub(r"<origin\b[^>]*?/>|<origin\b[^>]*>.*?</origin>", origin, text, flags=re.DOTALL)
    else:
        text = text.replace("</joint>", origin + "</joint>")
    return urdf[:element.start()] + text + urdf[element.end():]

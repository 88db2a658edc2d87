"""Tasks as behaviour trees: leaves for the robot's actions, and what ticks a tree. See docs/tasks.md.

Trees are those of py_trees; leaves are extperfc.tasks.Pick, Place, GoTo, ...; run(tree) ticks one until it ends.
"""

from extperfc.tasks.arm_leaves import ArmsTo, InScene, MoveArm, MoveGrippers, Pick, Place, Show, StillHeld
from extperfc.tasks.around import SeeAround
from extperfc.tasks.base_leaves import Explore, GoTo
from extperfc.tasks.blackboard import Key, read, write
from extperfc.tasks.find import Find, Found
from extperfc.tasks.follow import EnrollFace, Follow
from extperfc.tasks.leaf import ActionLeaf, GiveUp, Leaf, Say, Wait
from extperfc.tasks.recipes import CLEAR_M, bring, carry, pick_up, put_down, show
from extperfc.tasks.runner import run
from extperfc.tasks.search import Approach, Search
from extperfc.tasks.support import SeeSupport

__all__ = ["ActionLeaf", "Approach", "ArmsTo", "CLEAR_M", "EnrollFace", "Explore", "Find", "Follow", "Found", "GiveUp", "GoTo",
           "InScene", "Key", "Leaf", "MoveArm", "MoveGrippers", "Pick", "Place", "Say", "Search", "SeeAround",
           "SeeSupport", "Show", "StillHeld", "Wait", "bring", "carry", "pick_up", "put_down", "read", "run", "show",
           "write"]

"""What leaves leave for each other: values by name, on py_trees' blackboard."""

import dataclasses

from py_trees.blackboard import Blackboard


@dataclasses.dataclass(frozen=True)
class Key:
    """In place of an argument of a leaf: the value that stands under this name when the leaf begins. part: an attribute."""
    name: str
    part: str = ""


def write(name, value):
    Blackboard.set(name, value)


def read(value):
    """The value itself, or what stands under a Key. Raises KeyError when nothing was written there."""
    if not isinstance(value, Key):
        return value
    found = Blackboard.get(value.name)
    return getattr(found, value.part) if value.part else found

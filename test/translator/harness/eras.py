"""Message classes of both eras side by side in one process: genpy's, as the puppets use them."""

import contextlib
import functools
import importlib
import io
import pathlib
import random
import struct
import sys

import genmsg.msgs
import genpy


class Era:
    """Classes of the packages that one era has of its own; the others are the distribution's."""

    def __init__(self, folder):
        self._tree, self._python = pathlib.Path(folder) / "tree", pathlib.Path(folder) / "python"
        self._packages = {place.name for place in self._python.iterdir()}
        self._modules = {}

    def types(self, kind):
        """Names of the tree's messages (`msg`) or services (`srv`)."""
        return {f"{file.parent.parent.name}/{file.stem}" for file in self._tree.glob(f"*/{kind}/*.{kind}")}

    def message(self, type_name):
        """The class of a message type."""
        package, name = type_name.split("/")
        return getattr(self._import(package + ".msg"), name)

    def service(self, type_name):
        """The class of a service type, with _request_class and _response_class."""
        package, name = type_name.split("/")
        return getattr(self._import(package + ".srv"), name)

    @functools.lru_cache(maxsize=None)
    def _import(self, module):
        with self._own_modules():
            return importlib.import_module(module)

    @contextlib.contextmanager
    def _own_modules(self):
        """Both eras have modules of the same names: each keeps its own, and Python sees one era's at a time."""
        def take():
            return {name: sys.modules.pop(name) for name in list(sys.modules) if name.split(".")[0] in self._packages}
        others = take()
        sys.modules.update(self._modules)
        sys.path.insert(0, str(self._python))
        importlib.invalidate_caches()
        try:
            yield
        finally:
            sys.path.remove(str(self._python))
            self._modules = take()
            sys.modules.update(others)


def class_of(kind, type_name):
    """The class of a type that a message class embeds."""
    package, name = type_name.split("/")
    return getattr(kind.__init__.__globals__[package].msg, name)


def to_bytes(message):
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


def to_hex(message):
    return "x" + to_bytes(message).hex()


def from_hex(kind, text):
    return kind().deserialize(bytes.fromhex(text[1:]))


_SIGNED_BITS = {"int8": 8, "byte": 8, "int16": 16, "int32": 32, "int64": 64}
_UNSIGNED_BITS = {"uint8": 8, "char": 8, "uint16": 16, "uint32": 32, "uint64": 64}


class RandomContent:
    """Messages with random values; what a seed makes, it always makes."""

    def __init__(self, seed, longest=3):
        self._random = random.Random(seed)
        self._longest = longest

    def message(self, kind):
        """A message of a class that Era made."""
        return self._fill(kind())

    def _fill(self, message):
        for name, type_name in zip(message.__slots__, message._slot_types):
            setattr(message, name, self._value(type_name, type(message)))
        return message

    def _value(self, type_name, kind):
        base, is_array, length = genmsg.msgs.parse_type(type_name)
        if not is_array:
            return self._single(base, kind)
        count = self._random.randint(0, self._longest) if length is None else length
        if base in ("uint8", "char"):
            return self._random.randbytes(count)
        return [self._single(base, kind) for _ in range(count)]

    def _single(self, base, kind):
        r = self._random
        if base == "bool":
            return r.random() < 0.5
        if base in _SIGNED_BITS:
            return r.randint(-2 ** (_SIGNED_BITS[base] - 1), 2 ** (_SIGNED_BITS[base] - 1) - 1)
        if base in _UNSIGNED_BITS:
            return r.randint(0, 2 ** _UNSIGNED_BITS[base] - 1)
        if base == "float32":
            return struct.unpack("f", struct.pack("f", r.uniform(-1e6, 1e6)))[0]
        if base == "float64":
            return r.uniform(-1e9, 1e9)
        if base == "string":
            return "".join(r.choice("abcäß/ \t0") for _ in range(r.randint(0, 8)))
        if base == "time":
            return genpy.Time(r.randint(0, 2 ** 32 - 1), r.randint(0, 999_999_999))
        if base == "duration":
            return genpy.Duration(r.randint(-2 ** 31 + 1, 2 ** 31 - 2), r.randint(0, 999_999_999))
        return self._fill(class_of(kind, base)())


def without_seq(message):
    """Publishers count `seq` themselves."""
    if hasattr(message, "header"):
        message.header.seq = 0
    return message


def same_value(a, b):
    """Equal in the fields that both have, at any depth; messages of different classes pair by field names."""
    if isinstance(a, genpy.Message) and isinstance(b, genpy.Message):
        return all(same_value(getattr(a, name), getattr(b, name)) for name in a.__slots__ if name in b.__slots__)
    if isinstance(a, (list, tuple)) and isinstance(b, (list, tuple)):
        return len(a) == len(b) and all(map(same_value, a, b))
    return a == b


def objects_with_pose(message):
    """The moveit_msgs/CollisionObjects in a message that have a pose of their own (Noetic's)."""
    for name in message.__slots__:
        value = getattr(message, name)
        for each in value if isinstance(value, list) else [value]:
            if isinstance(each, genpy.Message):
                yield from objects_with_pose(each)
    if message._type == "moveit_msgs/CollisionObject" and hasattr(message, "pose"):
        yield message


def leave_shapes_where_they_are(message):
    """Gives every collision object the identity as its own pose: another pose would move its shapes for Indigo."""
    for moved in objects_with_pose(message):
        moved.pose = type(moved.pose)()
        moved.pose.orientation.w = 1.0
    return message

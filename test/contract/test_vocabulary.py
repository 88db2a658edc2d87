#!/usr/bin/env python3
"""Contract: names and texts use the words of the field, and one idea has one word.

Two checks: parts of identifiers in C++ and Python (`kMostRays` has the parts `most` and `rays`), and text that a user
reads: string literals of src/ and tools/, comments of YAML, `doc` of launch files, comments of message definitions,
documents. Comments in code are not checked. A hit names file, line, the word and what to write instead.

Run: /usr/bin/python3 test/contract/test_vocabulary.py
"""

import functools
import pathlib
import re
import unittest

REPO = pathlib.Path(__file__).resolve().parents[2]

# Parts of identifiers: snake_case and CamelCase are split, plurals count as their singular.
PARTS = {
    "picture": "image",
    "thing": "object",
    "way": "path, segment, distance, motion, direction",
    "turn": "rotation, yaw, revolution",
    "share": "fraction, ratio, weight",
    "word": "argument, token, type, name",
    "most": "max",
    "least": "min",
    "fewest": "min",
    "told": "reported, published, known",
    "tell": "report, publish, describe",
    "piece": "object model, mesh instance",
    "lamp": "light",
    "walker": "pedestrian",
    "mover": "attached_to",
    "vague": "ambiguous",
    "absentee": "missing subscriber",
    "errand": "place requirement",
    "sighting": "loop-closure candidate",
    "rival": "pose hypothesis",
}

# Where a part is wrong, for parts that mean something else elsewhere.
ONLY_IN = {"piece": ("include/extperfc/simulate/", "src/simulate/", "test/unit/simulate/")}

# Whole identifiers.
NAMES = {
    "Hooks": "MotionCallbacks",
    "Ending": "Status",
    "Commander": "PlanExecution",
    "SceneKeeper": "PlanningScene",
    "SceneItem": "CollisionObject",
    "RobotWatch": "RobotStateMonitor",
    "DepthWatch": "DepthObstacleMonitor",
    "ObjectWatch": "ObjectMonitor",
    "Reach": "ReachableGrasps",
    "Room": "Clearances",
    "Spot": "PlacePose",
    "Gate": "RequestValidator",
    "request_gate": "RequestValidator",
    "StandingBox": "UprightBox",
    "FrameFinder": "TransformLookup",
    "Carriage": "Conversion",
    "Crossing": "bridged topic, bridged service",
    "convincing": "is_consistent",
    "relax": "optimize",
    "bent": "map_changed",
    "sharpness": "likelihood_exponent",
    "news_m": "min_change_m",
    "kOld": "kRobot",
    "kNew": "kWorkstation",
    "go_on_from": "resume_from",
    "develop": "apply_camera_effects",
}

# Identifiers in which such a part has another meaning.
ALLOWED_NAMES = {
    "at_most": "a limit, as in English",
    "at_least": "a limit, as in English",
    "share_image": "shares memory",
    "ShareImage": "shares memory",
    "toCvShare": "cv_bridge",
    "share": "std::future and std::shared_future",
    "one_way": "one direction of a bridge",
    "isTurning": "a field of baxter_core_msgs",
}

# Words in text: pattern, what to write.
TEXT = (
    (r"pictures?", "image"),
    (r"things?", "object"),
    (r"lamps?", "light"),
    (r"walkers?", "pedestrian"),
    (r"vague", "ambiguous"),
    (r"(?:an?|the|one|per|full|half|quarter|this) turns?", "rotation, revolution"),
    (r"(?:an?|the|this|that) share(?! of)|shares? of", "fraction"),
    (r"(?:in|on|under) (?:the|its|their) way", "path, motion"),
    (r"told|tells", "reported, publishes"),
    (r"(?-i:is none)", "a sentence that says what is missing"),
    (r"whatever|whoever", "any"),
    (r"somebody|nobody", "subscribers, user, unknown"),
    (r"time law", "time parameterization"),
)

# Path prefix, words, reason.
EXCEPTIONS = (
    ("config/worlds/", ("lamp",), "desk_lamp is an object of a world"),
    ("src/simulate/worlds/", ("lamp",), "desk_lamp is an object of a world"),
    ("models/shapes/README.md", ("lamp", "picture"), "objects in photographs"),
    ("src/extperfc/training/", ("word",), "drawn on textures"),
    ("urdf/generator/", ("lamp",), "the lamps of the robot's chassis"),
    ("src/arm/collision/", ("reach",), "how far a body reaches"),
    ("src/arm/kinematics/", ("reach",), "how far an arm reaches"),
    ("test/unit/arm/cartesian/", ("bent",), "a posture with bent elbows"),
    ("test/unit/simulate/render/test_mesh.cpp", ("bent",), "faces at an angle"),
)

FOLDERS = ("action", "cmake", "config", "docs", "include", "launch", "models", "msg", "src", "srv", "test", "tools", "urdf")
CODE = {".cpp", ".hpp", ".py"}
SKIPPED = ("config/translate/definitions/", "test/data/", "test/contract/test_vocabulary.py")

CPP_TOKEN = re.compile(r'//[^\n]*|/\*.*?\*/|R"(?P<raw>\w*)\((?P<text>.*?)\)(?P=raw)"|"(?P<string>(?:\\.|[^"\\\n])*)"|'
                       r"\d[\w'.]*|'(?:\\.|[^'\\\n])*'|(?P<include>#\s*include[^\n]*)|(?P<name>[A-Za-z_]\w*)", re.DOTALL)
PYTHON_TOKEN = re.compile(r'#[^\n]*|[rbfuRBFU]{0,2}(?:"""(?P<text>.*?)"""|\'\'\'.*?\'\'\'|"(?P<string>(?:\\.|[^"\\\n])*)"|'
                          r"'(?P<raw>(?:\\.|[^'\\\n])*)')|(?P<include>^from [^\n]*|^import [^\n]*)|"
                          r"(?P<name>[A-Za-z_]\w*)", re.DOTALL | re.MULTILINE)
PART = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+")
TEXT_PATTERN = re.compile("|".join(fr"(?P<p{i}>\b(?:{pattern})\b)" for i, (pattern, _) in enumerate(TEXT)), re.IGNORECASE)
# Test names are sentences, in which these are verbs and adjectives.
SENTENCE = re.compile(r"\b(?:INSTANTIATE_)?(?:TYPED_)?TEST(?:_SUITE)?(?:_[FP])?\([^)]*\)|\bdef test_\w+")


@functools.lru_cache(maxsize=None)
def wrong_parts(name):
    """(word, replacement) of an identifier, or an empty tuple."""
    if name in ALLOWED_NAMES:
        return ()
    if name in NAMES:
        return ((name, NAMES[name]),)
    found = []
    parts = [part.lower() for part in PART.findall(name)]
    for index, part in enumerate(parts):
        word = part if part in PARTS else part[:-1] if part.endswith("s") else part
        idiom = word in ("most", "least") and (parts[index - 1:index] == ["at"] or parts[index + 1:index + 2] == ["squares"])
        if word in PARTS and not idiom:
            found.append((word, PARTS[word]))
    return tuple(found)


def wrong_words(text):
    """(offset, word, replacement) of a text."""
    for hit in TEXT_PATTERN.finditer(text):
        yield hit.start(), hit.group(), TEXT[int(hit.lastgroup[1:])][1]


def hits_in_code(text, suffix, is_user_text):
    sentences = [found.span() for found in SENTENCE.finditer(text)]
    for token in (PYTHON_TOKEN if suffix == ".py" else CPP_TOKEN).finditer(text):
        kind = token.lastgroup
        if kind == "name":
            wrong = wrong_parts(token.group())
            if wrong and not any(begin <= token.start() < end for begin, end in sentences):
                yield from ((token.start(), word, instead) for word, instead in wrong)
        elif is_user_text and (token["text"] or token["string"] or token["raw"]):
            for offset, word, instead in wrong_words(token.group()):
                yield token.start() + offset, word, instead


def hits_in_text(text, suffix):
    if suffix == ".yaml":
        parts = ((found.start(), found.group()) for found in re.finditer(r"#[^\n]*", text))
    elif suffix in (".launch", ".test"):
        parts = ((found.start(), found.group()) for found in re.finditer(r'doc="[^"]*"|<!--.*?-->', text, re.DOTALL))
    else:
        parts = ((0, text),)
    for begin, part in parts:
        for offset, word, instead in wrong_words(part):
            yield begin + offset, word, instead


def is_python(file):
    if file.suffix or file.parent != REPO / "tools" or not file.is_file():
        return file.suffix == ".py"
    with file.open("rb") as stream:
        return b"python" in stream.readline()


def files():
    """(path below the repository, suffix) of what is checked."""
    yield REPO / "README.md", ".md"
    for folder in FOLDERS:
        for file in sorted((REPO / folder).rglob("*")):
            suffix = ".py" if is_python(file) else file.suffix
            if suffix in CODE or suffix in (".md", ".yaml", ".launch", ".test", ".msg", ".srv", ".action"):
                yield file, suffix


def is_exception(name, word):
    if word in ONLY_IN and not name.startswith(ONLY_IN[word]):
        return True
    return any(name.startswith(prefix) and word.lower().rstrip("s") in words for prefix, words, _ in EXCEPTIONS)


def all_hits():
    for file, suffix in files():
        name = file.relative_to(REPO).as_posix()
        if name.startswith(SKIPPED) or "__pycache__" in name:
            continue
        text = file.read_text(encoding="utf-8", errors="replace")
        hits = hits_in_code(text, suffix, name.startswith(("src/", "tools/"))) if suffix in CODE else hits_in_text(text, suffix)
        for offset, word, instead in hits:
            if not is_exception(name, word):
                yield f"{name}:{text.count(chr(10), 0, offset) + 1}: \"{word}\": write {instead}"


class Vocabulary(unittest.TestCase):
    def test_names_and_texts_use_the_words_of_the_field(self):
        found = list(all_hits())
        self.assertFalse(found, f"{len(found)} words:\n" + "\n".join(found))

    def test_identifiers_are_split(self):
        for name, word in (("kMostRays", "most"), ("read_words", "word"), ("DepthPicture", "picture"), ("way_", "way"),
                           ("things_", "thing"), ("Ending", "Ending"), ("max_turn_rad_s", "turn")):
            self.assertEqual([word], [found for found, _ in wrong_parts(name)], name)
        for name in ("return", "sideways", "shared_ptr", "at_most", "least_squares", "nothing", "clamp", "almost"):
            self.assertFalse(wrong_parts(name), name)

    def test_code_and_text_are_told_apart(self):
        source = '// a thing\nint x = 1\'000;  /* lamp */ call("the thing");\nint turn = return_1;\n'
        self.assertEqual([("thing", 2), ("turn", 3)], [(word, source.count("\n", 0, offset) + 1)
                                                       for offset, word, _ in hits_in_code(source, ".cpp", True)])
        self.assertEqual(["turn"], [word for _, word, _ in hits_in_code(source, ".cpp", False)])
        self.assertEqual(["things"], [word for _, word, _ in hits_in_text("thing: 1  # of things\n", ".yaml")])
        launch = '<!-- no picture --><arg name="thing" doc="somebody"/>'
        self.assertEqual(["picture", "somebody"], [word for _, word, _ in hits_in_text(launch, ".launch")])
        self.assertEqual(["is none"], [word for _, word, _ in wrong_words("it is none; x is None")])


if __name__ == "__main__":
    unittest.main()

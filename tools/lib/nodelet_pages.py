"""Makes docs/nodelets.md from the class comments in src/ros, the YAML files in config/ and the launch files.

A class comment has a description, then sections: "Subscribes:", "Publishes (condition):", ... Rows of a section are
indented by two spaces, a name and its text are two or more spaces apart, and deeper lines continue a row. "Parts:" names
classes whose rows belong to the node, too; a comment "X as a nodelet." stands for that of X. A parameter of a YAML file is
`key: default  # [range] unit, meaning`; a line `#key: default  # ...` describes one that the file leaves alone.
"""

import dataclasses
import functools
import pathlib
import re
import xml.etree.ElementTree

REPO = pathlib.Path(__file__).resolve().parents[2]
PAGE = REPO / "docs" / "nodelets.md"
ROWS = ("Subscribes", "Publishes", "Services", "Actions", "Calls")
TEXTS = ("Frames", "Diagnostics", "Threads")
PROGRAMS = {"extperfc/translator": "TranslatorNode"}  # nodes that are no plug-ins
HEADER = re.compile(r"(" + "|".join((*ROWS, *TEXTS, "Parameters", "Parts")) + r")(?: \((.*)\))?:(?: (.*))?$")
RANGE = r"[\[(][^\])]*[\])]"
UNIT = r"(?:(?:[1-9]/)?[km]?(?:m|s|rad|px|Hz|g|%|UDP)(?:\^2)?(?:/(?:m|s|rad)(?:\^2)?)?)"
KEY = re.compile(r"(?P<indent> *)(?P<only_text>#?)(?P<key>\w+):(?: +(?P<value>[^#\s](?:[^#]|(?<! )#)*?))?"
                 r"(?: +#\s?(?P<text>.*))?$")
INTRODUCTION = """# Reference: topics, services, actions and parameters

This page is made by `tools/docs` from the comments of the node classes and from the files in `config/`; a test compares them.

Names are relative to the namespace, so two robots run side by side. Parameters are private. Unknown parameters are refused, and
all errors are reported at once. An empty range means that any value of the type is accepted; a default in parentheses is set
by a launch argument or by the program. What a message of a node means and what to do: [troubleshooting.md](troubleshooting.md).

```
 camera driver or source ──pointer──> detector ──pointer──> box_depth ──> detections_3d, detections_3d/surface, objects/markers
          └───────────────pointer: aligned depth ────────────────┘
```
"""


@dataclasses.dataclass
class Node:
    """A class comment."""
    text: str = ""
    rows: dict = dataclasses.field(default_factory=dict)   # section: [(condition, name, text)]
    texts: dict = dataclasses.field(default_factory=dict)  # section: text


@dataclasses.dataclass
class Parameter:
    name: str      # with its groups, e.g. planning/seed
    default: str
    text: str      # the comment behind it
    is_set: bool   # by this file

    @property
    def leaf(self):
        return self.name.rsplit("/", 1)[-1]

    @property
    def range_text(self):
        found = re.match(RANGE, self.text)
        return found.group() if found else ""

    @property
    def unit(self):
        found = re.match(rf"\s*({UNIT})(?=[,;:. ]|$)", self.text[len(self.range_text):])
        return found[1] if found else ""

    @property
    def meaning(self):
        rest = self.text[len(self.range_text):].lstrip()
        return rest[len(self.unit):].lstrip(" ,;")


@functools.lru_cache(maxsize=None)
def comments():
    """Class comments in src/ros by the names of the classes, without the slashes."""
    found = {}
    for file in sorted((REPO / "src/ros").rglob("*.[ch]pp")):
        for match in re.finditer(r"((?:^///.*\n)+)class (\w+)", file.read_text(), re.MULTILINE):
            found[match[2]] = [line[4:].rstrip() for line in match[1].splitlines()]
    return found


def sections(lines):
    """(title, condition, lines) of a comment; the first title is empty."""
    title, condition, body = "", "", []
    for line in lines:
        header = HEADER.match(line)
        if header:
            yield title, condition, body
            title, condition, body = header[1], header[2] or "", [header[3]] if header[3] else []
        else:
            body.append(line)
    yield title, condition, body


def rows_of(body):
    """(name, text) of the rows of a section."""
    rows = []
    for line in body:
        if re.match(r"  \S", line):
            rows.append(re.split(r"\s{2,}", line.strip(), maxsplit=1))
        elif rows:
            rows[-1] = [rows[-1][0], " ".join([*rows[-1][1:], line.strip()])]
    return [(row[0], row[1] if len(row) > 1 else "") for row in rows]


@functools.lru_cache(maxsize=None)
def node(class_name):
    lines = comments()[class_name]
    alias = re.fullmatch(r"(?:\w+::)?(\w+) as a nodelet\.", " ".join(lines))
    if alias:
        return node(alias[1])
    result, parts = Node(), []
    for title, condition, body in sections(lines):
        if title in ROWS:
            result.rows.setdefault(title, []).extend((condition, *row) for row in rows_of(body))
        elif title == "Parts":
            parts = re.findall(r"\w+", " ".join(body))
        elif title:
            result.texts[title] = " ".join(line.strip() for line in body)
        else:
            result.text = re.sub(r"\n(?!\n)(?<!\n\n)", " ", "\n".join(body)).strip()
    for part in map(node, parts):
        for title, rows in part.rows.items():
            result.rows.setdefault(title, []).extend(rows)
    return result


def nodes():
    """Names as extperfc/detector and their classes."""
    root = xml.etree.ElementTree.parse(REPO / "config/nodelet_plugins.xml").getroot()
    plugins = {item.get("name"): item.get("type").rsplit(":", 1)[-1] for item in root.iter("class")}
    return {**plugins, **PROGRAMS}


def configurations(class_name):
    """The YAML files that the comment's section Parameters names."""
    return list(dict.fromkeys(re.findall(r"config/\w+\.yaml", node(class_name).texts.get("Parameters", ""))))


def launch_files(name):
    short = name.split("/")[1]
    starts = (f"load {name} ", f'type="{short}"')
    return [file.name for file in sorted((REPO / "launch").glob("*.launch")) if any(s in file.read_text() for s in starts)]


def parameters(file, prefix=""):
    """Every Parameter of a configuration file, in its order."""
    found, groups, list_indent = [], [(-1, prefix)], None
    lines = (REPO / file).read_text().splitlines()
    for number, line in enumerate(lines):
        if list_indent is not None and (not line.strip() or len(line) - len(line.lstrip()) > list_indent):
            continue
        list_indent = None
        match = KEY.match(line)
        if not match or (match["only_text"] and not match["text"]):
            if found and re.match(r" {20,}# ", line):
                found[-1].text += " " + line.strip()[2:]
            continue
        indent = len(match["indent"])
        while groups[-1][0] >= indent:
            groups.pop()
        name, value = groups[-1][1] + match["key"], (match["value"] or "").strip()
        following = next((text for text in lines[number + 1:] if text.strip() and not text.strip().startswith("#")), "")
        if not value and not re.match(r"\s*- ", following) and len(following) - len(following.lstrip()) > indent:
            groups.append((indent, name + "/"))
        else:
            list_indent = indent if not value else None
            found.append(Parameter(name, value or "a list", match["text"] or "", not match["only_text"]))
    return found


def cell(text, is_code=False):
    text = re.sub(r"\s+", " ", text).replace("|", "\\|").strip()
    return text if is_code else text.replace("*", "\\*").replace("<", "&lt;")


def sentence(text):
    return text[:1].upper() + text[1:]


def rows_table(title, rows):
    yield ""
    conditions = list(dict.fromkeys(condition for condition, _, _ in rows))
    for condition in conditions:
        yield f"| {title}{': ' + cell(condition) if condition else ''} | type and meaning |"
        yield "|---|---|"
        for _, name, text in (row for row in rows if row[0] == condition):
            names = ", ".join(f"`{one}`" for one in name.split(", ")) if text else cell(name)
            yield f"| {names} | {cell(text)} |"
        if condition != conditions[-1]:
            yield ""


def parameter_table(file, prefix):
    yield ""
    yield f"| parameter in {file.split('/')[1]} | default | range | meaning |"
    yield "|---|---|---|---|"
    for item in parameters(file, prefix):
        code = "see the file" if item.default == "a list" else f"`{item.default}`"
        default = cell(code if item.is_set else f"({code})", is_code=True)
        yield f"| `{item.name}` | {default} | {cell(item.range_text + ' ' + item.unit)} | {cell(item.meaning)} |"


def node_page(name, class_name):
    described = node(class_name)
    yield ""
    yield f"## {name}"
    yield ""
    yield described.text
    files = launch_files(name)
    if files:
        yield ""
        yield "Started by " + ", ".join(f"[{file}](../launch/{file})" for file in files) + "."
    for title in ROWS:
        if described.rows.get(title):
            yield from rows_table(title.lower(), described.rows[title])
    for title in TEXTS:
        if title in described.texts:
            yield ""
            yield f"**{title}.** {sentence(described.texts[title])}"
    if "Parameters" in described.texts:
        yield ""
        linked = re.sub(r"(config/[\w/.]*\w)", r"[\1](../\1)", described.texts["Parameters"])
        yield f"**Parameters.** {sentence(linked)}"
    for file in configurations(class_name):
        yield from parameter_table(file, "robot/" if file == "config/robot_interface.yaml" else "")


def page():
    lines = [INTRODUCTION.rstrip("\n")]
    for name, class_name in nodes().items():
        lines.extend(node_page(name, class_name))
    return "\n".join(lines) + "\n"

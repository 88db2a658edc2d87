"""docs/ says what the sources say: reference and drawings are those that tools/docs makes, every parameter stands in one YAML
file with its unit and range, and links lead somewhere."""

import pathlib
import re
import subprocess
import sys
import unittest

REPO = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(REPO / "tools" / "lib"))
import drawings  # noqa: E402
import nodelet_pages  # noqa: E402

# Loaders in src/ros/params and the files that they read.
LOADERS = {
    "arm_params": ("arm",), "box_depth_params": ("box_depth",), "cloud_to_scan_params": ("cloud_to_scan",), "cmd_vel_mux_params": ("cmd_vel_mux",),
    "detector_params": ("detector",), "explorer_params": ("explorer",), "faces_params": ("faces",), "localizer_params": ("localizer", "initial_pose"), "mapper_params": ("mapper",),
    "map_server_params": ("map_server",), "navigator_params": ("navigator",),
    "robot_interface_params": ("robot_interface",), "simulator_params": ("simulator",), "source_params": ("source",), "tracker_params": ("tracker",),
    "translator_params": ("translator",),
}
READ = re.compile(r'\b(?:read|require|read_\w+)(?:<[^>]*>)?\(\s*(?:\w+,\s*)*(?:std::string\()?"(\w+)"(?P<prefix>\)\s*\+)?')
RANGED = re.compile(r'\bread\w*\(\s*(?:\w+,\s*)?"(\w+)",[^{};]*\{([^{},]+),([^{},]+)\}')
UNITS = {"m_s2": "m/s^2", "rad_s2": "rad/s^2", "m_s": "m/s", "rad_s": "rad/s", "m": "m", "s": "s", "rad": "rad", "px": "px",
         "hz": "Hz", "percent": "%"}
NUMBER = re.compile(r"-?\d+(?:\.\d*)?(?:e-?\d+)?")
WRITTEN = {"classes", "instances"}  # by a node
LINK = re.compile(r"\]\(([^)#\s]*)(?:#([\w-]*))?\)")
PATH = re.compile(r"(?<![\w/.])docs/[\w/]+\.\w+")


def loader(name):
    text = (REPO / f"src/ros/params/{name}.cpp").read_text()
    if "read_footprint(" in text:
        text += (REPO / "src/ros/params/read_footprint.cpp").read_text()
    if name == "mapper_params":
        names = re.findall(r'\{"(\w+)", &P::', (REPO / "src/mapping/param_names.cpp").read_text())
        text += "".join(f'read("{key}");' for key in names)
    return text


def parameters(name):
    return [item for file in LOADERS[name] for item in nodelet_pages.parameters(f"config/{file}.yaml")]


def constant(text, name):
    """A number in C++: a literal, a power of two, or a constant of this source; None when it is neither."""
    name = re.sub(r"static_cast<\w+>\((\w+)\)", r"\1", name.strip()).replace("'", "")
    if NUMBER.fullmatch(name):
        return float(name)
    if shifted := re.fullmatch(r"1 << (\d+)", name):
        return float(1 << int(shifted[1]))
    value = re.search(rf"constexpr \w+ {re.escape(name.lstrip('-'))} = ([^;]+);", text)
    found = constant(text, value[1]) if value else None
    return found if found is None or not name.startswith("-") else -found


def ranges(text):
    """(low, high) by the names of parameters; one name may stand in several groups."""
    found = {}
    for key, low, high in RANGED.findall(text):
        limits = constant(text, low), constant(text, high)
        if None not in limits:
            found.setdefault(key, []).append(limits)
    return found


def agree(stated, limits):
    """A range of a YAML file against that of a loader; behind a parenthesis or a name the core checks more narrowly."""
    low, high = (part.strip() for part in stated[1:-1].split(","))
    lower = not NUMBER.fullmatch(low) or float(low) == limits[0] or (stated[0] == "(" and float(low) >= limits[0] - 1e-6)
    upper = not NUMBER.fullmatch(high) or float(high) == limits[1] or (stated[-1] == ")" and float(high) <= limits[1])
    return lower and upper


def tracked(*patterns):
    """Files of the repository; skips the test where there is none, e.g. in an unpacked archive."""
    listed = subprocess.run(["git", "-C", str(REPO), "ls-files", *patterns], capture_output=True, text=True)
    if listed.returncode:
        raise unittest.SkipTest("not a git repository")
    return [file for file in (REPO / name for name in listed.stdout.splitlines()) if file.is_file()]


def anchors(file):
    """Names of the headings of a page, as GitHub makes them."""
    headings = re.findall(r"^#+ (.*)$", file.read_text(), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


class Generated(unittest.TestCase):
    def test_the_reference_is_that_of_the_sources(self):
        self.assertEqual(nodelet_pages.page(), nodelet_pages.PAGE.read_text(), "run tools/docs")

    def test_the_drawings_are_those_of_the_sources(self):
        for name, make in drawings.DRAWINGS.items():
            self.assertIn(drawings.digest(make()), (drawings.IMAGES / f"{name}.svg").read_text(), f"{name}: run tools/docs")

    def test_every_node_has_its_launch_file_topics_and_diagnostics(self):
        for name, class_name in nodelet_pages.nodes().items():
            with self.subTest(name):
                described = nodelet_pages.node(class_name)
                self.assertIn("diagnostics", {row[1] for row in described.rows["Publishes"]})
                if not name.endswith("_source"):
                    self.assertTrue(nodelet_pages.launch_files(name))

    def test_every_message_type_of_the_reference_has_a_package(self):
        known = re.findall(r"<\w*depend>(\w+)</", (REPO / "package.xml").read_text()) + ["extperfc"]
        for _, class_name in nodelet_pages.nodes().items():
            for title, rows in nodelet_pages.node(class_name).rows.items():
                for _, name, text in rows:
                    with self.subTest(name, section=title):
                        self.assertIn(text.split("/")[0], known)


class Parameters(unittest.TestCase):
    def test_every_loader_is_listed(self):
        readers = {file.stem for file in (REPO / "src/ros/params").glob("*_params.cpp")}
        self.assertEqual(readers, set(LOADERS))

    def test_what_is_read_stands_in_a_file_and_back(self):
        for name in LOADERS:
            text, stated = loader(name), {item.leaf for item in parameters(name)}
            read = {match[1] for match in READ.finditer(text) if not match["prefix"]}
            prefixes = tuple(match[1] for match in READ.finditer(text) if match["prefix"])
            accepted = set(re.findall(r'\baccept\("(\w+)"\)', text)) - WRITTEN
            with self.subTest(name):
                self.assertEqual(set(), read - stated, "read, but not in the YAML file")
                unread = {key for key in stated - read - accepted if not (prefixes and key.startswith(prefixes))}
                self.assertEqual(set(), unread, "in the YAML file, but not read")

    def test_a_parameter_stands_once(self):
        for name in LOADERS:
            names = [item.name for item in parameters(name)]
            self.assertEqual(len(names), len(set(names)), name)

    def test_numbers_have_ranges_and_units_and_every_parameter_a_meaning(self):
        for name in LOADERS:
            for item in parameters(name):
                with self.subTest(item.name, file=name):
                    self.assertTrue(item.text, "no comment")
                    if NUMBER.fullmatch(item.default):
                        self.assertTrue(item.range_text, "no range: write # [low, high] unit, meaning")
                        unit = next((UNITS[end] for end in UNITS if item.leaf.endswith("_" + end)), None)
                        self.assertIn(unit, (None, item.unit))

    def test_ranges_are_those_of_the_loaders(self):
        checked = 0
        for name in LOADERS:
            limits = ranges(loader(name))
            for item in parameters(name):
                if item.leaf in limits and item.leaf != "minimumScore":
                    checked += 1
                    with self.subTest(item.name, stated=item.range_text, read=limits[item.leaf]):
                        self.assertTrue(any(agree(item.range_text, one) for one in limits[item.leaf]))
        self.assertGreater(checked, 150)

    def test_defaults_lie_in_their_ranges(self):
        for name in LOADERS:
            for item in parameters(name):
                limits = NUMBER.findall(item.range_text)
                if NUMBER.fullmatch(item.default) and len(limits) == 2 and item.is_set:
                    with self.subTest(item.name):
                        self.assertTrue(float(limits[0]) <= float(item.default) <= float(limits[1]))

    def test_differences_are_seen(self):
        self.assertFalse(agree("[0, 5]", (0.0, 6.0)))
        self.assertFalse(agree("[0, 5]", (0.1, 5.0)))
        self.assertTrue(agree("(0, 1]", (1e-7, 1.0)))
        self.assertEqual({"a": [(-3.0, 3.0)]}, ranges('constexpr double kFar = 3.0; reader.read("a", x.a, {-kFar, kFar});'))
        self.assertEqual("b", READ.search('read_named(reader, handle, "b", x, {})')[1])


class Links(unittest.TestCase):
    def test_links_of_pages_lead_somewhere(self):
        for page in tracked("*.md"):
            for target, anchor in LINK.findall(page.read_text()):
                if target.startswith(("http:", "https:", "mailto:")):
                    continue
                file = (page.parent / target).resolve() if target else page
                with self.subTest(page.relative_to(REPO).as_posix(), target=target, anchor=anchor):
                    self.assertTrue(file.exists())
                    if anchor:
                        self.assertIn(anchor, anchors(file))

    def test_paths_of_pages_in_other_files_exist(self):
        wrong = {f"{file.relative_to(REPO)}: {path}" for file in tracked() if file.suffix not in (".png", ".webp", ".svg", ".stl")
                 for path in PATH.findall(file.read_text(errors="ignore")) if not (REPO / path).exists()}
        self.assertEqual(set(), wrong)

    def test_every_page_is_in_the_index(self):
        index = (REPO / "docs/README.md").read_text()
        pages = {file.relative_to(REPO / "docs").as_posix() for file in (REPO / "docs").rglob("*.md")} - {"README.md"}
        self.assertEqual(set(), {page for page in pages if f"]({page})" not in index})

    def test_every_image_is_shown(self):
        shown = "".join(page.read_text() for page in tracked("*.md"))
        names = {file.name for file in (REPO / "docs/images").iterdir()}
        self.assertEqual(set(), {name for name in names if f"images/{name})" not in shown})


if __name__ == "__main__":
    unittest.main()

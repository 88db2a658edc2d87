"""Sources of one library are compiled together: what is anonymous in two of them may not have one name."""

import collections
import pathlib
import re
import tempfile
import unittest

REPO = pathlib.Path(__file__).resolve().parents[2]
LIBRARY = re.compile(r"extperfc_add_library\(\s*(\S+)\s+SOURCES\s+([^)]*?)(?:\s+(?:LINK|PRIVATE_LINK)\b[^)]*)?\)")
VARIABLE = re.compile(r"^(?:inline |static |const |constexpr |thread_local )+[\w:<>,&* ]+?[ &*](\w+)(?:\[[^]]*\])*(?: =|;|\{)")
TYPE = re.compile(r"^(?:class|struct|union|enum|enum class|enum struct) (\w+)\b(?!;)|^using (\w+) =")


def anonymous_names(text):
    """(namespace with a name, name) of the variables and types that the anonymous namespaces of a source define."""
    opened, names = [], []
    for line in text.splitlines():
        start = re.match(r"(?:inline )?namespace ?([\w:]*) \{", line)
        if start:
            opened.append(start.group(1))
        elif re.match(r"\}\s*// (anonymous )?namespace", line) and opened:
            opened.pop()
        elif "" in opened:
            found = VARIABLE.match(line) or TYPE.match(line)
            if found:
                names.append((tuple(opened), next(filter(None, found.groups()))))
    return names


def names_defined_twice(files):
    """'name in first.cpp and second.cpp' of everything anonymous that several of the files define."""
    where = collections.defaultdict(set)
    for file in files:
        for name in anonymous_names(file.read_text()):
            where[name].add(file.name)
    return [f"{name[1]} in {' and '.join(sorted(homes))}" for name, homes in where.items() if len(homes) > 1]


def libraries():
    """(name, sources) of every library that the CMakeLists.txt of the package add."""
    for listing in sorted((REPO / "src").rglob("CMakeLists.txt")):
        for name, sources in LIBRARY.findall(listing.read_text()):
            yield name, [listing.parent / source for source in sources.split() if source.endswith(".cpp")]


class JoinedSourcesTest(unittest.TestCase):
    def test_no_library_defines_an_anonymous_name_twice(self):
        found = list(libraries())
        self.assertGreater(len(found), 20)
        for name, sources in found:
            with self.subTest(library=name):
                self.assertEqual(names_defined_twice(sources), [], "rename one, or give both one home")

    def test_two_sources_with_one_constant_are_found(self):
        with tempfile.TemporaryDirectory() as folder:
            first, second = pathlib.Path(folder, "first.cpp"), pathlib.Path(folder, "second.cpp")
            text = "namespace extperfc {\nnamespace {\n\nconstexpr double kNearM = 2.5;\n\n}  // namespace\n}  // namespace extperfc\n"
            first.write_text(text)
            second.write_text(text)
            self.assertEqual(names_defined_twice([first, second]), ["kNearM in first.cpp and second.cpp"])
            second.write_text(text.replace("kNearM", "kFarM"))
            self.assertEqual(names_defined_twice([first, second]), [])


if __name__ == "__main__":
    unittest.main()

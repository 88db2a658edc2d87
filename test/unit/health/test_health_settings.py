"""Settings of the health node."""

import pathlib
import re
import unittest

import yaml

from extperfc.health import settings

CONFIG = pathlib.Path(__file__).resolve().parents[3] / "config" / "health.yaml"


def shipped():
    return yaml.safe_load(CONFIG.read_text())


class HealthSettings(unittest.TestCase):
    def wrong(self, **changes):
        with self.assertRaises(settings.Wrong) as caught:
            settings.load({**shipped(), **changes})
        return str(caught.exception)

    def test_the_shipped_file_is_right_and_its_ranges_are_those_of_the_code(self):
        found = settings.load(shipped())
        self.assertIn("navigator", [part.name for part in found.parts])
        text = CONFIG.read_text()
        for name, (low, high) in settings.RANGES.items():
            stated = re.search(rf"^{name}: .*# \[([\d.]+), ([\d.]+)\]", text, re.MULTILINE)
            self.assertEqual((low, high), (float(stated[1]), float(stated[2])), name)

    def test_started_parts_only(self):
        found = settings.load({**shipped(), "started": "arm, navigator", "also": ["mapper"]})
        self.assertEqual(["arm", "navigator", "mapper"], [part.name for part in found.parts])

    def test_defaults_of_a_part(self):
        part = settings.load({**shipped(), "parts": {"lidar": {"group": "Drivers", "max_age_s": 9.0}}}).parts[0]
        self.assertEqual(("/lidar", r"/?lidar: .*", False, 9.0), (part.node, part.diagnostics, part.ping, part.max_age_s))
        self.assertEqual(shipped()["hang_s"], part.hang_s)

    def test_names_in_a_namespace(self):
        parts = settings.load({**shipped(), "parts": {"a": {"group": "G"}, "b": {"group": "G", "node": "/far/b"}}}, "/one/").parts
        self.assertEqual([("/one/a", "/?one/a: .*"), ("/far/b", "/?far/b: .*")], [(part.node, part.diagnostics) for part in parts])

    def test_every_error_is_named(self):
        text = self.wrong(hang_s=0, colour="red", started="arm,legs", parts={"arm": {"group": "Arms", "speed": 1, "diagnostics": "("}})
        for expected in ("hang_s must be a number in [1.0, 600.0], not 0", "colour is unknown", "parts has no legs",
                         "parts/arm/speed is unknown", "parts/arm/diagnostics"):
            self.assertIn(expected, text)
        self.assertIn("group", self.wrong(parts={"arm": {}}))
        self.assertIn("no part", self.wrong(parts={}))
        self.assertIn("max_age_s", self.wrong(max_age_s=True))


if __name__ == "__main__":
    unittest.main()

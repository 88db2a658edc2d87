"""What a session reads from the log of a launch."""

import os
import pathlib
import tempfile
import unittest
from unittest import mock

from ros_session import RosSession


class Errors(unittest.TestCase):
    def errors(self, text):
        with tempfile.TemporaryDirectory() as folder, mock.patch.dict(os.environ):
            log = pathlib.Path(folder) / "launch.log"
            log.write_text(text)
            with RosSession(log) as session:
                return session.errors()

    def test_an_error_is_found_without_stamp_and_colour_and_once(self):
        line = "\x1b[31m[ERROR] [1795871649.113828267, 516.4]: map.yaml: cannot be read\x1b[0m\n"
        self.assertEqual(["map.yaml: cannot be read"], self.errors(line + line))

    def test_of_several_lines(self):
        self.assertEqual(["two parameters:\n  a: no number\n  b: below 0"],
                         self.errors("[FATAL] [17.1]: two parameters:\n  a: no number\n  b: below 0\n[ INFO] [17.2]: end\n"))

    def test_after_a_block_of_standard_output_that_ends_within_a_line(self):
        self.assertEqual(["map.yaml: cannot be read"],
                         self.errors("[ INFO] [17.1]: Initializing nodelet with 2 wor[ERROR] [17.2]: map.yaml: cannot be read\nker threads\n"))

    def test_what_is_no_error(self):
        self.assertEqual([], self.errors("[ WARN] [17.1]: late\n[ INFO] [17.2]: no ERROR so far\nREQUIRED process [x] has died!\n"))


if __name__ == "__main__":
    unittest.main()

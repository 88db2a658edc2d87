"""Conversions against genpy, which reads and writes both eras' messages on its own."""

import pathlib
import subprocess
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "translator"))

from harness import eras, processes  # noqa: E402

RULES = processes.REPO / "config" / "translate"
MESSAGES_PER_TYPE = 10


def convert(lines):
    """One answer for each line; see convert_lines.cpp."""
    command = [processes.PROGRAMS / "convert_lines", RULES / "definitions", *sorted(RULES.glob("*.yaml"))]
    text = "".join(line + "\n" for line in lines)
    done = subprocess.run(command, input=text, capture_output=True, text=True, timeout=120)
    if done.returncode != 0:
        raise AssertionError(done.stderr)
    return done.stdout.splitlines()


class Both(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.indigo, cls.noetic = (eras.Era(processes.ERAS / era) for era in ("indigo", "noetic"))
        cls.cases = list(cls.changed_messages()) + list(cls.changed_services())

    @classmethod
    def changed_messages(cls):
        """(part, type, Indigo MD5, Noetic MD5, Indigo class, Noetic class) of what differs; actions are their messages."""
        for name in sorted(cls.indigo.types("msg") & cls.noetic.types("msg")):
            indigo, noetic = cls.indigo.message(name), cls.noetic.message(name)
            if indigo._md5sum != noetic._md5sum:
                yield "msg", name, indigo._md5sum, noetic._md5sum, indigo, noetic

    @classmethod
    def changed_services(cls):
        for name in sorted(cls.indigo.types("srv") & cls.noetic.types("srv")):
            indigo, noetic = cls.indigo.service(name), cls.noetic.service(name)
            if indigo._md5sum != noetic._md5sum:
                yield "req", name, indigo._md5sum, noetic._md5sum, indigo._request_class, noetic._request_class
                yield "res", name, indigo._md5sum, noetic._md5sum, indigo._response_class, noetic._response_class

    def test_everything_that_changed_is_here(self):
        """69 types changed between Indigo and Noetic (5 of them are actions, which are their messages here), 18 that
        are in both between the first and the last SDK of the robot."""
        types = {case[1] for case in self.cases}
        baxter = {name for name in types if name.startswith("baxter")}
        self.assertGreaterEqual(len(types - baxter), 64, sorted(types - baxter))
        self.assertGreaterEqual(len(baxter), 15, sorted(baxter))

    def test_there_and_back(self):
        for forward in (True, False):
            with self.subTest(forward=forward):
                self.one_way(forward)

    def one_way(self, forward):
        cases = [case if forward else (*case[:2], case[3], case[2], case[5], case[4]) for case in self.cases]
        sent = [(case, eras.leave_shapes_where_they_are(eras.RandomContent(seed).message(case[4])))
                for case in cases for seed in range(MESSAGES_PER_TYPE)]
        there = convert(f"{part} {name} {from_md5} {to_md5} {eras.to_hex(message)}"
                        for (part, name, from_md5, to_md5, _, _), message in sent)
        self.check((case, eras.from_hex(case[4], eras.to_hex(message)), case[5], answer)
                   for (case, message), answer in zip(sent, there))
        back = convert(f"{part} {name} {to_md5} {from_md5} {answer[3:]}"
                       for ((part, name, from_md5, to_md5, _, _), _), answer in zip(sent, there))
        self.check((case, eras.from_hex(case[5], between[3:]), case[4], answer)
                   for (case, _), between, answer in zip(sent, there, back))

    def check(self, answers):
        """Every (case, message, class of the answer, answer): the fields that both have are equal."""
        wrong, checked = {}, 0
        for case, given, kind, answer in answers:
            checked += 1
            if not answer.startswith("ok "):
                wrong.setdefault(case[:2], answer)
            elif not eras.same_value(given, eras.from_hex(kind, answer[3:])):
                wrong.setdefault(case[:2], f"{given}\nbecame\n{eras.from_hex(kind, answer[3:])}")
        self.assertEqual(len(self.cases) * MESSAGES_PER_TYPE, checked)
        self.assertEqual({}, wrong)


if __name__ == "__main__":
    unittest.main()

"""tools/lib/recent_changes.py: which modules and sources a run with little time reads first."""

import os
import pathlib
import subprocess
import tempfile
import unittest

import recent_changes

DAY_S = 86400


class Repository:
    """A git repository whose commits have the times that the test gives them."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.git("init", "-q")

    def git(self, *arguments, time_s=0):
        stamp = f"{1700000000 + time_s} +0000"
        environment = dict(os.environ, GIT_AUTHOR_DATE=stamp, GIT_COMMITTER_DATE=stamp)
        subprocess.run(["git", "-c", "user.name=a", "-c", "user.email=a@b", *arguments], cwd=self.folder, check=True,
                       env=environment, stdout=subprocess.DEVNULL)

    def write(self, name):
        file = self.folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(file.read_text() + "x" if file.exists() else "x")

    def commit(self, name, time_s):
        self.write(name)
        self.git("add", name)
        self.git("commit", "-q", "-m", name, time_s=time_s)


class RecentChanges(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.repository = Repository(folder.name)

    def test_two_days_before_the_newest_commit_and_what_is_not_committed(self):
        self.repository.commit("src/arm/old.cpp", 0)
        self.repository.commit("src/scan/edge.cpp", 3 * DAY_S)
        self.repository.commit("src/arm/new.cpp", 4 * DAY_S)
        self.repository.commit("README.md", 4 * DAY_S)
        self.repository.write("src/depth/open.cpp")
        found = recent_changes.changed_files(self.repository.folder)
        self.assertEqual(["src/depth/open.cpp", "src/arm/new.cpp", "src/scan/edge.cpp"], found)

    def test_a_folder_without_git_has_no_changes(self):
        with tempfile.TemporaryDirectory() as folder:
            self.assertEqual([], recent_changes.changed_files(pathlib.Path(folder)))

    def test_modules(self):
        names = ["src/arm/a/b.cpp", "include/extperfc/scan/c.hpp", "test/unit/arm/test_d.cpp", "test/ros/e.cpp", "setup.py"]
        self.assertEqual(["arm", "scan"], recent_changes.modules_of(names))

    def test_every_unchanged_module_has_its_day(self):
        chosen = {recent_changes.in_rotation(["a", "b", "c"], ["b"], day) for day in range(4)}
        self.assertEqual({"a", "c"}, chosen)
        self.assertIsNone(recent_changes.in_rotation(["b"], ["b"], 1))

    def test_a_changed_header_has_its_source_read(self):
        sources = ["src/arm/plan.cpp", "src/arm/move.cpp", "src/scan/plan.cpp"]
        self.assertEqual(["src/arm/plan.cpp"],
                         recent_changes.sources_to_read(["include/extperfc/arm/plan.hpp"], sources))


if __name__ == "__main__":
    unittest.main()

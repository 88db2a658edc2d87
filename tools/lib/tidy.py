"""clang-tidy over the package's own sources, the newest changes first.

A whole reading takes over an hour on two cores, so that a run with a limit reads what is new and says what it left out.
"""

import concurrent.futures
import json
import subprocess
import threading
import time

from test_processes import stepping_aside

FILE_LIMIT_S = 3600  # the largest takes 40 s alone, and much more in the idle moments of a busy run


def newest_first(repo, sources):
    """The sources in order of their last changes, newest first; in their own order where git does not know them."""
    changed = [["diff", "--name-only", "HEAD"], ["log", "--format=", "--name-only"]]
    names = [name for command in changed for name in subprocess.run(
        ["git", *command, "--", "src"], cwd=repo, capture_output=True, text=True).stdout.split()]
    rank = {name: i for i, name in reversed(list(enumerate(names)))}
    return sorted(sources, key=lambda name: rank.get(name, -1))


def compiled(database, sources):
    """(source, its path in the compilation database) of those that are compiled here, in the order of `sources`."""
    paths = {}
    for entry in json.loads(database.read_text()):
        _, found, name = entry["file"].rpartition("/src/extperfc/")
        if found:
            paths.setdefault(name, entry["file"])
    return [(name, paths[name]) for name in sources if name in paths]


class Reading:
    """Reads sources with clang-tidy in `jobs` threads, at the lowest priority, until all are read or `end`
    (time.monotonic()) has come.

    Afterwards `read` and `left_out` hold names, `findings` the texts of what was found, by name."""

    def __init__(self, database, sources, jobs, log):
        self.folder, self.todo = database.parent, compiled(database, sources)
        self.jobs, self.log = jobs, log
        self.read, self.left_out, self.findings = [], [], {}
        self._lock = threading.Lock()

    def run(self, end=float("inf")):
        with concurrent.futures.ThreadPoolExecutor(self.jobs) as team:
            list(team.map(lambda one: self._one(*one, end), self.todo))

    def _one(self, name, path, end):
        if time.monotonic() >= end:
            self._note(self.left_out, name)
            return
        command = stepping_aside(["clang-tidy", "--quiet", "-extra-arg=-std=c++17", "-p", str(self.folder), path])
        begin = time.monotonic()
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, errors="replace",
                                   stdin=subprocess.DEVNULL, start_new_session=True)
        try:
            found, complaints = process.communicate(timeout=max(0.1, min(FILE_LIMIT_S, end - begin)))
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
            if time.monotonic() >= end:
                self._note(self.left_out, name)
                return
            found, complaints = "", f"{name}: error: not read within {FILE_LIMIT_S} s\n"
        finding = (found or complaints) if process.returncode != 0 else ""
        if finding:
            with self._lock:
                self.findings[name] = finding
        self._note(self.read, name, f"{time.monotonic() - begin:6.1f} s  {name}\n{finding}")

    def _note(self, names, name, line=""):
        with self._lock:
            names.append(name)
            if line:
                with open(self.log, "a") as stream:
                    stream.write(line)

"""What changed lately in the repository, so that a run with little time checks that first."""

import pathlib
import subprocess
import time

DAYS = 2  # before the newest commit
SUFFIXES = (".cpp", ".hpp")


def _git(repo, *arguments):
    done = subprocess.run(["git", *arguments], cwd=repo, capture_output=True, text=True)
    return done.stdout.split() if done.returncode == 0 else []


def changed_files(repo):
    """C++ files that are not committed, or that commits within two days of the newest one changed; newest first."""
    newest = _git(repo, "log", "-1", "--format=%ct")
    names = _git(repo, "diff", "--name-only", "HEAD") + _git(repo, "ls-files", "--others", "--exclude-standard")
    if newest:
        since = int(newest[0]) - DAYS * 86400
        names += _git(repo, "log", f"--since=@{since}", "--format=", "--name-only")
    return [name for name in dict.fromkeys(names) if name.endswith(SUFFIXES) and (repo / name).exists()]


def module_of(name):
    """The module that a file belongs to: src/arm/..., include/extperfc/arm/... and test/unit/arm/... are of arm."""
    parts = pathlib.PurePosixPath(name).parts
    for head in (("src",), ("include", "extperfc"), ("test", "unit")):
        if parts[:len(head)] == head and len(parts) > len(head) + 1:
            return parts[len(head)]
    return None


def modules_of(names):
    """Modules of several files, in their order, each once."""
    return [module for module in dict.fromkeys(map(module_of, names)) if module]


def in_rotation(modules, changed, day=None):
    """The one unchanged module whose day it is, so that each has its turn; None when all changed."""
    rest = sorted(set(modules) - set(changed))
    day = int(time.time() // 86400) if day is None else day
    return rest[day % len(rest)] if rest else None


def sources_to_read(changed, sources):
    """Of `sources` (.cpp below src/) those that changed, or whose header changed: one of the same name in their module."""
    wanted = {(module_of(name), pathlib.PurePosixPath(name).stem) for name in changed}
    return [name for name in sources if (module_of(name), pathlib.PurePosixPath(name).stem) in wanted]

"""One line instead of a traceback where a Python module is not installed yet.

A program imports this before anything that a package outside Python's own library brings.
"""

import pathlib
import sys


def _explain(kind, error, traceback):
    if not issubclass(kind, ModuleNotFoundError) or (error.name or "").startswith("extperfc"):
        sys.__excepthook__(kind, error, traceback)
        return
    print(f"{pathlib.Path(sys.argv[0]).stem}: the Python module {error.name} is not installed: run tools/setup --tests, "
          "or install the packages of package.xml", file=sys.stderr)


sys.excepthook = _explain

"""run_tool.py FILE ARGUMENTS...: runs a program of this folder; a Python module that it lacks is said in one line."""

import pathlib
import runpy
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path.append(str(HERE.parents[1] / "src"))

from extperfc import missing_modules  # noqa: E402, F401 (it watches the imports that follow)

if __name__ == "__main__":
    sys.argv = [str(HERE / sys.argv[1]), *sys.argv[2:]]
    runpy.run_path(sys.argv[0], run_name="__main__")

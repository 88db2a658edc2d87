"""Makes the package's generated services importable."""

import pathlib
import sys


def find_services():
    """Adds the generated services to the package's own Python code, which may hide them: `from extperfc.srv import ...`
    works afterwards."""
    import extperfc
    for folder in map(pathlib.Path, sys.path):
        if (folder / "extperfc" / "srv").is_dir() and str(folder / "extperfc") not in extperfc.__path__:
            extperfc.__path__.append(str(folder / "extperfc"))

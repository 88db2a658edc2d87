"""Subcommands of extperfc-train: every module here with add_arguments(parser) and run(options) -> exit code.

A module's docstring is its help; its first line, the one in the list. Modules import what is heavy in run().
"""

import argparse
import importlib
import pkgutil
import sys

from ..errors import UserError

REMEDY = (
    "run tools/setup --training; elsewhere: python3 -m pip install torch torchvision opencv-python-headless matplotlib"
    " pyyaml pycocotools")


def modules():
    """{name: module} of all subcommands."""
    return {item.name: importlib.import_module(f"{__name__}.{item.name}") for item in pkgutil.iter_modules(__path__)}


def make_parser(found):
    """The command line of all subcommands."""
    top = argparse.ArgumentParser(prog="extperfc-train",
                                  description="Trains detection networks on your own objects, and"
                                  " says how good they are. Guide: docs/training.md.")
    commands = top.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for name, module in sorted(found.items()):
        text = module.__doc__.strip()
        parser = commands.add_parser(name,
                                     help=text.splitlines()[0],
                                     description=text,
                                     epilog=getattr(module, "EPILOG", None),
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
        module.add_arguments(parser)
    return top


def main(arguments=None):
    """Runs one subcommand. Bad input is one message on stderr and exit code 2; Ctrl-C gives 130."""
    found = modules()
    options = make_parser(found).parse_args(arguments)
    try:
        return found[options.command].run(options)
    except ImportError as error:
        print(f"extperfc-train: {error}; {REMEDY}", file=sys.stderr)
    except (UserError, OSError) as error:
        print(f"extperfc-train: {error}", file=sys.stderr)
    except KeyboardInterrupt:
        print("extperfc-train: interrupted; --resume goes on", file=sys.stderr)
        return 130
    return 2

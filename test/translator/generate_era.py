#!/usr/bin/env python3
"""Makes the message classes of one era: Python packages with genpy and C++ headers with gencpp.

  generate_era.py --out DIR --definitions TREE [--definitions TREE ...] --packages NAME ... [--cpp package/Type ...]

A TREE holds <package>/{msg,srv,action}/*; the first that has a file counts, and what the trees do not have comes from
the distribution's share folders. DIR/tree is the merged tree with the messages that actions stand for, DIR/python the
packages that differ from the distribution's, DIR/include the headers of the types named and of what they embed.
"""

import argparse
import importlib.util
import pathlib
import runpy
import shutil
import sys

import genmsg
import genmsg.template_tools
import genpy.generate_initpy
import genpy.generator

PACKAGE_ROOTS = [place for place in (pathlib.Path("/opt/ros/noetic/share"), pathlib.Path("/usr/share")) if place.is_dir()]
GENACTION = [pathlib.Path("/opt/ros/noetic/share/actionlib_msgs/../../lib/actionlib_msgs/genaction.py"),
             pathlib.Path("/usr/lib/actionlib_msgs/genaction.py")]
MESSAGE_TEMPLATES = {"msg.h.template": "@NAME@.h"}
SERVICE_TEMPLATES = {"srv.h.template": "@NAME@.h"}


def system_package(package):
    """The distribution's folder of a package, or None."""
    return next((root / package for root in PACKAGE_ROOTS if (root / package / "package.xml").exists()), None)


def merge_trees(trees, packages, out):
    """Copies the packages' definitions, the first tree's first; then what the distribution has of them."""
    for package in packages:
        places = [tree / package for tree in trees] + [system_package(package) or out / "none"]
        for place in places:
            for file in sorted(place.glob("*/*")):
                target = out / package / file.parent.name / file.name
                if file.parent.name in ("msg", "srv", "action") and not target.exists():
                    target.parent.mkdir(parents=True, exist_ok=True)
                    shutil.copyfile(file, target)


def expand_action(file):
    """The seven messages that an action stands for."""
    script = next(place for place in GENACTION if place.exists())
    arguments, sys.argv = sys.argv, [str(script), str(file), "-o", str(file.parent.parent / "msg")]
    try:
        runpy.run_path(str(script), run_name="__main__")
    finally:
        sys.argv = arguments


def is_ours(package, tree):
    """True when the distribution lacks the package or its Python classes, or has another version of a definition."""
    installed = system_package(package)
    if installed is None or importlib.util.find_spec(package) is None:
        return True
    ours = [file for file in (tree / package).glob("*/*") if file.suffix in (".msg", ".srv")]
    return any(not (installed / file.relative_to(tree / package)).exists()
               or layout(file) != layout(installed / file.relative_to(tree / package)) for file in ours)


def layout(file):
    """What the MD5 of a definition stands on, embedded types aside: its lines without comments and spacing."""
    lines = (" ".join(line.split("#")[0].split()) for line in file.read_text(errors="replace").splitlines())
    return sorted(line.replace(" = ", "=").replace("std_msgs/Header ", "Header ") for line in lines if line)


def search_path(tree):
    """Where genmsg finds embedded types: package -> folders."""
    found = {}
    for root in PACKAGE_ROOTS:
        for folder in root.glob("*/msg"):
            found.setdefault(folder.parent.name, [str(folder)])
    found.update({folder.parent.name: [str(folder)] for folder in tree.glob("*/msg")})
    return found


def write_python(package, tree, out, search):
    for kind, generator in (("msg", genpy.generator.MsgGenerator()), ("srv", genpy.generator.SrvGenerator())):
        files = [str(file) for file in sorted((tree / package / kind).glob("*." + kind))]
        if files:
            folder = out / package / kind
            if generator.generate_messages(package, files, str(folder), search) != 0:
                raise SystemExit(f"error: no Python classes of {package}: see above")
            genpy.generate_initpy.write_modules(str(folder))
    (out / package).mkdir(parents=True, exist_ok=True)
    (out / package / "__init__.py").touch()


def embedded(type_name, tree):
    """The file of a type and the types it embeds; nothing when the tree does not have it."""
    package, name = type_name.split("/")
    for kind in ("msg", "srv"):
        file = tree / package / kind / f"{name}.{kind}"
        if file.exists():
            context = genmsg.MsgContext.create_default()
            if kind == "srv":
                spec = genmsg.msg_loader.load_srv_from_file(context, str(file), type_name)
                types = spec.request.types + spec.response.types
            else:
                types = genmsg.msg_loader.load_msg_from_file(context, str(file), type_name).types
            bases = {genmsg.msgs.bare_msg_type(t) for t in types}
            return file, {t for t in bases if not genmsg.msgs.is_builtin(t) and not genmsg.msgs.is_header_type(t)}
    return None, set()


def write_headers(types, tree, ours, out, search):
    templates = next(root / "gencpp" for root in PACKAGE_ROOTS if (root / "gencpp").is_dir())
    includes = [f"{package}:{folder}" for package, folders in search.items() for folder in folders]
    waiting, done = list(types), set()
    while waiting:
        type_name = waiting.pop()
        if type_name in done:
            continue
        done.add(type_name)
        file, inside = embedded(type_name, tree)
        waiting += inside
        package = type_name.split("/")[0]
        if file is not None and package in ours:
            genmsg.template_tools.generate_from_file(str(file), package, str(out / package), str(templates), includes,
                                                     MESSAGE_TEMPLATES, SERVICE_TEMPLATES)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--definitions", type=pathlib.Path, action="append", required=True)
    parser.add_argument("--packages", nargs="+", required=True)
    parser.add_argument("--cpp", nargs="*", default=[], metavar="package/Type")
    options = parser.parse_args()
    for folder in ("tree", "python", "include"):
        shutil.rmtree(options.out / folder, ignore_errors=True)
        (options.out / folder).mkdir(parents=True)
    tree = options.out / "tree"
    merge_trees(options.definitions, options.packages, tree)
    for file in sorted(tree.glob("*/action/*.action")):
        expand_action(file)
    ours = [package for package in options.packages if is_ours(package, tree)]
    search = search_path(tree)
    for package in ours:
        write_python(package, tree, options.out / "python", search)
    write_headers(options.cpp, tree, ours, options.out / "include", search)
    print(f"classes of {len(ours)} packages in {options.out}")


if __name__ == "__main__":
    main()

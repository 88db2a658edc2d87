"""checks labelled images and reports everything that is wrong with them

Reads a Pascal VOC folder or COCO files with every image: missing and unreadable files, empty, inverted and outlying
boxes, unknown classes, images that are there twice or look alike, and images that two splits have in common. Exit code
1 when there are errors.
"""

import json
import pathlib


def add_arguments(parser):
    parser.add_argument("data", type=pathlib.Path, help="Pascal VOC folder, COCO file or folder")
    parser.add_argument("--json", type=pathlib.Path, metavar="FILE", help="also write the report here")
    parser.add_argument("--quiet", action="store_true", help="no warnings")


def run(options):
    import dataclasses

    from ..data.validation import check
    report = check(options.data)
    if options.quiet:
        report = dataclasses.replace(report, problems=tuple(report.errors))
    print(report.text())
    if options.json:
        options.json.write_text(json.dumps(report.as_dict(), indent=1) + "\n")
    return 1 if report.errors else 0

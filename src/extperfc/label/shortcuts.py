"""The table of keys and gestures: the window's actions, its help and docs/labelling.md follow it."""

import collections

# action: method of the window, None for a gesture of the mouse. keys: Qt's names; the first one stands in the menus.
Shortcut = collections.namedtuple("Shortcut", "section action keys text")

SHORTCUTS = [
    Shortcut("Images", "next_image", ("PgDown", "."), "next image of the list"),
    Shortcut("Images", "previous_image", ("PgUp", ","), "previous image of the list"),
    Shortcut("Images", "next_unlabelled", ("U",), "next unlabelled image"),
    Shortcut("Images", "previous_unlabelled", ("Shift+U",), "previous unlabelled image"),
    Shortcut("Images", "first_image", ("Home",), "first image of the list"),
    Shortcut("Images", "last_image", ("End",), "last image of the list"),
    Shortcut("Images", "toggle_empty", ("E",), "mark as without objects, or as unlabelled again"),
    Shortcut("Images", "focus_search", ("Ctrl+F",), "search by name"),
    Shortcut("Boxes", None, ("drag on free space",), "draw a box"),
    Shortcut("Boxes", None, ("Shift+drag",), "draw a box on top of another one"),
    Shortcut("Boxes", None, ("drag inside", "drag an edge"), "move or resize a box"),
    Shortcut("Boxes", None, ("Ctrl+click",), "select one box more, or one less"),
    Shortcut("Boxes", "new_box", ("B",), "new box in the middle of the view"),
    Shortcut("Boxes", "select_next", ("Tab",), "select the next box"),
    Shortcut("Boxes", "select_previous", ("Shift+Tab",), "select the previous box"),
    Shortcut("Boxes", "select_all", ("Ctrl+A",), "select all boxes"),
    Shortcut("Boxes", "cancel", ("Esc",), "end drawing, drop proposals, select nothing"),
    Shortcut("Boxes", "delete_boxes", ("Del", "Backspace"), "delete the selected boxes"),
    Shortcut("Boxes", None, ("arrows",), "move the selected boxes by 1 px, with Shift by 10"),
    Shortcut("Boxes", None, ("left and right arrow",), "without a selected box: previous or next image"),
    Shortcut("Boxes", None, ("Alt+arrows",), "move their right or lower edge by 1 px, with Shift by 10"),
    Shortcut("Boxes", "copy_boxes", ("Ctrl+C",), "copy the selected boxes, or all"),
    Shortcut("Boxes", "paste_boxes", ("Ctrl+V",), "paste them, on any image"),
    Shortcut("Boxes", "copy_to_next", ("C",), "copy the selected boxes, or all, to the next image and go there"),
    Shortcut("Boxes", "undo", ("Ctrl+Z",), "undo, without limit and across images"),
    Shortcut("Boxes", "redo", ("Ctrl+Shift+Z", "Ctrl+Y"), "redo"),
    Shortcut("Classes and flags", None, ("1", "...", "9"), "class of new boxes, and of the selected ones"),
    Shortcut("Classes and flags", "add_class", ("N",), "new class"),
    Shortcut("Classes and flags", "toggle_difficult", ("D",),
             "difficult: hard to recognise, not counted in evaluations"),
    Shortcut("Classes and flags", "toggle_truncated", ("T",), "truncated: reaches beyond the image"),
    Shortcut("Classes and flags", "toggle_occluded", ("O",), "occluded: another object hides a part"),
    Shortcut("Proposals", "propose", ("P",), "let the network propose boxes"),
    Shortcut("Proposals", "accept_proposals", ("Return", "Enter"), "accept all proposed boxes"),
    Shortcut("Proposals", None, ("click on a dashed box",), "accept this one"),
    Shortcut("Proposals", "toggle_auto_propose", ("Ctrl+P",), "propose by itself on every unlabelled image"),
    Shortcut("Proposals", "choose_model", ("Ctrl+M",), "choose a model folder"),
    Shortcut("View", None, ("wheel",), "zoom"),
    Shortcut("View", None, ("middle button", "Space+drag"), "move the view"),
    Shortcut("View", "zoom_in", ("+", "="), "zoom in"),
    Shortcut("View", "zoom_out", ("-",), "zoom out"),
    Shortcut("View", "zoom_fit", ("0",), "whole image"),
    Shortcut("View", "toggle_boxes", ("H",), "hide or show the boxes"),
    Shortcut("View", "toggle_names", ("L",), "hide or show their names"),
    Shortcut("Program", "show_statistics", ("Ctrl+I",), "statistics"),
    Shortcut("Program", "export_coco", ("Ctrl+E",), "export as COCO"),
    Shortcut("Program", "import_coco", ("Ctrl+Shift+E",), "import from COCO"),
    Shortcut("Program", "show_help", ("F1", "?"), "these keys"),
    Shortcut("Program", "close", ("Ctrl+Q",), "close; everything is saved already"),
]


def by_section():
    """{section: its shortcuts}, in the order of the table."""
    sections = {}
    for one in SHORTCUTS:
        sections.setdefault(one.section, []).append(one)
    return sections


def keys_text(shortcut):
    """The keys as a reader knows them."""
    names = {"PgDown": "Page Down", "PgUp": "Page Up", "Del": "Delete", "Return": "Enter"}
    return ", ".join(dict.fromkeys(names.get(key, key) for key in shortcut.keys)).replace(", ...,", " to")

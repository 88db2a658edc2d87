"""Which images of a document a list shows."""

ALL, UNLABELLED, LABELLED, EMPTY, DIFFICULT, TRUNCATED = (
    "all images", "unlabelled", "labelled", "labelled, without objects", "with a difficult box", "with a truncated box")
GENERAL = (ALL, UNLABELLED, LABELLED, EMPTY, DIFFICULT, TRUNCATED)
CLASS_PREFIX = "with "


def choices(classes):
    """Names of all filters: the general ones, then one for each class."""
    return [*GENERAL, *(CLASS_PREFIX + name for name in classes)]


def _fits(document, name, choice):
    boxes = document.boxes(name)
    if choice == ALL:
        return True
    if choice in (UNLABELLED, LABELLED):
        return document.is_labelled(name) == (choice == LABELLED)
    if choice == EMPTY:
        return document.is_labelled(name) and not boxes
    if choice in (DIFFICULT, TRUNCATED):
        return any(box.difficult if choice == DIFFICULT else box.truncated for box in boxes)
    return any(box.name == choice[len(CLASS_PREFIX):] for box in boxes)


def shown(document, choice=ALL, text=""):
    """Names of the images that fit a filter of choices() and contain a text, in the folder's order."""
    return [name for name in document.names if text.lower() in name.lower() and _fits(document, name, choice)]


def next_unlabelled(document, name, step=1):
    """The nearest unlabelled image behind (step 1) or before (-1) one, beginning again at the other end; None
    without any."""
    names = document.names
    start = names.index(name)
    for offset in range(1, len(names) + 1):
        candidate = names[(start + step * offset) % len(names)]
        if not document.is_labelled(candidate):
            return candidate
    return None

"""The labels of a folder while they are edited: every change can be undone and is on the disk before the next one."""

import collections
import dataclasses
import shutil

from extperfc.atomic_files import WriteError
from extperfc.label import voc
from extperfc.label.boxes import clipped
from extperfc.label.folder import FolderError, image_size


@dataclasses.dataclass(frozen=True)
class Change:
    """One step of the history: the boxes of one image before and after. None stands for an unlabelled image."""

    name: str
    title: str
    before: tuple | None
    after: tuple | None
    merge_key: object = None


class Document:
    """Boxes of all images of a folder.ImageFolder, and the history of their changes.

    A change is written at once. If that fails, the boxes stay in memory, `unsaved` names the images with the reason,
    and retry() or the next change tries again. Memory: a few hundred bytes for each box and step; the history has no
    limit.
    """

    def __init__(self, folder):
        self.folder = folder
        self.unsaved = {}  # reason by name of the image
        self.damaged = {}  # what is wrong with the annotation file, by name of the image
        self._annotations, self._states, self._sizes = {}, {}, {}
        self._done, self._undone = [], []
        for name in folder.names:
            self._load(name)

    @property
    def names(self):
        return self.folder.names

    def boxes(self, name):
        """The boxes of an image; empty for one without objects and for an unlabelled one."""
        return self._states[name] or ()

    def is_labelled(self, name):
        """True also for an image that was marked as one without objects."""
        return self._states[name] is not None

    def size(self, name):
        """(width, height) of an image [px]. Raises FolderError when it cannot be read."""
        if name not in self._sizes:
            self._sizes[name] = image_size(self.folder.files[name])
        return self._sizes[name]

    def classes(self):
        """Class names: those of labels.txt, then others that boxes have."""
        found = dict.fromkeys(self.folder.classes)
        found.update(dict.fromkeys(box.name for state in self._states.values() for box in state or ()))
        return list(found)

    def counts(self):
        """{class: number of its boxes in the folder}."""
        return collections.Counter(box.name for state in self._states.values() for box in state or ())

    def change(self, name, boxes, title, merge_key=None):
        """Gives an image these boxes (None: makes it unlabelled). Successive changes with the same merge_key are one
        step of the history. Returns False, without a step, when nothing is different."""
        after = None if boxes is None else tuple(boxes)
        if after == self._states[name]:
            return False
        step = Change(name, title, self._states[name], after, merge_key)
        last = self._done[-1] if self._done and not self._undone else None
        if last and merge_key is not None and (last.name, last.merge_key) == (name, merge_key):
            self._done[-1] = dataclasses.replace(last, after=after)
        else:
            self._done.append(step)
        self._undone.clear()
        self._set(name, after)
        return True

    def undo(self):
        """Takes the last change back. Returns it, or None without one."""
        return self._travel(self._done, self._undone, lambda step: step.before)

    def redo(self):
        """Makes the change that was taken back last. Returns it, or None without one."""
        return self._travel(self._undone, self._done, lambda step: step.after)

    @property
    def next_undo(self):
        return self._done[-1] if self._done else None

    @property
    def next_redo(self):
        return self._undone[-1] if self._undone else None

    def retry(self):
        """Writes again what could not be written. Returns True when everything is on the disk."""
        for name in list(self.unsaved):
            self._save(name)
        return not self.unsaved

    def annotation(self, name):
        """What the annotation file of an image holds, or would hold."""
        width, height = self.size(name)
        known = self._annotations.get(name) or voc.Annotation(self.folder.files[name].name, width, height)
        return dataclasses.replace(known, width=width, height=height, boxes=self.boxes(name),
                                   filename=self.folder.files[name].name)

    def _load(self, name):
        found = state = None
        try:
            found = self.folder.load(name)
            state = None if found is None else self._inside(name, found)
        except (voc.FormatError, FolderError) as error:
            self.damaged[name] = str(error)
        self._annotations[name], self._states[name] = found, state

    def _inside(self, name, annotation):
        size = (annotation.width, annotation.height)
        width, height = size if min(size) > 0 else self.size(name)
        return tuple(box for box in (clipped(one, width, height) for one in annotation.boxes) if box)

    def _travel(self, source, target, state_of):
        if not source:
            return None
        step = source.pop()
        target.append(step)
        self._set(step.name, state_of(step))
        return step

    def _set(self, name, state):
        self._states[name] = state
        self._save(name)
        if self.unsaved:
            self.retry()

    def _save(self, name):
        try:
            self._keep_damaged(name)
            if self._states[name] is None:
                self.folder.remove(name)
            else:
                self.folder.save(name, self.annotation(name))
            self.unsaved.pop(name, None)
        except (WriteError, FolderError) as error:
            self.unsaved[name] = str(error)

    def _keep_damaged(self, name):
        """Before a file that could not be read is replaced, it gets another name."""
        if name not in self.damaged:
            return
        file = self.folder.annotation_file(name)
        try:
            shutil.copy2(file, file.with_suffix(".xml.damaged"))
        except OSError as error:
            raise WriteError(
                f"cannot keep a copy of {file}: {error.strerror}; free some space or move the file away") from None
        del self.damaged[name]

"""The labelling window: joins the document, the image and the lists. Every edit is on the disk when its method
returns."""

import pathlib

from PyQt5.QtCore import Qt, QTimer
from PyQt5.QtGui import QKeySequence, QPixmap
from PyQt5.QtWidgets import (QAction, QFileDialog, QHBoxLayout, QInputDialog, QLabel, QMainWindow, QMessageBox,
                             QShortcut, QVBoxLayout, QWidget)

from extperfc.atomic_files import WriteError
from extperfc.label import coco, editing, filters, shortcuts, statistics
from extperfc.label.canvas import Canvas
from extperfc.label.dialogs import HelpDialog, StatisticsDialog
from extperfc.label.folder import FolderError
from extperfc.label.panels import BoxPanel, ImagePanel
from extperfc.label.proposals import Proposer

RETRY_MS = 3000  # between attempts to write what could not be written
MESSAGE_MS = 6000
ZOOM_STEP = 1.25
TOOLBAR = ("previous_image", "next_image", "next_unlabelled", None, "undo", "redo", None, "copy_to_next", "propose",
           "accept_proposals", None, "zoom_fit", None, "show_statistics", "show_help")
BUTTON_TEXTS = {
    "previous_image": "◀ Previous", "next_image": "Next ▶", "next_unlabelled": "Next unlabelled", "undo": "Undo",
    "redo": "Redo", "copy_to_next": "Copy to next", "propose": "Propose", "accept_proposals": "Accept all", "zoom_fit":
    "Fit", "show_statistics": "Statistics", "show_help": "Keys"
}


class LabelWindow(QMainWindow):
    """Shows and edits a document.Document."""

    def __init__(self, document, model=None):
        super().__init__()
        self.document, self.current = document, None
        self._copied, self._auto_propose = (), False
        self.proposer = Proposer(self)
        self.proposer.choose(model)
        self.canvas, self.images, self.panel = Canvas(), ImagePanel(document), BoxPanel()
        self.banner, self.pointer, self.model_note = QLabel(), QLabel(), QLabel()
        self._retry = QTimer(self)
        self._retry.setInterval(RETRY_MS)
        self._arrange()
        self._make_actions()
        self._connect()
        self._choose_class((document.classes() or ["object"])[0])
        self._show_model()
        self._refilter()
        names = document.names
        self.show_image(
            names[0] if not document.is_labelled(names[0]) else filters.next_unlabelled(document, names[0]) or names[0])

    # Construction.

    def _arrange(self):
        self.setWindowTitle(f"{self.document.folder.path.resolve().name} - extperfc-label")
        self.banner.setProperty("banner", True)
        self.banner.setProperty("wordWrap", True)
        self.banner.hide()
        middle, column, row = QWidget(), QVBoxLayout(), QHBoxLayout()
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        column.addWidget(self.banner)
        column.addWidget(self.canvas, 1)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(0)
        row.addWidget(self.images)
        row.addLayout(column, 1)
        row.addWidget(self.panel)
        middle.setLayout(row)
        self.setCentralWidget(middle)
        self.statusBar().addPermanentWidget(self.model_note)
        self.statusBar().addPermanentWidget(self.pointer)
        self.resize(1200, 800)

    def _make_actions(self):
        """Menus, tool bar and keys from the table in shortcuts.py."""
        self.actions_by_name = {}
        for section, rows in shortcuts.by_section().items():
            menu = self.menuBar().addMenu(section)
            for row in rows:
                if row.action:
                    menu.addAction(self._make_action(row))
        bar = self.addToolBar("Actions")
        bar.setMovable(False)
        bar.setContextMenuPolicy(Qt.PreventContextMenu)
        for name in TOOLBAR:
            if name is None:
                bar.addSeparator()
            else:
                action = self.actions_by_name[name]
                action.setIconText(BUTTON_TEXTS[name])
                bar.addAction(action)
                bar.widgetForAction(action).setFocusPolicy(Qt.NoFocus)
        for number in range(1, 10):
            QShortcut(QKeySequence(str(number)), self, lambda index=number - 1: self._choose_class_number(index))

    def _make_action(self, row):
        action = QAction(row.text[0].upper() + row.text[1:], self)
        action.setShortcuts([QKeySequence(key) for key in row.keys])
        action.setToolTip(f"{row.text} ({shortcuts.keys_text(row)})")
        action.triggered.connect(lambda _=False, method=getattr(self, row.action): method())
        self.actions_by_name[row.action] = action
        return action

    def _connect(self):
        self.canvas.edited.connect(self._on_edited)
        self.canvas.selection_changed.connect(self._show_boxes_in_panel)
        self.canvas.proposal_clicked.connect(self._accept_one)
        self.canvas.page_wanted.connect(self._page)
        self.canvas.pointer_moved.connect(self._show_pointer)
        self.images.chosen.connect(self.show_image)
        self.images.filter_changed.connect(self._refilter)
        self.panel.class_chosen.connect(self._choose_class)
        self.panel.class_wanted.connect(self.add_class)
        self.panel.boxes_chosen.connect(self.canvas.select)
        self.panel.flag_toggled.connect(self._toggle)
        self.proposer.proposed.connect(self._on_proposed)
        self.proposer.failed.connect(self._on_propose_failed)
        self._retry.timeout.connect(self._retry_saving)

    # Images.

    def show_image(self, name):
        """Shows an image with its boxes."""
        self._retry_saving()
        is_other, self.current = name != self.current, name
        pixmap = QPixmap(str(self.document.folder.files[name]))
        self.canvas.show_image(pixmap, self.document.boxes(name), not pixmap.isNull())
        if is_other:
            self._refilter()
        self.images.show_current(name)
        self._show_state()
        if pixmap.isNull():
            self.say(
                f"{self.document.folder.files[name].name} is damaged or no image: remove it, or convert it to JPEG "
                f"or PNG"
            )
        elif name in self.document.damaged:
            self.say(f"{self.document.damaged[name]}. With the first change here a copy is kept as {name}.xml.damaged")
        if self._auto_propose and self.canvas.is_editable and not self.document.is_labelled(name):
            self.propose()
        self.canvas.setFocus()

    def _page(self, step):
        names = self.images.model.names
        if not names:
            self.say("no image fits the filter: choose another one")
        elif self.current not in names:
            self.show_image(names[0])
        elif 0 <= names.index(self.current) + step < len(names):
            self.show_image(names[names.index(self.current) + step])
        else:
            self.say("this is the last image of the list" if step > 0 else "this is the first image of the list")

    def next_image(self):
        self._page(1)

    def previous_image(self):
        self._page(-1)

    def first_image(self):
        if self.images.model.names:
            self.show_image(self.images.model.names[0])

    def last_image(self):
        if self.images.model.names:
            self.show_image(self.images.model.names[-1])

    def next_unlabelled(self):
        self._go_to_unlabelled(1)

    def previous_unlabelled(self):
        self._go_to_unlabelled(-1)

    def _go_to_unlabelled(self, step):
        name = filters.next_unlabelled(self.document, self.current, step)
        if name is None:
            self.say("every image is labelled")
        else:
            self.show_image(name)

    def toggle_empty(self):
        if not self.canvas.is_editable:
            self.say("this image cannot be shown, so it cannot be labelled")
        elif self.canvas.boxes:
            self.say("this image has boxes: delete them first (Ctrl+A, Delete)")
        elif self.document.is_labelled(self.current):
            self._change(None, "mark as unlabelled")
        else:
            self._change((), "mark as without objects")

    def focus_search(self):
        self.images.search.setFocus()
        self.images.search.selectAll()

    def _leave_search(self):
        if self.images.model.names and self.current not in self.images.model.names:
            self.show_image(self.images.model.names[0])
        self.canvas.setFocus()

    def _refilter(self):
        shown = filters.shown(self.document, self.images.filter.currentText(), self.images.search.text())
        self.images.show_names(shown, self.current)

    # Boxes.

    def _on_edited(self, boxes, selection, title, merge_key):
        if title == "draw" and not self.document.classes():
            self.add_class()
            boxes = editing.with_class(boxes, selection, self.canvas.current_class)
        if title == "draw" and self.canvas.current_class not in self.document.folder.classes:
            self._keep_class(self.canvas.current_class)
        self._change(boxes, title, selection, merge_key)

    def _change(self, boxes, title, selection=frozenset(), merge_key=None):
        self.document.change(self.current, boxes, title, merge_key)
        self.canvas.show_boxes(self.document.boxes(self.current), selection)
        self._show_state()

    def _edit_selected(self, title, edit):
        """Changes the selected boxes, which stay selected."""
        if not self.canvas.selection:
            self.say("select a box first: click it, or press Tab")
            return
        self._change(edit(self.canvas.boxes, self.canvas.selection), title, set(self.canvas.selection))

    def new_box(self):
        if not self.canvas.is_editable:
            return
        port, size = self.canvas.viewport, self.canvas.image_size
        left, top = port.to_image(0, 0)
        right, bottom = port.to_image(*port.view)
        left, top, right, bottom = max(left, 0), max(top, 0), min(right, size[0]), min(bottom, size[1])
        x, y, w, h = (left + right) / 2, (top + bottom) / 2, (right - left) / 8, (bottom - top) / 8
        box = editing.drawn(self.canvas.current_class, (x - w, y - h), (x + w, y + h), size)
        if box:
            self._on_edited((*self.canvas.boxes, box), {len(self.canvas.boxes)}, "draw", None)

    def select_next(self):
        self.canvas.select_step(1)

    def select_previous(self):
        self.canvas.select_step(-1)

    def select_all(self):
        self.canvas.select(range(len(self.canvas.boxes)))

    def cancel(self):
        if not self.canvas.cancel():
            if self.canvas.proposals:
                self.canvas.show_proposals([])
            else:
                self.canvas.select(set())
        self.canvas.setFocus()

    def delete_boxes(self):
        if self.canvas.selection:
            self._change(editing.without(self.canvas.boxes, self.canvas.selection), "delete")
        else:
            self.say("select a box first: click it, or press Tab")

    def _selected_or_all(self):
        chosen = self.canvas.selection or range(len(self.canvas.boxes))
        return tuple(self.canvas.boxes[i] for i in sorted(chosen))

    def copy_boxes(self):
        self._copied = self._selected_or_all()
        self.say(f"copied: {len(self._copied)}")

    def paste_boxes(self):
        if not self.canvas.is_editable:
            return
        boxes, added = editing.with_added(self.canvas.boxes, self._copied, self.canvas.image_size)
        if added:
            self._change(boxes, "paste", added)
        else:
            self.say("there is no copied box that is not here already: copy with Ctrl+C")

    def copy_to_next(self):
        copied, before = self._selected_or_all(), self.current
        self._page(1)
        if self.current == before:
            return
        self._copied = copied
        self.paste_boxes()

    def undo(self):
        self._travel(self.document.undo(), "undone", lambda step: step.before)

    def redo(self):
        self._travel(self.document.redo(), "done again", lambda step: step.after)

    def _travel(self, step, what, state_of):
        if step is None:
            self.say("there is nothing more to undo" if what == "undone" else "there is nothing more to redo")
            return
        if step.name != self.current:
            self.show_image(step.name)
        other = step.after if state_of(step) is step.before else step.before
        fresh = {i for i, box in enumerate(state_of(step) or ()) if box not in (other or ())}
        self.canvas.show_boxes(self.document.boxes(step.name), fresh)
        self._show_state()
        self.say(f"{what}: {step.title}")

    # Classes and flags.

    def _choose_class_number(self, index):
        classes = self.document.classes()
        if index < len(classes):
            self._choose_class(classes[index])
        else:
            self.say(f"there is no class {index + 1}: add one with N")

    def _choose_class(self, name):
        self.canvas.current_class = name
        if self.canvas.selection:
            self._edit_selected("class", lambda boxes, selection: editing.with_class(boxes, selection, name))
        self._show_classes()

    def add_class(self):
        name, accepted = QInputDialog.getText(self, "New class", "Name of the class:")
        if accepted and self._keep_class(name):
            self._choose_class(name.strip())

    def _keep_class(self, name):
        """Writes a class into labels.txt. Returns False, with a message, where that is impossible."""
        try:
            self.document.folder.add_class(name)
        except (FolderError, WriteError) as error:
            self.say(str(error))
            return False
        self._show_classes()
        self.images.show_classes(self.document.classes())
        return True

    def toggle_difficult(self):
        self._toggle("difficult")

    def toggle_truncated(self):
        self._toggle("truncated")

    def toggle_occluded(self):
        self._toggle("occluded")

    def _toggle(self, flag):
        self._edit_selected(flag, lambda boxes, selection: editing.with_flag_toggled(boxes, selection, flag))

    # Proposals.

    def propose(self):
        if not self.proposer.model:
            self.choose_model()
        if self.proposer.model and self.canvas.is_editable:
            self.say("searching ...")
            self.proposer.request(self.current, self.document.folder.files[self.current], self.canvas.boxes)

    def _on_proposed(self, name, found):
        if name != self.current:
            return
        self.canvas.show_proposals(found)
        self.say(f"{len(found)} proposed: Enter accepts all, a click accepts one"
                 if found else "the network finds nothing more")

    def _on_propose_failed(self, message):
        self._auto_propose = False
        self._show_model()
        self.say(message, 0)

    def accept_proposals(self):
        if self.images.search.hasFocus():  # where Enter ends the search
            self._leave_search()
            return
        self._accept([box for box, _ in self.canvas.proposals])

    def _accept_one(self, index):
        self._accept([self.canvas.proposals[index][0]])

    def _accept(self, accepted):
        if not accepted:
            self.say("there are no proposals: press P")
            return
        rest = [one for one in self.canvas.proposals if one[0] not in accepted]
        for name in dict.fromkeys(box.name for box in accepted):
            self._keep_class(name)
        boxes, added = editing.with_added(self.canvas.boxes, accepted, self.canvas.image_size)
        self._change(boxes, "accept proposals", added)
        self.canvas.show_proposals(rest)

    def toggle_auto_propose(self):
        self._auto_propose = not self._auto_propose
        self._show_model()
        if self._auto_propose and not self.document.is_labelled(self.current):
            self.propose()

    def choose_model(self):
        folder = QFileDialog.getExistingDirectory(self, "Model folder (with a model.yaml)")
        if folder:
            self.proposer.choose(pathlib.Path(folder))
            self._show_model()

    def _show_model(self):
        if self.proposer.model:
            name = pathlib.Path(self.proposer.model).resolve().name
            self.model_note.setText(f"network: {name}{', by itself' if self._auto_propose else ''}")

    # View.

    def zoom_in(self):
        self._zoom(ZOOM_STEP)

    def zoom_out(self):
        self._zoom(1 / ZOOM_STEP)

    def _zoom(self, factor):
        self.canvas.viewport.zoom(factor)
        self.canvas.update()

    def zoom_fit(self):
        self.canvas.viewport.fit()
        self.canvas.update()

    def toggle_boxes(self):
        self.canvas.shows_boxes = not self.canvas.shows_boxes
        self.canvas.update()

    def toggle_names(self):
        self.canvas.shows_names = not self.canvas.shows_names
        self.canvas.update()

    # Program.

    def show_statistics(self):
        StatisticsDialog(statistics.count(self.document), self).exec_()

    def show_help(self):
        HelpDialog(self).exec_()

    def export_coco(self):
        file, _ = QFileDialog.getSaveFileName(self, "Export as COCO", "annotations.json", "COCO (*.json)")
        if file:
            try:
                images, boxes = coco.export_file(self.document, file)
                self.say(f"{file}: {boxes} boxes of {images} labelled images")
            except (WriteError, FolderError) as error:
                self.say(str(error), 0)

    def import_coco(self):
        file, _ = QFileDialog.getOpenFileName(self, "Import from COCO", "", "COCO (*.json)")
        if not file:
            return
        try:
            done = coco.import_file(self.document, file)
            self.say(f"{done.boxes} boxes of {done.images} images taken over, {len(done.skipped)} entries skipped")
        except (coco.CocoError, FolderError, WriteError) as error:
            self.say(str(error), 0)
        self.images.show_classes(self.document.classes())
        self.show_image(self.current)

    def closeEvent(self, event):
        if self.document.unsaved and not self.document.retry() and not self._close_anyway():
            event.ignore()
            return
        self.proposer.close()
        event.accept()

    def _close_anyway(self):
        answer = QMessageBox.question(
            self, "Not saved",
            f"{len(self.document.unsaved)} images could not be saved: {next(iter(self.document.unsaved.values()))}."
            "\n\nClose and lose their last changes?", QMessageBox.Close | QMessageBox.Cancel, QMessageBox.Cancel)
        return answer == QMessageBox.Close

    # What is shown of the state.

    def say(self, message, milliseconds=MESSAGE_MS):
        """A message in the status bar; 0 ms: until the next one."""
        self.statusBar().showMessage(message, milliseconds)

    def _retry_saving(self):
        if self.document.unsaved:
            self.document.retry()
            self._show_saving()

    def _show_saving(self):
        unsaved = self.document.unsaved
        if unsaved:
            self.banner.setText(f"{len(unsaved)} image{'s are' if len(unsaved) > 1 else ' is'} not saved yet: "
                                f"{next(iter(unsaved.values()))}. It is tried again every {RETRY_MS // 1000} s.")
            self._retry.start()
        else:
            self._retry.stop()
        self.banner.setVisible(bool(unsaved))

    def _show_state(self):
        """Everything beside the image after a change."""
        document = self.document
        labelled = sum(map(document.is_labelled, document.names))
        self.images.show_progress(labelled, len(document.names))
        self.images.model.refresh(self.current)
        self._show_classes()
        self._show_boxes_in_panel()
        self._show_saving()
        for action, step in (("undo", document.next_undo), ("redo", document.next_redo)):
            self.actions_by_name[action].setEnabled(step is not None)

    def _show_classes(self):
        classes = self.document.classes()
        if self.canvas.current_class not in classes:
            classes = [*classes, self.canvas.current_class]
        self.canvas.classes = classes
        counts = self.document.counts()
        self.panel.show_classes(classes, self.canvas.current_class, counts)
        self.canvas.update()

    def _show_boxes_in_panel(self):
        self.panel.show_boxes(self.canvas.classes, self.canvas.boxes, self.canvas.selection)

    def _show_pointer(self, point):
        width, height = self.canvas.image_size
        zoom = f"{100 * self.canvas.viewport.scale:.0f} %"
        place = f"{point[0]:.0f}, {point[1]:.0f}   " if point else ""
        self.pointer.setText(f"{place}{width} x {height}   {zoom}")

"""The lists beside the image."""

from PyQt5.QtCore import QAbstractListModel, QModelIndex, QSize, Qt, pyqtSignal
from PyQt5.QtGui import QColor
from PyQt5.QtWidgets import (QAbstractItemView, QComboBox, QHBoxLayout, QLabel, QLineEdit, QListView, QListWidget,
                             QListWidgetItem, QProgressBar, QPushButton, QStyledItemDelegate, QToolButton, QVBoxLayout,
                             QWidget)

from extperfc.label import editing, filters, theme

NOTE_ROLE = Qt.UserRole + 1  # short text at the right end of a row
ROW_PX = 26


def heading(text):
    """A small title of a part of a panel."""
    label = QLabel(text.upper())
    label.setProperty("heading", True)
    return label


def _column(widget, *parts):
    layout = QVBoxLayout(widget)
    layout.setContentsMargins(10, 10, 10, 10)
    layout.setSpacing(7)
    for part in parts:
        if isinstance(part, QHBoxLayout):
            layout.addLayout(part)
        else:
            layout.addWidget(part)
    return layout


def _quiet_list(widget):
    """The keyboard stays with the image."""
    widget.setFocusPolicy(Qt.NoFocus)
    widget.setItemDelegate(NoteDelegate(widget))
    widget.setVerticalScrollMode(QAbstractItemView.ScrollPerPixel)
    widget.setHorizontalScrollBarPolicy(Qt.ScrollBarAlwaysOff)
    return widget


class NoteDelegate(QStyledItemDelegate):
    """Rows with a faint note at their right end."""

    def paint(self, painter, option, index):
        super().paint(painter, option, index)
        note = index.data(NOTE_ROLE)
        if note:
            painter.save()
            painter.setPen(QColor(theme.FAINT))
            painter.drawText(option.rect.adjusted(0, 0, -8, 0), Qt.AlignRight | Qt.AlignVCenter, note)
            painter.restore()

    def sizeHint(self, option, index):
        return QSize(super().sizeHint(option, index).width(), ROW_PX)


class ImageListModel(QAbstractListModel):
    """Names of the shown images, with their state."""

    def __init__(self, document):
        super().__init__()
        self._document, self.names = document, []
        self._icons = {"labelled": theme.dot(theme.GOOD), "empty": theme.dot(theme.GOOD, False),
                       "unlabelled": theme.dot("#565e6b", False), "damaged": theme.dot(theme.BAD)}

    def set_names(self, names):
        self.beginResetModel()
        self.names = list(names)
        self.endResetModel()

    def refresh(self, name):
        if name in self.names:
            index = self.index(self.names.index(name))
            self.dataChanged.emit(index, index)

    def rowCount(self, parent=QModelIndex()):
        return 0 if parent.isValid() else len(self.names)

    def state(self, name):
        if name in self._document.unsaved or name in self._document.damaged:
            return "damaged"
        if not self._document.is_labelled(name):
            return "unlabelled"
        return "labelled" if self._document.boxes(name) else "empty"

    def data(self, index, role=Qt.DisplayRole):
        if not index.isValid():
            return None
        name = self.names[index.row()]
        if role == Qt.DisplayRole:
            return name
        if role == NOTE_ROLE:
            return str(len(self._document.boxes(name)) or "")
        if role == Qt.DecorationRole:
            return self._icons[self.state(name)]
        if role == Qt.ToolTipRole:
            return f"{self._document.folder.files[name].name}: {self.state(name)}"
        return None


class ImagePanel(QWidget):
    """List of the images that fit a filter and a text, with the progress of the folder."""

    chosen = pyqtSignal(str)
    filter_changed = pyqtSignal()

    def __init__(self, document):
        super().__init__()
        self.filter, self.search, self.progress = QComboBox(), QLineEdit(), QProgressBar()
        self.model, self.list = ImageListModel(document), _quiet_list(QListView())
        self.filter.setFocusPolicy(Qt.NoFocus)
        self.filter.addItems(filters.choices(document.classes()))
        self.search.setPlaceholderText("search by name (Ctrl+F)")
        self.search.setClearButtonEnabled(True)
        self.list.setModel(self.model)
        self.list.setUniformItemSizes(True)
        self.count = heading("")
        _column(self, heading("Images"), self.progress, self.filter, self.search, self.count, self.list)
        self.setFixedWidth(214)
        self.filter.activated.connect(lambda _: self.filter_changed.emit())
        self.search.textChanged.connect(lambda _: self.filter_changed.emit())
        self.list.clicked.connect(lambda index: self.chosen.emit(self.model.names[index.row()]))

    def show_names(self, names, current):
        """Shows these images, and the current one as selected where it is among them."""
        self.model.set_names(names)
        self.count.setText(f"{len(names)} SHOWN" if names else "NO IMAGE FITS")
        self.show_current(current)

    def show_current(self, name):
        if name in self.model.names:
            index = self.model.index(self.model.names.index(name))
            self.list.setCurrentIndex(index)
            self.list.scrollTo(index)
        else:
            self.list.clearSelection()

    def show_progress(self, labelled, total):
        self.progress.setRange(0, total)
        self.progress.setValue(labelled)
        self.progress.setFormat(f"{labelled} of {total} labelled")

    def show_classes(self, classes):
        """Filters for these classes; the chosen one stays."""
        chosen = self.filter.currentText()
        self.filter.clear()
        self.filter.addItems(filters.choices(classes))
        self.filter.setCurrentIndex(max(self.filter.findText(chosen), 0))


class BoxPanel(QWidget):
    """Classes, the boxes of the image, and their flags."""

    class_chosen = pyqtSignal(str)
    class_wanted = pyqtSignal()
    boxes_chosen = pyqtSignal(set)
    flag_toggled = pyqtSignal(str)

    def __init__(self):
        super().__init__()
        self.classes, self.boxes = _quiet_list(QListWidget()), _quiet_list(QListWidget())
        self.boxes.setSelectionMode(QAbstractItemView.ExtendedSelection)
        add = QPushButton("Add class  (N)")
        add.setFocusPolicy(Qt.NoFocus)
        self.count, self._shown = heading(""), None
        self.flags = {flag: self._flag_button(flag) for flag in editing.FLAGS}
        row = QHBoxLayout()
        row.setSpacing(4)
        for button in self.flags.values():
            row.addWidget(button)
        _column(self, heading("Class of new boxes"), self.classes, add, self.count, self.boxes,
                heading("Flags of selected boxes"), row)
        self.setFixedWidth(264)
        self.classes.itemClicked.connect(lambda item: self.class_chosen.emit(item.data(Qt.UserRole)))
        add.clicked.connect(self.class_wanted)
        self.boxes.itemSelectionChanged.connect(self._report_selection)

    def _flag_button(self, flag):
        button = QToolButton()
        button.setText(flag)
        button.setCheckable(True)
        button.setFocusPolicy(Qt.NoFocus)
        button.setToolTip(f"{flag} ({flag[0].upper()})")
        button.setStyleSheet("padding: 5px 6px;")
        button.clicked.connect(lambda: self.flag_toggled.emit(flag))
        return button

    def _report_selection(self):
        self.boxes_chosen.emit({self.boxes.row(item) for item in self.boxes.selectedItems()})

    def show_classes(self, classes, current, counts):
        """Class names with their keys, and how many boxes each has in the folder."""
        self.classes.clear()
        for index, name in enumerate(classes):
            key = f"{index + 1}  " if index < 9 else "    "
            item = QListWidgetItem(theme.dot(theme.class_color(classes, name)), f"{key}{name}")
            item.setData(Qt.UserRole, name)
            item.setData(NOTE_ROLE, str(counts.get(name, 0)))
            self.classes.addItem(item)
            if name == current:
                self.classes.setCurrentItem(item)
        self.classes.setFixedHeight(ROW_PX * max(3, min(len(classes), 9)) + 10)

    def show_boxes(self, classes, boxes, selection):
        """The boxes of the image, and the flags of the selected ones."""
        self.boxes.blockSignals(True)
        if (classes, boxes) != self._shown:  # a list must not be rebuilt while it reports a selection
            self._fill(classes, boxes)
            self._shown = (list(classes), boxes)
        for index in range(len(boxes)):
            self.boxes.item(index).setSelected(index in selection)
        if selection:
            self.boxes.scrollToItem(self.boxes.item(min(selection)))
        self.boxes.blockSignals(False)
        chosen = [boxes[i] for i in selection]
        for flag, button in self.flags.items():
            button.setEnabled(bool(chosen))
            button.setChecked(bool(chosen) and all(getattr(box, flag) for box in chosen))

    def _fill(self, classes, boxes):
        self.boxes.clear()
        self.count.setText(f"{len(boxes)} BOX{'' if len(boxes) == 1 else 'ES'} IN THIS IMAGE")
        for box in boxes:
            flags = " ".join(flag[0].upper() for flag in editing.FLAGS if getattr(box, flag))
            item = QListWidgetItem(theme.dot(theme.class_color(classes, box.name)), f"{box.name}  {flags}")
            item.setData(NOTE_ROLE, f"{box.width} x {box.height}")
            self.boxes.addItem(item)

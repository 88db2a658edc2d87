"""Help and statistics."""

from html import escape

from PyQt5.QtCore import Qt
from PyQt5.QtWidgets import (QAbstractItemView, QDialog, QDialogButtonBox, QHBoxLayout, QHeaderView, QLabel,
                             QTableWidget, QTableWidgetItem, QVBoxLayout)

from extperfc.label import shortcuts, statistics, theme


def _with_close_button(dialog, layout):
    buttons = QDialogButtonBox(QDialogButtonBox.Close)
    buttons.rejected.connect(dialog.reject)
    layout.addWidget(buttons)


class HelpDialog(QDialog):
    """All keys and gestures, in two columns."""

    LEFT = ("Images", "Boxes")
    KEYS_PX = 188

    def __init__(self, parent=None):
        super().__init__(parent)
        self.setWindowTitle("Keys and gestures")
        layout, columns = QVBoxLayout(self), QHBoxLayout()
        sections = shortcuts.by_section()
        for names in (self.LEFT, [name for name in sections if name not in self.LEFT]):
            label = QLabel("".join(self._section(name, sections[name]) for name in names))
            label.setTextFormat(Qt.RichText)
            label.setAlignment(Qt.AlignTop)
            columns.addWidget(label)
        columns.setSpacing(20)
        layout.setContentsMargins(22, 14, 22, 14)
        layout.addLayout(columns)
        _with_close_button(self, layout)

    def _section(self, name, rows):
        lines = "".join(
            f"<tr><td width='{self.KEYS_PX}' style='padding: 2px 8px 2px 0; color: "
            f"{theme.ACCENT}'><nobr>{escape(shortcuts.keys_text(row))}"
            f"</nobr></td><td style='padding: 2px 0'>{escape(row.text)}</td></tr>" for row in rows)
        return f"<p style='margin: 8px 0 2px 0'><b>{escape(name)}</b></p><table cellspacing='0'>{lines}</table>"


class StatisticsDialog(QDialog):
    """Counts of the folder by class."""

    def __init__(self, found, parent=None):
        super().__init__(parent)
        self.setWindowTitle("Statistics")
        layout = QVBoxLayout(self)
        layout.setContentsMargins(18, 16, 18, 14)
        layout.addWidget(QLabel(statistics.summary(found)))
        layout.addWidget(self._table(statistics.rows(found)))
        _with_close_button(self, layout)
        self.resize(760, 320)

    @staticmethod
    def _table(rows):
        table = QTableWidget(len(rows), len(statistics.HEADINGS))
        table.setHorizontalHeaderLabels(statistics.HEADINGS)
        table.verticalHeader().hide()
        table.setShowGrid(False)
        table.setSelectionMode(QAbstractItemView.NoSelection)
        table.setFocusPolicy(Qt.NoFocus)
        table.setEditTriggers(QAbstractItemView.NoEditTriggers)
        table.horizontalHeader().setSectionResizeMode(QHeaderView.Stretch)
        for i, row in enumerate(rows):
            for j, text in enumerate(row):
                item = QTableWidgetItem(text)
                item.setTextAlignment(Qt.AlignVCenter | (Qt.AlignRight if j else Qt.AlignLeft))
                table.setItem(i, j, item)
        return table

"""Colours of classes and the look of the window."""

from PyQt5.QtCore import Qt
from PyQt5.QtGui import QColor, QIcon, QPainter, QPalette, QPixmap
from PyQt5.QtWidgets import QStyleFactory

GROUND, PANEL, FIELD, LINE = "#1b1e23", "#24282f", "#1f2329", "#363c46"
TEXT, FAINT, ACCENT, GOOD, BAD = "#e6e9ee", "#8f98a6", "#4c9be8", "#57c08a", "#e0625e"
# Distinct on photographs, and for readers with red-green blindness by brightness as well (after Okabe and Ito).
CLASS_COLORS = ("#e69f00", "#56b4e9", "#2fc79a", "#f0e442", "#4f8ff0", "#ff7043", "#e07bc0", "#a0e05a", "#b39ddb",
                "#d7ccc8")

STYLE = f"""
QWidget {{ font-size: 13px; }}
QMainWindow, QDialog {{ background: {PANEL}; }}
QListView, QListWidget, QLineEdit, QTableWidget {{ background: {FIELD}; border: 1px solid {LINE}; border-radius: 4px;
  padding: 3px; selection-background-color: #2f5d8c; selection-color: white; outline: 0; }}
QListView::item, QListWidget::item {{ padding: 3px 4px; border-radius: 3px; }}
QListView::item:selected, QListWidget::item:selected {{ background: #2f5d8c; color: white; }}
QPushButton, QToolButton {{ background: #303640; border: 1px solid {LINE}; border-radius: 4px; padding: 5px 10px; }}
QPushButton:hover, QToolButton:hover {{ background: #3a414d; }}
QPushButton:checked, QToolButton:checked {{ background: #2f5d8c; border-color: {ACCENT}; }}
QPushButton:disabled, QToolButton:disabled {{ color: #666d78; }}
QProgressBar {{ background: {FIELD}; border: 1px solid {LINE}; border-radius: 4px; height: 18px; text-align: center; }}
QProgressBar::chunk {{ background: #357a56; border-radius: 3px; }}
QLabel[heading="true"] {{ color: {FAINT}; font-weight: bold; font-size: 11px; }}
QLabel[banner="true"] {{ background: #7d2b2b; color: white; padding: 8px 12px; }}
QToolBar {{ background: {PANEL}; border: 0; border-bottom: 1px solid {LINE}; spacing: 4px; padding: 4px; }}
QStatusBar {{ background: {PANEL}; color: {FAINT}; border-top: 1px solid {LINE}; }}
QHeaderView::section {{ background: {PANEL}; border: 0; padding: 5px 4px; color: {FAINT}; }}
QScrollBar:vertical {{ background: transparent; width: 10px; }}
QScrollBar::handle:vertical {{ background: #454c58; border-radius: 4px; min-height: 24px; }}
QScrollBar::add-line, QScrollBar::sub-line {{ height: 0; }}
"""


def class_color(classes, name):
    """The colour of a class by its place in the list."""
    index = classes.index(name) if name in classes else len(classes)
    return QColor(CLASS_COLORS[index % len(CLASS_COLORS)])


def apply_theme(application):
    """A dark, quiet window, so that the image is the brightest part."""
    application.setStyle(QStyleFactory.create("Fusion"))
    palette = QPalette()
    for role, color in ((QPalette.Window, PANEL), (QPalette.WindowText, TEXT), (QPalette.Base, FIELD),
                        (QPalette.Text, TEXT), (QPalette.AlternateBase, PANEL), (QPalette.Button, "#303640"),
                        (QPalette.ButtonText, TEXT), (QPalette.Highlight, "#2f5d8c"), (QPalette.HighlightedText,
                                                                                       "#ffffff"),
                        (QPalette.ToolTipBase, PANEL), (QPalette.ToolTipText, TEXT), (QPalette.PlaceholderText, FAINT)):
        palette.setColor(role, QColor(color))
    palette.setColor(QPalette.Disabled, QPalette.Text, QColor("#666d78"))
    palette.setColor(QPalette.Disabled, QPalette.ButtonText, QColor("#666d78"))
    application.setPalette(palette)
    application.setStyleSheet(STYLE)


def dot(color, is_filled=True, size=14):
    """A round icon."""
    pixmap = QPixmap(size, size)
    pixmap.fill(Qt.transparent)
    painter = QPainter(pixmap)
    painter.setRenderHint(QPainter.Antialiasing)
    painter.setPen(QColor(color))
    painter.setBrush(QColor(color) if is_filled else Qt.NoBrush)
    painter.drawEllipse(3, 3, size - 7, size - 7)
    painter.end()
    icon = QIcon(pixmap)
    icon.addPixmap(pixmap, QIcon.Selected)  # in its own colour, not tinted
    return icon

"""The image with its boxes: draws, moves and resizes them with mouse and keys."""

import dataclasses

from PyQt5.QtCore import QPointF, QRectF, Qt, pyqtSignal
from PyQt5.QtGui import QBrush, QColor, QPainter, QPen, QPixmap
from PyQt5.QtWidgets import QSizePolicy, QWidget

from extperfc.label import editing, theme
from extperfc.label.viewport import Viewport

GRIP_PX = 7  # of the window, how near to an edge a press takes hold of it
ARROWS = {Qt.Key_Left: (-1, 0), Qt.Key_Right: (1, 0), Qt.Key_Up: (0, -1), Qt.Key_Down: (0, 1)}
CURSORS = {frozenset(): Qt.SizeAllCursor, frozenset({"left"}): Qt.SizeHorCursor, frozenset({"right"}): Qt.SizeHorCursor,
           frozenset({"top"}): Qt.SizeVerCursor, frozenset({"bottom"}): Qt.SizeVerCursor,
           frozenset({"left", "top"}): Qt.SizeFDiagCursor, frozenset({"right", "bottom"}): Qt.SizeFDiagCursor,
           frozenset({"right", "top"}): Qt.SizeBDiagCursor, frozenset({"left", "bottom"}): Qt.SizeBDiagCursor}


@dataclasses.dataclass
class _Drag:
    """What the pressed button does. begin: point of the image [px]; boxes: as they were."""

    kind: str
    begin: tuple
    boxes: tuple = ()
    index: int = -1  # of the pressed box
    edges: frozenset = frozenset()
    last: tuple = (0, 0)  # of the window, for panning


class Canvas(QWidget):
    """One image. Shows `boxes` and `proposals`; reports edits and leaves it to its owner to make them."""

    edited = pyqtSignal(tuple, set, str, object)  # boxes, selection, title of the change, merge key
    selection_changed = pyqtSignal()
    proposal_clicked = pyqtSignal(int)
    page_wanted = pyqtSignal(int)  # 1: next, -1: previous
    pointer_moved = pyqtSignal(object)  # (x, y) of the image [px], or None outside

    def __init__(self, parent=None):
        super().__init__(parent)
        self.viewport = Viewport()
        self.boxes, self.selection, self.proposals = (), set(), []
        self.classes, self.current_class = [], "object"
        self.shows_boxes, self.shows_names, self.is_editable = True, True, True
        self._pixmap, self._drag, self._drawn, self._pointer, self._space = QPixmap(), None, None, None, False
        self.setMouseTracking(True)
        self.setFocusPolicy(Qt.StrongFocus)
        self.setMinimumSize(320, 240)
        self.setSizePolicy(QSizePolicy.Expanding, QSizePolicy.Expanding)
        self.setAttribute(Qt.WA_OpaquePaintEvent)

    # What is shown.

    def show_image(self, pixmap, boxes, is_editable=True):
        """Another image; nothing is selected."""
        self._pixmap, self._drag, self._drawn = pixmap, None, None
        self.boxes, self.selection, self.proposals, self.is_editable = tuple(boxes), set(), [], is_editable
        self.viewport.set_image(max(pixmap.width(), 1), max(pixmap.height(), 1))
        self.selection_changed.emit()
        self.update()

    def show_boxes(self, boxes, selection=frozenset()):
        """Other boxes of the same image."""
        self.boxes, self.selection, self._drag, self._drawn = tuple(boxes), set(selection), None, None
        self.selection_changed.emit()
        self.update()

    def show_proposals(self, proposals):
        """Boxes that are not part of the labels yet, as (box, score)."""
        self.proposals = list(proposals)
        self.update()

    def select(self, selection):
        self.selection = {i for i in selection if i < len(self.boxes)}
        self.selection_changed.emit()
        self.update()

    def select_step(self, step):
        """Selects the box behind (1) or before (-1) the selected one."""
        if self.boxes:
            start = min(self.selection) if self.selection else (-1 if step > 0 else 0)
            self.select({(start + step) % len(self.boxes)})

    @property
    def image_size(self):
        return self._pixmap.width(), self._pixmap.height()

    def cancel(self):
        """Ends a drag without an edit. Returns False when there was none."""
        if self._drag is None:
            return False
        if self._drag.kind in ("move", "resize"):
            self.boxes = self._drag.boxes
        self._drag = self._drawn = None
        self.update()
        return True

    # Mouse.

    def mousePressEvent(self, event):
        at = (event.x(), event.y())
        point = self.viewport.to_image(*at)
        if event.button() == Qt.MiddleButton or (event.button() == Qt.LeftButton and self._space):
            self._drag = _Drag("pan", point, last=at)
        elif event.button() == Qt.LeftButton and self.is_editable and not self._pixmap.isNull():
            self._press(point, event.modifiers())
        self.update()

    def _press(self, point, modifiers):
        found = None if modifiers & Qt.ShiftModifier or not self.shows_boxes else self._hit(point)
        if found and modifiers & Qt.ControlModifier:
            self.select(self.selection ^ {found[0]})
        elif found:
            index, edges = found
            if index not in self.selection:
                self.select({index})
            self._drag = _Drag("resize" if edges else "move", point, self.boxes, index, edges)
        elif not modifiers & Qt.ShiftModifier and (proposal := self._proposal_at(point)) is not None:
            self.proposal_clicked.emit(proposal)
        else:
            self._drag = _Drag("draw", point)

    def mouseMoveEvent(self, event):
        at = (event.x(), event.y())
        self._pointer = self.viewport.to_image(*at)
        if self._drag is None:
            self._update_cursor()
        elif self._drag.kind == "pan":
            self.viewport.pan(at[0] - self._drag.last[0], at[1] - self._drag.last[1])
            self._drag.last = at
        else:
            self._follow()
        self.pointer_moved.emit(self._pointer)
        self.update()

    def _follow(self):
        """What a drag has made so far."""
        drag, size = self._drag, self.image_size
        dx, dy = (round(self._pointer[i] - drag.begin[i]) for i in (0, 1))
        if drag.kind == "draw":
            self._drawn = editing.drawn(self.current_class, drag.begin, self._pointer, size)
        elif drag.kind == "move":
            self.boxes = editing.shifted(drag.boxes, self.selection, dx, dy, size)
        else:
            self.boxes = editing.stretched(drag.boxes, self.selection, drag.edges, dx, dy, size)

    def mouseReleaseEvent(self, event):
        drag = self._drag
        if drag is not None and drag.kind != "pan":
            self._pointer = self.viewport.to_image(event.x(), event.y())
            self._follow()
        drawn, self._drag, self._drawn = self._drawn, None, None
        if drag is None or drag.kind == "pan":
            return
        if drag.kind != "draw":
            self._end_edit(drag)
        elif drawn is not None:
            self.edited.emit((*self.boxes, drawn), {len(self.boxes)}, "draw", None)
        else:
            self.select(set())
        self.update()

    def _end_edit(self, drag):
        """A press that moved nothing selects its box alone."""
        if self.boxes != drag.boxes:
            self.edited.emit(self.boxes, set(self.selection), drag.kind, None)
        else:
            self.select({drag.index})

    def leaveEvent(self, _):
        self._pointer = None
        self.pointer_moved.emit(None)
        self.update()

    def wheelEvent(self, event):
        self.viewport.zoom(1.0015 ** event.angleDelta().y(), (event.position().x(), event.position().y()))
        self.update()

    def resizeEvent(self, _):
        self.viewport.set_view(self.width(), self.height())

    def _hit(self, point):
        return editing.hit(self.boxes, self.selection, *point, GRIP_PX / self.viewport.scale)

    def _proposal_at(self, point):
        found = editing.hit([box for box, _ in self.proposals], set(), *point, 0)
        return found[0] if found else None

    def _update_cursor(self):
        found = self._hit(self._pointer) if self.is_editable and self.shows_boxes else None
        if self._space:
            self.setCursor(Qt.OpenHandCursor)
        elif found:
            self.setCursor(CURSORS[found[1]])
        else:
            self.setCursor(Qt.PointingHandCursor if self._proposal_at(self._pointer) is not None else Qt.CrossCursor)

    # Keys that the window's actions do not have.

    def keyPressEvent(self, event):
        if event.key() in ARROWS:
            self._arrow(ARROWS[event.key()], event.modifiers())
        elif event.key() == Qt.Key_Space and not event.isAutoRepeat():
            self._space = True
            self.setCursor(Qt.OpenHandCursor)
        else:
            super().keyPressEvent(event)

    def keyReleaseEvent(self, event):
        if event.key() == Qt.Key_Space and not event.isAutoRepeat():
            self._space = False
            self.setCursor(Qt.CrossCursor)

    def focusNextPrevChild(self, _):
        return False  # Tab selects boxes

    def _arrow(self, direction, modifiers):
        step = 10 if modifiers & Qt.ShiftModifier else 1
        dx, dy = (step * part for part in direction)
        if not self.selection:
            if dx:
                self.page_wanted.emit(1 if dx > 0 else -1)
            return
        if modifiers & Qt.AltModifier:
            boxes = editing.stretched(self.boxes, self.selection, {"right" if dx else "bottom"}, dx, dy,
                                      self.image_size)
        else:
            boxes = editing.shifted(self.boxes, self.selection, dx, dy, self.image_size)
        title = "resize" if modifiers & Qt.AltModifier else "move"
        self.edited.emit(boxes, set(self.selection), title, (title, tuple(sorted(self.selection))))

    # Painting.

    def paintEvent(self, _):
        painter = QPainter(self)
        painter.fillRect(self.rect(), QColor(theme.GROUND))
        if not self._pixmap.isNull():
            painter.setRenderHint(QPainter.SmoothPixmapTransform, self.viewport.scale < 3)
            painter.drawPixmap(self._rect(0, 0, *self.image_size), self._pixmap, QRectF(self._pixmap.rect()))
            self._paint_guides(painter)
            painter.setRenderHint(QPainter.Antialiasing)
            self._paint_boxes(painter)
        painter.end()

    def _rect(self, x0, y0, x1, y1):
        return QRectF(QPointF(*self.viewport.to_view(x0, y0)), QPointF(*self.viewport.to_view(x1, y1)))

    def _paint_guides(self, painter):
        """Lines through the pointer, to see where a new box would begin."""
        if self._pointer is None or not self.is_editable or (self._drag and self._drag.kind != "draw") or self._space:
            return
        if self._drag is None and self._hit(self._pointer):
            return
        x, y = self.viewport.to_view(*self._pointer)
        area = self._rect(0, 0, *self.image_size)
        if area.contains(x, y):
            painter.setPen(QPen(QColor(255, 255, 255, 110), 1, Qt.DashLine))
            painter.drawLine(QPointF(area.left(), y), QPointF(area.right(), y))
            painter.drawLine(QPointF(x, area.top()), QPointF(x, area.bottom()))

    def _paint_boxes(self, painter):
        if self.shows_boxes:
            for index in sorted(range(len(self.boxes)), key=self.selection.__contains__):  # selected ones on top
                self._paint_box(painter, self.boxes[index], index in self.selection)
        for box, score in self.proposals:
            self._paint_proposal(painter, box, score)
        if self._drawn is not None:
            self._paint_box(painter, self._drawn, True)

    def _paint_box(self, painter, box, is_selected):
        color, rect = theme.class_color(self.classes, box.name), self._rect(*box.corners)
        painter.setBrush(QBrush(QColor(color.red(), color.green(), color.blue(), 56 if is_selected else 22)))
        painter.setPen(QPen(QColor(0, 0, 0, 150), 4 if is_selected else 3))
        painter.drawRect(rect)
        painter.setBrush(Qt.NoBrush)
        painter.setPen(QPen(color, 2.4 if is_selected else 1.6, Qt.DashDotLine if box.difficult else Qt.SolidLine))
        painter.drawRect(rect)
        if self.shows_names:
            self._paint_tag(painter, rect, self._tag(box, is_selected), color)
        if is_selected:
            self._paint_handles(painter, rect)

    @staticmethod
    def _tag(box, is_selected):
        """The name; with size and flags when selected, else with the flags' first letters."""
        flags = [flag for flag in editing.FLAGS if getattr(box, flag)]
        if is_selected:
            return "  ".join([box.name, *flags, f"{box.width} x {box.height}"])
        return " ".join([box.name, *(flag[0].upper() for flag in flags)])

    def _paint_proposal(self, painter, box, score):
        color, rect = theme.class_color(self.classes, box.name), self._rect(*box.corners)
        painter.setBrush(Qt.NoBrush)
        painter.setPen(QPen(QColor(0, 0, 0, 130), 3))
        painter.drawRect(rect)
        painter.setPen(QPen(color, 1.8, Qt.DashLine))
        painter.drawRect(rect)
        self._paint_tag(painter, rect, f"{box.name} {score:.2f} ?", color)

    def _paint_tag(self, painter, rect, text, color):
        """A name on its class's colour, above the box, or inside where there is no room."""
        metrics = painter.fontMetrics()
        width, height = metrics.horizontalAdvance(text) + 10, metrics.height() + 2
        top = rect.top() - height - 1 if rect.top() - height >= 0 else rect.top() + 1
        left = min(max(rect.left() - 1, 0), self.width() - width)
        painter.setPen(Qt.NoPen)
        painter.setBrush(color)
        painter.drawRoundedRect(QRectF(left, top, width, height), 2, 2)
        painter.setPen(QColor("#101215"))
        painter.drawText(QRectF(left, top, width, height), Qt.AlignCenter, text)

    @staticmethod
    def _paint_handles(painter, rect):
        painter.setPen(QPen(QColor("#15181c"), 1))
        painter.setBrush(QColor("white"))
        for x in (rect.left(), rect.center().x(), rect.right()):
            for y in (rect.top(), rect.center().y(), rect.bottom()):
                if (x, y) != (rect.center().x(), rect.center().y()):
                    painter.drawRect(QRectF(x - 3.5, y - 3.5, 7, 7))

"""Boards that a camera is calibrated with: their points, finding them in an image, printing them.

Board frame: x to the right and y down as seen from the front, z into the board; the origin is the first point. All
points have z = 0.
"""

import dataclasses

import cv2
import numpy

MIN_POINTS = 6       # of a view; four would do, but say nothing about their own errors
MARGIN_SQUARES = 1   # of white around a printed board


class BoardError(ValueError):
    """A board that cannot be used; the text says why and what to do."""


@dataclasses.dataclass(frozen=True)
class Detection:
    """Points of a board in an image."""
    indices: numpy.ndarray  # n, into the board's points()
    pixels: numpy.ndarray   # n x 2 [px]; the centre of the first pixel is (0, 0)


@dataclasses.dataclass(frozen=True)
class Chessboard:
    """Chessboard of columns x rows inner corners; its outer square in the upper left corner is black."""
    columns: int
    rows: int
    square_m: float

    def __post_init__(self):
        if min(self.columns, self.rows) < 3:
            raise BoardError(f"a chessboard needs 3 x 3 inner corners or more, not {self.columns} x {self.rows}")
        if (self.columns + self.rows) % 2 == 0:
            raise BoardError(f"a chessboard of {self.columns} x {self.rows} inner corners looks the same upside down: "
                             f"use one of {self.columns} x {self.rows + 1}")
        _check_length("square", self.square_m)

    def points(self):
        """columns * rows x 3 [m], row by row."""
        x, y = numpy.meshgrid(numpy.arange(self.columns), numpy.arange(self.rows))
        return numpy.stack([x.ravel(), y.ravel(), 0 * x.ravel()], 1) * float(self.square_m)

    def dark_cells(self):
        """Black parts of the print: (x, y, width, height) [m] in the board frame."""
        side = self.square_m
        return [((column - 1) * side, (row - 1) * side, side, side)
                for row in range(self.rows + 1) for column in range(self.columns + 1) if (row + column) % 2 == 0]

    def outline(self):
        """(x, y, width, height) [m] of the whole print with its margin, in the board frame."""
        around = 1 + MARGIN_SQUARES
        return (-around * self.square_m, -around * self.square_m,
                (self.columns - 1 + 2 * around) * self.square_m, (self.rows - 1 + 2 * around) * self.square_m)

    def detect(self, grey):
        """The Detection of all corners in an 8-bit grey image; None when the board is not wholly visible."""
        size = (self.columns, self.rows)
        found, corners = cv2.findChessboardCornersSB(grey,
                                                     size,
                                                     flags=cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_ACCURACY)
        if not found:
            return None
        grid = _as_seen_from_the_front(_refined(grey, corners.reshape(self.rows, self.columns, 2)).astype(float))
        if _first_cell_is_light(grey, grid):
            grid = grid[::-1, ::-1]
        return Detection(numpy.arange(self.columns * self.rows), grid.reshape(-1, 2))

    def as_dict(self):
        return {"kind": "chessboard", "columns": self.columns, "rows": self.rows, "square_m": self.square_m}


@dataclasses.dataclass(frozen=True)
class ArucoBoard:
    """Grid of columns x rows ArUco markers, numbered row by row from 0; the origin is the first marker's upper left
    corner."""
    columns: int
    rows: int
    marker_m: float
    gap_m: float
    dictionary: str = "DICT_4X4_100"

    def __post_init__(self):
        if min(self.columns, self.rows) < 1 or self.columns * self.rows < 2:
            raise BoardError(f"an ArUco board needs 2 markers or more, not {self.columns} x {self.rows}")
        _check_length("marker", self.marker_m)
        _check_length("gap", self.gap_m)
        if not hasattr(cv2, "aruco"):
            raise BoardError(
                "this OpenCV has no ArUco module: install python3-opencv of the system, or use a chessboard")
        if not self.dictionary.startswith("DICT_") or not hasattr(cv2.aruco, self.dictionary):
            raise BoardError(f"{self.dictionary} is no dictionary of OpenCV: use e.g. DICT_4X4_100")
        known = len(self._dictionary().bytesList)
        if self.columns * self.rows > known:
            raise BoardError(f"{self.dictionary} has {known} markers, the board has {self.columns * self.rows}: "
                             "use a larger dictionary")

    def _dictionary(self):
        return cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, self.dictionary))

    def points(self):
        """4 * columns * rows x 3 [m]: four corners per marker, clockwise from its upper left one."""
        step, side = self.marker_m + self.gap_m, self.marker_m
        corners = numpy.array([[0, 0, 0], [side, 0, 0], [side, side, 0], [0, side, 0]])
        return numpy.concatenate([corners + (step * column, step * row, 0)
                                  for row in range(self.rows) for column in range(self.columns)])

    def dark_cells(self):
        """Black parts of the print: (x, y, width, height) [m] in the board frame."""
        cells, step = [], self.marker_m + self.gap_m
        for number in range(self.columns * self.rows):
            bits = self._dictionary().markerSize + 2
            image = cv2.aruco.drawMarker(self._dictionary(), number, bits)
            x, y, cell = number % self.columns * step, number // self.columns * step, self.marker_m / bits
            cells += [(x + column * cell, y + row * cell, cell, cell)
                      for row, column in zip(*numpy.nonzero(image == 0))]
        return cells

    def outline(self):
        """(x, y, width, height) [m] of the whole print with its margin, in the board frame."""
        margin = max(self.gap_m, 0.25 * self.marker_m)
        width, height = (count * (self.marker_m + self.gap_m) - self.gap_m for count in (self.columns, self.rows))
        return -margin, -margin, width + 2 * margin, height + 2 * margin

    def detect(self, grey):
        """The Detection of all visible markers in an 8-bit grey image; None when fewer than two are."""
        parameters = cv2.aruco.DetectorParameters_create()
        parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
        corners, numbers, _ = cv2.aruco.detectMarkers(grey, self._dictionary(), parameters=parameters)
        indices, pixels = [], []
        for quad, number in zip(corners, [] if numbers is None else numbers.ravel()):
            if number < self.columns * self.rows:
                indices += range(4 * number, 4 * number + 4)
                pixels.append(quad.reshape(4, 2))
        if len(indices) < 8:
            return None
        return Detection(numpy.array(indices), numpy.concatenate(pixels).astype(float))

    def as_dict(self):
        return {
            "kind": "aruco",
            "columns": self.columns,
            "rows": self.rows,
            "marker_m": self.marker_m,
            "gap_m": self.gap_m,
            "dictionary": self.dictionary
        }


def _check_length(what, length_m):
    if not 0.001 <= length_m <= 1:
        raise BoardError(f"{what} of {length_m} m: lengths are in metres, from 0.001 to 1")


def _refined(grey, grid):
    """The corners moved to the saddle points of the image near them, which halves their errors."""
    spacing = min(numpy.linalg.norm(numpy.diff(grid, axis=axis), axis=2).min() for axis in (0, 1))
    window = int(numpy.clip(0.35 * spacing, 2, 8))
    criteria = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 40, 0.001)
    return cv2.cornerSubPix(grey,
                            grid.reshape(-1, 1, 2).copy(), (window, window), (-1, -1), criteria).reshape(grid.shape)


def _as_seen_from_the_front(grid):
    """The same rows x columns x 2 [px], with columns in the order in which a board that faces the camera shows them."""
    along, down = grid[0, -1] - grid[0, 0], grid[-1, 0] - grid[0, 0]
    return grid if along[0] * down[1] - along[1] * down[0] > 0 else grid[:, ::-1]


def _first_cell_is_light(grey, grid):
    """Whether the square between the first four corners is a white one: then the board is upside down."""
    centres = (grid[:-1, :-1] + grid[1:, :-1] + grid[:-1, 1:] + grid[1:, 1:]) / 4
    columns, rows = numpy.rint(centres).astype(int).transpose(2, 0, 1)
    values = grey[rows.clip(0, grey.shape[0] - 1), columns.clip(0, grey.shape[1] - 1)].astype(float)
    row, column = numpy.indices(values.shape)
    even = (row + column) % 2 == 0
    return values[even].mean() > values[~even].mean()


def parse_board(text):
    """A board of `chessboard:9x6:0.025` (inner corners, square [m]) or `aruco:5x4:0.03:0.006[:DICT_4X4_100]`
    (markers, side and gap [m]). Raises BoardError."""
    kind, *rest = text.split(":")
    try:
        columns, rows = (int(number) for number in rest[0].split("x"))
        if kind == "chessboard" and len(rest) == 2:
            return Chessboard(columns, rows, float(rest[1]))
        if kind == "aruco" and len(rest) in (3, 4):
            return ArucoBoard(columns, rows, float(rest[1]), float(rest[2]), *rest[3:])
    except BoardError:
        raise
    except (ValueError, IndexError):
        pass
    raise BoardError(
        f"'{text}' describes no board: write chessboard:COLUMNSxROWS:SQUARE with inner corners and metres, e.g. "
        "chessboard:9x6:0.025, or aruco:COLUMNSxROWS:MARKER:GAP[:DICTIONARY], e.g. aruco:5x4:0.03:0.006")


def board_of_dict(fields):
    """The board of an as_dict(). Raises BoardError."""
    kinds = {"chessboard": Chessboard, "aruco": ArucoBoard}
    fields = dict(fields)
    kind = kinds.get(fields.pop("kind", None))
    try:
        return kind(**fields)
    except TypeError:
        names = {name: [field.name for field in dataclasses.fields(one)] for name, one in kinds.items()}
        raise BoardError(f"board: kind must be one of {names}") from None


def svg(board):
    """The board as a drawing in true size, to be printed without scaling."""
    x, y, width, height = (1000 * value for value in board.outline())
    cells = "".join(f'<rect x="{1000 * cx:.3f}" y="{1000 * cy:.3f}" width="{1000 * w:.3f}" height="{1000 * h:.3f}"/>'
                    for cx, cy, w, h in board.dark_cells())
    return (f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.3f}mm" height="{height:.3f}mm" '
            f'viewBox="{x:.3f} {y:.3f} {width:.3f} {height:.3f}"><rect x="{x:.3f}" y="{y:.3f}" width="{width:.3f}" '
            f'height="{height:.3f}" fill="white"/>{cells}</svg>\n')

"""Images of a calibration: the corners where they are and where the result expects them, and the frames in space."""

import math

import cv2
import numpy

from extperfc import robot_description as rd

SEEN, EXPECTED = (60, 200, 60), (30, 30, 230)  # BGR
MAX_DRAWN_VIEWS = 40
ENLARGED = 3


def corners_image(image, pixels, expected=None, size=1):
    """A copy (BGR) with a circle around every corner seen and, where given, a cross where it is expected; `size` is the
    thickness of lines [px]."""
    drawn = cv2.cvtColor(image, cv2.COLOR_GRAY2BGR) if image.ndim == 2 else image.copy()
    for x, y in pixels:
        cv2.circle(drawn, (round(float(x)), round(float(y))), 6 * size, SEEN, size, cv2.LINE_AA)
    for x, y in () if expected is None else expected:
        cv2.drawMarker(drawn, (round(float(x)), round(float(y))), EXPECTED, cv2.MARKER_TILTED_CROSS, 7 * size, size, cv2.LINE_AA)
    return drawn


def _expected(found, view_set, view):
    unknowns = found.solution.unknowns
    points = view_set.board.points()[view.detection.indices]
    return view_set.camera.project(points, unknowns.camera_T_board(view.parent_T_carrier))


def _cut_out(image, pixels):
    """(upper left corner [px], part of the image around these pixels)."""
    low, high = pixels.min(axis=0), pixels.max(axis=0)
    margin = 0.3 * (high - low)
    left, top = numpy.maximum(low - margin, 0).astype(int)
    right, bottom = (high + margin).astype(int)
    return numpy.array([left, top]), image[top:bottom, left:right]


def _draw_typical(axis, found, view_set):
    """The view with the median residual, so that it is neither the best nor the worst one."""
    used = [i for i, fits in enumerate(found.solution.used) if fits]
    index = sorted(used, key=lambda i: found.view_errors_px[i])[len(used) // 2]
    view = view_set.views[index]
    image = cv2.imread(str(view_set.folder / view.name))
    origin, cut = _cut_out(image, view.detection.pixels)
    enlarged = cv2.resize(cut, None, fx=ENLARGED, fy=ENLARGED, interpolation=cv2.INTER_CUBIC)
    drawn = corners_image(enlarged, *(ENLARGED * (pixels - origin) + (ENLARGED - 1) / 2 for pixels in
                                      (view.detection.pixels, _expected(found, view_set, view))), size=ENLARGED)
    axis.imshow(cv2.cvtColor(drawn, cv2.COLOR_BGR2RGB))
    axis.set_title(f"{view.name}: corners seen (green), expected (red); {found.view_errors_px[index]:.2f} px",
                   fontsize=9)
    axis.set_axis_off()


def _draw_residuals(axis, found, view_set):
    limit = 0.5
    for view, fits in zip(view_set.views, found.solution.used):
        if fits:
            errors = view.detection.pixels - _expected(found, view_set, view)
            axis.plot(errors[:, 0], errors[:, 1], ".", markersize=3)
            limit = max(limit, float(numpy.percentile(numpy.abs(errors), 99.5)))
    axis.set_xlim(-limit, limit)
    axis.set_ylim(limit, -limit)
    axis.set_aspect("equal")
    axis.grid(alpha=0.3)
    axis.set_title(f"seen less expected [px], a colour per view; {found.spread_px:.2f} px in all", fontsize=9)


def _draw_views(axis, found, view_set):
    """Errors by view: of the corners in px, and of the board's position predicted by the other views in mm."""
    left_out = {held.name: 1000 * held.position_m for held in found.held_out}
    names = [view.name for view in view_set.views]
    places = numpy.arange(len(names))
    colours = ["tab:blue" if fits else "tab:red" for fits in found.solution.used]
    axis.bar(places - 0.2, numpy.minimum(found.view_errors_px, 50), 0.4, color=colours, label="corners [px]")
    axis.bar(places + 0.2, [left_out.get(name, 0) for name in names],
             0.4,
             color="tab:orange",
             label="left out: position [mm]")
    axis.set_xlabel("view (red: left out as wrong)", fontsize=9)
    axis.legend(fontsize=8)
    axis.grid(axis="y", alpha=0.3)


def _draw_axes(axis, pose, length_m, name=""):
    origin = pose[:3, 3]
    for column, colour in enumerate(("tab:red", "tab:green", "tab:blue")):
        axis.plot(*zip(origin, origin + length_m * pose[:3, column]), color=colour, linewidth=1.5)
    if name:
        axis.text(*origin, " " + name, fontsize=8)


def _draw_frustum(axis, camera, pose, depth_m):
    corners = camera.rays(numpy.array([[0, 0], [camera.width - 1, 0], [camera.width - 1, camera.height - 1],
                                       [0, camera.height - 1]], float))
    points = numpy.column_stack([corners, numpy.ones(4)]) * depth_m @ pose[:3, :3].T + pose[:3, 3]
    for i in range(4):
        axis.plot(*zip(points[i], points[(i + 1) % 4]), color="0.4", linewidth=0.8)
        axis.plot(*zip(pose[:3, 3], points[i]), color="0.4", linewidth=0.8)


def _draw_space(axis, found, view_set):
    unknowns, frames = found.solution.unknowns, view_set.frames
    x, y, width, height = view_set.board.outline()
    outline = numpy.array([[x, y, 0], [x + width, y, 0], [x + width, y + height, 0], [x, y + height, 0], [x, y, 0]])
    for view in view_set.views[:MAX_DRAWN_VIEWS]:
        pose = view.parent_T_carrier @ unknowns.carrier_T_board
        points = outline @ pose[:3, :3].T + pose[:3, 3]
        axis.plot(*points.T, linewidth=0.8)
    _draw_axes(axis, numpy.eye(4), 0.12, frames.parent)
    _draw_axes(axis, found.parent_T_camera, 0.12, frames.camera)
    _draw_frustum(axis, view_set.camera, found.parent_T_camera, 0.2)
    axis.set_aspect("equal")
    axis.tick_params(labelsize=7)
    axis.set_title(f"{frames.parent}, the camera, and the board in every view [m]", fontsize=9)


def draw(found, view_set, file):
    """Writes the image of a result. Raises ImportError where matplotlib is missing."""
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    figure = plt.figure(figsize=(12, 8.6))
    _draw_typical(figure.add_subplot(2, 2, 1), found, view_set)
    _draw_space(figure.add_subplot(2, 2, 2, projection="3d"), found, view_set)
    _draw_residuals(figure.add_subplot(2, 2, 3), found, view_set)
    _draw_views(figure.add_subplot(2, 2, 4), found, view_set)
    child, child_T_camera = view_set.frames.child_T_camera()
    pose = found.parent_T_camera @ rd.inverse(child_T_camera)
    figure.suptitle(f"{child} in {view_set.frames.parent}: ({', '.join(f'{value:.4f}' for value in pose[:3, 3])}) m, "
                    f"+- {1000 * found.sigma_m:.1f} mm and {math.degrees(found.sigma_rad):.2f} degrees", fontsize=11)
    figure.tight_layout()
    figure.savefig(file, dpi=100)
    plt.close(figure)

"""Estimated distances of held objects against forward kinematics: references, statistics, table, plot. No ROS."""

import collections
import csv
import math

import numpy

from grasp_scene import SHAPES

BOXES = {"network": "boxes of the network", "truth": "true boxes"}
KINDS = {"centre": "centre of the object", "surface": "visible surface"}
COLOURS = {"cube": "tab:blue", "sphere": "tab:green", "cone": "tab:orange"}

# One estimate: shape, boxes (a key of BOXES), kind (of KINDS), set distance, estimate and reference [m].
Measure = collections.namedtuple("Measure", "shape boxes kind range_m estimate_m reference_m")
# What became of the images at one distance.
Seen = collections.namedtuple("Seen", "shape boxes range_m images boxes_found estimates")


def ray_hits(shape, camera_T_object, direction):
    """Distance [m] along a ray of the camera (3, length 1) to the surface of a held object; None: the ray misses it.

    The object's frame is the middle of its bounding box, z up its axis.
    """
    object_T_camera = numpy.linalg.inv(camera_T_object)
    start, along = object_T_camera[:3, 3], object_T_camera[:3, :3] @ direction
    width, height = SHAPES[shape].width, SHAPES[shape].height
    hits = {"sphere": lambda: _sphere_hits(start, along, width / 2), "cube": lambda: _box_hits(start, along, width / 2),
            "cone": lambda: _cone_hits(start, along, width / 2, height)}[shape]()
    return min((hit for hit in hits if hit > 0), default=None)


def _roots(a, b, c):
    """Of a x^2 + 2 b x + c."""
    if abs(a) < 1e-12:
        return [-c / (2 * b)] if abs(b) > 1e-12 else []
    inside = b * b - a * c
    return [] if inside < 0 else [(-b - math.sqrt(inside)) / a, (-b + math.sqrt(inside)) / a]


def _sphere_hits(start, along, radius):
    return _roots(along @ along, start @ along, start @ start - radius ** 2)


def _box_hits(start, along, half):
    with numpy.errstate(divide="ignore", invalid="ignore"):
        one, other = (-half - start) / along, (half - start) / along
    enter, leave = numpy.nanmax(numpy.minimum(one, other)), numpy.nanmin(numpy.maximum(one, other))
    return [enter] if enter <= leave else []


def _cone_hits(start, along, radius, height):
    """Mantle and base; the tip is at z = height / 2."""
    slope = (radius / height) ** 2
    to_tip = numpy.array([start[0], start[1], start[2] - height / 2])
    signs = numpy.array([1, 1, -slope])
    mantle = [hit for hit in _roots((signs * along) @ along, (signs * to_tip) @ along, (signs * to_tip) @ to_tip)
              if abs(start[2] + hit * along[2]) <= height / 2]
    if abs(along[2]) < 1e-12:
        return mantle
    base = (-height / 2 - start[2]) / along[2]
    return mantle + ([base] if numpy.hypot(*(start + base * along)[:2]) <= radius else [])


def statistics(measures):
    """n, mean error (signed), mean |error|, RMS, largest |error| [m], mean |error| / distance; None without
    measures."""
    if not measures:
        return None
    errors = numpy.array([one.estimate_m - one.reference_m for one in measures])
    relative = numpy.abs(errors) / numpy.array([one.reference_m for one in measures])
    return {"n": len(errors), "mean_m": float(errors.mean()), "mean_abs_m": float(numpy.abs(errors).mean()),
            "rms_m": float(numpy.sqrt((errors ** 2).mean())), "max_m": float(numpy.abs(errors).max()),
            "mean_percent": float(100 * relative.mean())}


def table(measures, seen, min_range_m):
    """Lines for people: objects at distances of min_range_m and more, then nearer ones."""
    lines = []
    for kind, kind_text in KINDS.items():
        for boxes, boxes_text in BOXES.items():
            far = [one for one in measures if one.kind == kind and one.boxes == boxes and one.range_m >= min_range_m]
            if any(one.boxes == boxes for one in seen):
                lines += [f"{kind_text}, {boxes_text}:"] + _rows(far, [s for s in seen if s.range_m >= min_range_m],
                                                                 boxes)
    near = sorted({one.range_m for one in seen if one.range_m < min_range_m})
    return lines + [line for range_m in near for line in _near_rows(measures, seen, range_m)]


def _rows(measures, seen, boxes):
    lines = [
        f"  {'object':<8}{'images':>7}{'boxes':>7}{'n':>6}{'mean':>9}{'mean ||':>9}{'RMS':>9}{'largest':>9}  [mm]{'%':>7}"
    ]
    for shape in dict.fromkeys(one.shape for one in seen):
        counts = [one for one in seen if one.shape == shape and one.boxes == boxes]
        images, found = sum(one.images for one in counts), sum(one.boxes_found for one in counts)
        figures = statistics([one for one in measures if one.shape == shape])
        row = f"  {shape:<8}{images:>7}{found:>7}"
        if figures is None:
            lines.append(row + f"{0:>6}   no estimate")
            continue
        lines.append(row + f"{figures['n']:>6}" + "".join(f"{1000 * figures[key]:>9.1f}" for key in
                                                          ("mean_m", "mean_abs_m", "rms_m", "max_m")) +
                     f"{figures['mean_percent']:>13.2f}")
    return lines


def _near_rows(measures, seen, range_m):
    lines = [f"at {range_m:.3f} m, nearer than the camera measures:"]
    for one in seen:
        if one.range_m == range_m:
            figures = statistics([m for m in measures if (m.shape, m.boxes, m.kind, m.range_m) ==
                                  (one.shape, one.boxes, "centre", range_m)])
            what = "no estimate" if figures is None else f"{one.estimates} estimates, mean error {1000 * figures['mean_m']:.0f} mm"
            lines.append(f"  {one.shape:<8}{BOXES[one.boxes]}: {one.images} images, {one.boxes_found} boxes, {what}")
    return lines


def write_csv(measures, file):
    with open(file, "w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream)
        writer.writerow(["object", "boxes", "point", "range_m", "forward_kinematics_m", "estimate_m", "error_m"])
        for one in measures:
            writer.writerow([
                one.shape, one.boxes, one.kind, f"{one.range_m:.4f}", f"{one.reference_m:.5f}", f"{one.estimate_m:.5f}",
                f"{one.estimate_m - one.reference_m:.5f}"
            ])


def as_dict(measures, seen, min_range_m):
    """For JSON."""
    far = [one for one in measures if one.range_m >= min_range_m]
    groups = collections.OrderedDict()
    for one in far:
        groups.setdefault((one.shape, one.boxes, one.kind), []).append(one)
    return {"min_range_m": min_range_m,
            "summary": [{"object": shape, "boxes": boxes, "point": kind, **statistics(group)}
                        for (shape, boxes, kind), group in groups.items()],
            "images": [one._asdict() for one in seen], "estimates": [one._asdict() for one in measures]}


def plot(measures, min_range_m, file):
    """A column per object: estimated over computed distance, and the error below."""
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    shapes = list(dict.fromkeys(one.shape for one in measures))
    far = [
        abs(one.estimate_m - one.reference_m) for one in measures if one.range_m >= min_range_m and one.kind == "centre"
    ]
    limit_mm = 1300 * max(far, default=0.01)  # errors of nearer objects are drawn at the edge
    figure, axes = plt.subplots(2,
                                len(shapes),
                                figsize=(4 * len(shapes), 6.6),
                                sharex=True,
                                sharey="row",
                                squeeze=False,
                                gridspec_kw={"height_ratios": [3, 2]})
    for (top, bottom), shape in zip(axes.T, shapes):
        for boxes, marker, size in (("truth", "o", 22), ("network", "x", 26)):
            some = [one for one in measures if (one.shape, one.boxes, one.kind) == (shape, boxes, "centre")]
            if not some:
                continue
            figures = statistics([one for one in some if one.range_m >= min_range_m])
            reference = numpy.array([one.reference_m for one in some])
            error_mm = 1000 * numpy.array([one.estimate_m - one.reference_m for one in some])
            colour = COLOURS[shape] if boxes == "truth" else "black"
            label = BOXES[boxes] + (f": RMS {1000 * figures['rms_m']:.1f} mm" if figures else "")
            style = {"s": size, "marker": marker, "linewidths": 1, "color": colour}
            if boxes == "truth":
                style.update(facecolors="none", edgecolors=colour)
                del style["color"]
            top.scatter(reference, reference + error_mm / 1000, label=label, **style)
            bottom.scatter(reference, numpy.clip(error_mm, -limit_mm, limit_mm), **style)
        farthest = max(one.reference_m for one in measures) + 0.05
        top.plot([0, farthest], [0, farthest], color="0.6", linewidth=0.8, zorder=0)
        bottom.axhline(0, color="0.6", linewidth=0.8, zorder=0)
        for axis in (top, bottom):
            axis.axvspan(0, min_range_m, color="0.9", zorder=0)
            axis.grid(alpha=0.3)
            axis.set_xlim(min(one.reference_m for one in measures) - 0.05, farthest)
        top.set_ylim(0, farthest)
        top.set_title(shape)
        top.legend(fontsize=8, loc="upper left")
        bottom.set_xlabel("forward kinematics [m]")
    axes[0, 0].set_ylabel("estimated distance [m]")
    axes[1, 0].set_ylabel("error [mm]")
    axes[1, 0].set_ylim(-1.05 * limit_mm, 1.05 * limit_mm)
    figure.tight_layout()
    figure.savefig(file, dpi=100)
    plt.close(figure)

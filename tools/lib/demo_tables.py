"""Tables of the demonstration: one line per object on the terminal, and table.csv."""

import csv
import statistics
import sys

from truth import Score


class Table:
    """Prints one line per object, keeps totals, writes table.csv."""

    COLUMNS = (("frame", 6), ("class", 14), ("score", 6), ("box x0 y0 x1 y1 [px]", 22), ("depth [m]", 10),
               ("x y z [m]", 22), ("+- [cm]", 8))
    # From depth_m to sigma_m: the measured point of the surface.
    FILE_COLUMNS = ("frame", "stamp", "class", "score", "x0", "y0", "x1", "y1", "depth_m", "x_m", "y_m", "z_m", "sigma_m")
    HEADLINE = ("Measured points of the objects' surfaces (detections_3d/surface) in frame {}; depth along the camera's "
                "axis")

    def __init__(self, folder, frame_id):
        self.frame_id = frame_id
        self.frames = 0
        self.objects = 0
        self.latencies_ms = []
        self.file = open(folder / "table.csv", "w", newline="")
        self.csv = csv.writer(self.file)
        self.csv.writerow(self.FILE_COLUMNS)

    def header(self):
        print(f"\n{self.HEADLINE.format(self.frame_id)}\n")
        self._print(name for name, _ in self.COLUMNS)
        self._print("-" * width for _, width in self.COLUMNS)
        sys.stdout.flush()

    def frame(self, stamp, rows, latency_ms):
        self.latencies_ms.append(latency_ms)
        for row in rows:
            self._print(self._cells(row))
            self.csv.writerow((self.frames, f"{stamp.to_sec():.6f}", *self._values(row)))
        if not rows:
            self._print((str(self.frames), "(nothing)"))
        self.frames += 1
        self.objects += len(rows)
        sys.stdout.flush()

    def _print(self, cells):
        print("  ".join(cell.ljust(width) for cell, (_, width) in zip(cells, self.COLUMNS)))

    def _cells(self, row):
        located = "position" in row
        return (str(self.frames), row["class"], f"{row['score']:.2f}", " ".join(f"{v:5.0f}" for v in row["box"]),
                f"{row['depth']:.3f}" if located else "none",
                " ".join(f"{v:6.2f}" for v in row["position"]) if located else "",
                f"{100 * row['sigma']:.1f}" if located else "")

    def _values(self, row):
        """Of a line of table.csv, from the class on."""
        return (row["class"], f"{row['score']:.3f}", *(f"{v:.1f}" for v in row["box"]),
                *(f"{v:.4f}" for v in row.get("xyz_csv", ())))

    def close(self):
        self.file.close()

    def summary(self):
        """Lines for people."""
        if not self.frames:
            return []
        return [f"{self.frames} frames, {self.objects} objects; from image to 3D detections "
                f"{statistics.median(self.latencies_ms):.1f} ms (median)"]


class TruthTable(Table):
    """As Table, with the simulator's truth beside every position."""

    COLUMNS = (("frame", 6), ("class", 10), ("score", 6), ("centre x y z [m]", 22), ("nearest true one [m]", 22),
               ("error [cm]", 10), ("", 6))
    FILE_COLUMNS = (*Table.FILE_COLUMNS, "found", "center_x_m", "center_y_m", "center_z_m", "true_x_m", "true_y_m",
                    "true_z_m", "error_m")
    HEADLINE = ("Estimated centres of the objects (detections_3d) in frame {}, and the centre of the "
                "nearest\nobject of the same class (sim/truth/objects)")

    def __init__(self, folder, frame_id):
        super().__init__(folder, frame_id)
        self.score = Score()

    def frame(self, stamp, rows, latency_ms, visible, matches):
        super().frame(stamp, rows, latency_ms)
        self.score.add(visible, matches,
                       [row["nearest"].error_m for row in rows if row["found"] and row.get("nearest")])

    def _cells(self, row):
        near = row.get("nearest")
        return (str(self.frames), row["class"], f"{row['score']:.2f}",
                " ".join(f"{v:6.2f}" for v in row["center"]) if "center" in row else "no depth",
                " ".join(f"{v:6.2f}" for v in near.object.position) if near else "none",
                f"{100 * near.error_m:.1f}" if near else "", "" if row["found"] else "false")

    def _values(self, row):
        near = row.get("nearest")
        values = super()._values(row)
        values += ("",) * (len(Table.FILE_COLUMNS) - 2 - len(values))  # a box without depth
        return (*values, int(row["found"]), *(f"{v:.4f}" for v in row.get("center", ())),
                *((f"{v:.4f}" for v in (*near.object.position, near.error_m)) if near else ()))

    def summary(self):
        lines = super().summary() + self.score.summary()
        if self.score.frames:
            lines.append("An object counts as found when a box of its class overlaps the visible part by half "
                         "(intersection over union); the truth of a position is the object's centre.")
        return lines

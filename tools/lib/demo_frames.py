"""Joins what belongs to one image: boxes, annotated image, positions, and in the simulator the truth."""

import collections
import threading

import cv2
import numpy

from truth import Box, TrueObject, match, nearest

OPTICAL_FRAME = "camera_color_optical_frame"


def corners(bbox):
    """x0 y0 x1 y1 [px] of a vision_msgs/BoundingBox2D."""
    x, y, w, h = bbox.center.x, bbox.center.y, bbox.size_x, bbox.size_y
    return (x - w / 2, y - h / 2, x + w / 2, y + h / 2)


def vector(message):
    """The three numbers of a Point or Vector3."""
    return (message.x, message.y, message.z)


class Watcher:
    """Joins detections, their centres and surface points, and annotated images of one stamp; hands complete frames on."""

    KEPT = 20  # stamps waited for at the same time
    PARTS = frozenset({"boxes", "image", "objects", "surface"})  # of a complete frame

    def __init__(self, options, table):
        import rospy
        import sensor_msgs.msg
        import tf2_ros
        import vision_msgs.msg

        self.rospy = rospy
        self.options = options
        self.table = table
        self.names = []
        self.parts = {}
        self.lock = threading.Lock()
        self.complete = 0
        self.tf = tf2_ros.Buffer()
        self.listener = tf2_ros.TransformListener(self.tf)
        rospy.Subscriber("detections", vision_msgs.msg.Detection2DArray, self._add, "boxes", queue_size=20)
        rospy.Subscriber("detections/image", sensor_msgs.msg.Image, self._add, "image", queue_size=20, buff_size=2**24)
        rospy.Subscriber("vision_info", vision_msgs.msg.VisionInfo, self._info)
        # Last, because the recording starts when this chain is wanted.
        for topic, part in (("detections_3d/surface", "surface"), ("detections_3d", "objects")):
            rospy.Subscriber(topic, vision_msgs.msg.Detection3DArray, self._add, part, queue_size=20)

    def _info(self, message):
        self.names = self.rospy.get_param(message.database_location, [])

    def _add(self, message, part):
        with self.lock:
            entry = self.parts.setdefault(message.header.stamp, {})
            entry[part] = message
            if part == "objects":
                entry["latency_ms"] = 1e3 * (self.rospy.Time.now() - message.header.stamp).to_sec()
            if self.PARTS <= entry.keys():
                self._finish(message.header.stamp, self.parts.pop(message.header.stamp))
            while len(self.parts) > self.KEPT:
                del self.parts[min(self.parts)]

    def _finish(self, stamp, entry):
        rows = self._rows(entry["boxes"], list(zip(entry["objects"].detections, entry["surface"].detections)))
        if self.complete == 0:
            self.table.header()
        self._write_image(entry["image"], rows)
        self._report(stamp, rows, entry)
        self.complete += 1

    def _report(self, stamp, rows, entry):
        self.table.frame(stamp, rows, entry["latency_ms"])

    def _name(self, class_id):
        return self.names[class_id] if class_id < len(self.names) else str(class_id)

    def _rows(self, boxes, located):
        """One row per box; `located` are object and surface of the boxes that have a depth, in the same order."""
        rows, rest = [], list(located)
        for detection in boxes.detections:
            best = detection.results[0]
            row = {"class": self._name(best.id), "score": best.score, "box": corners(detection.bbox)}
            if rest and (rest[0][0].results[0].id, rest[0][0].results[0].score) == (best.id, best.score):
                self._locate(row, *rest.pop(0))
            rows.append(row)
        return rows

    def _locate(self, row, item, surface):
        """Adds the object's centre; and depth, position and standard deviation of the point that was measured."""
        row["center"] = vector(item.results[0].pose.pose.position)
        measured = surface.results[0].pose
        row["position"] = vector(measured.pose.position)
        covariance = numpy.array(measured.covariance).reshape(6, 6)[:3, :3]
        row["sigma"] = float(numpy.sqrt(max(numpy.linalg.eigvalsh(covariance)[-1], 0.0)))
        row["depth"] = self._depth(measured.pose, surface.header)
        row["xyz_csv"] = (row["depth"], *row["position"], row["sigma"])

    def _depth(self, pose, header):
        """Distance along the optical axis [m]; a surface point has the axes of the optical frame, so its third is that axis."""
        q = pose.orientation
        axis = numpy.array([2 * (q.x * q.z + q.y * q.w), 2 * (q.y * q.z - q.x * q.w), 1 - 2 * (q.x * q.x + q.y * q.y)])
        return float(axis @ (numpy.array(vector(pose.position)) - self._camera_position(header)))

    def _camera_position(self, header):
        """Where the camera was when it took the image, in the table's frame [m]."""
        if header.frame_id == OPTICAL_FRAME:
            return numpy.zeros(3)
        found = self.tf.lookup_transform(header.frame_id, OPTICAL_FRAME, header.stamp, self.rospy.Duration(0.5))
        return numpy.array(vector(found.transform.translation))

    def _write_image(self, message, rows):
        limit = 300  # images; a demo that runs for hours must not fill the disk
        if self.complete >= limit:
            return
        image = numpy.frombuffer(message.data, numpy.uint8).reshape(message.height, message.step)
        image = image[:, :message.width * 3].reshape(message.height, message.width, 3).copy()
        for row in rows:
            if "depth" in row:
                x0, y0, x1, y1 = row["box"]
                text, font, scale = f"{row['depth']:.2f} m", cv2.FONT_HERSHEY_SIMPLEX, 0.5
                (width, _), _ = cv2.getTextSize(text, font, scale, 1)
                origin = (int((x0 + x1 - width) / 2), int((y0 + y1) / 2))
                cv2.putText(image, text, origin, font, scale, (0, 0, 0), 3, cv2.LINE_AA)
                cv2.putText(image, text, origin, font, scale, (255, 255, 255), 1, cv2.LINE_AA)
        cv2.imwrite(str(self.options.out / f"{self.complete:06d}.png"), image)


class TruthWatcher(Watcher):
    """As Watcher, and compares each detection with what the simulator knows."""

    PARTS = Watcher.PARTS | {"visible"}
    REMEMBERED = 40  # messages of objects' true poses

    def __init__(self, options, table):
        super().__init__(options, table)
        import vision_msgs.msg

        self.truth_names = []
        self.truths = collections.deque(maxlen=self.REMEMBERED)
        self.rospy.Subscriber("sim/truth/vision_info", vision_msgs.msg.VisionInfo, self._truth_info)
        self.rospy.Subscriber("sim/truth/objects", vision_msgs.msg.Detection3DArray, self.truths.append, queue_size=5)
        self.rospy.Subscriber("sim/truth/detections", vision_msgs.msg.Detection2DArray, self._add, "visible",
                              queue_size=20)

    def _truth_info(self, message):
        self.truth_names = self.rospy.get_param(message.database_location, [])

    def _objects(self, stamp):
        """What has a class, where it was nearest to this time."""
        if not self.truths:
            return []
        message = min(list(self.truths), key=lambda m: abs((m.header.stamp - stamp).to_sec()))
        return [TrueObject(self.truth_names[d.results[0].id], vector(d.bbox.center.position)) for d in message.detections
                if d.results[0].id < len(self.truth_names)]

    def _visible(self, message):
        """Boxes of visible objects of a class that the detector knows."""
        named = ((self.truth_names[d.results[0].id], corners(d.bbox)) for d in message.detections
                 if d.results[0].id < len(self.truth_names))
        return [Box(label, box) for label, box in named if label in self.names]

    def _finish(self, stamp, entry):
        if self.names and self.truth_names and self.truths:  # else the simulation has just begun
            super()._finish(stamp, entry)

    def _report(self, stamp, rows, entry):
        rows.sort(key=lambda row: -row["score"])
        visible, objects = self._visible(entry["visible"]), self._objects(stamp)
        matches = match([Box(row["class"], row["box"]) for row in rows], visible)
        for row, index in zip(rows, matches):
            row["found"] = index is not None
            if "center" in row:
                row["nearest"] = nearest(row["class"], row["center"], objects)
        self.table.frame(stamp, rows, entry["latency_ms"], len(visible), matches)

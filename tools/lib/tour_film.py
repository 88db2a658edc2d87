"""An animation of tools/demo tour: the camera's image with what is detected, and the growing map with robot and plan."""

import math
import threading

import cv2
import numpy

try:
    from PIL import Image
except ModuleNotFoundError:
    Image = None

HEIGHT, WIDTH = 400, 533      # of each half
CAPTION = 34
PERIOD_S = 1.2                # of simulated time, between two images
DELAY_CS = 9                  # hundredths of a second that each is shown
MAP_M = (-3.0, -4.1, 7.0, 4.1)  # x, y from, x, y to: of the map
CHASSIS = numpy.array([(0.41, 0.39), (-0.41, 0.39), (-0.41, -0.39), (0.41, -0.39)])
QUALITY = 55


class Film:
    """Collects images while a task runs; call tick() often."""

    def __init__(self, observer):
        import nav_msgs.msg
        import rospy
        import sensor_msgs.msg
        import std_msgs.msg
        import vision_msgs.msg
        self.observer, self.lock, self.frames, self.next_s = observer, threading.Lock(), [], 0.0
        self.newest, self.names, self.rospy = {}, {}, rospy
        for topic, kind in (("camera/color/image_raw", sensor_msgs.msg.Image), ("detections", vision_msgs.msg.Detection2DArray),
                            ("map", nav_msgs.msg.OccupancyGrid), ("move_base/global_plan", nav_msgs.msg.Path),
                            ("task/say", std_msgs.msg.String)):
            rospy.Subscriber(topic, kind, self._on_message, topic, queue_size=1, buff_size=1 << 22)
        rospy.Subscriber("vision_info", vision_msgs.msg.VisionInfo, self._on_info)

    def _on_message(self, message, topic):
        with self.lock:
            self.newest[topic] = message

    def _on_info(self, message):
        self.names = dict(enumerate(self.rospy.get_param(message.database_location, [])))

    def tick(self, stage):
        now = self.observer.robot.now()
        if now < self.next_s:
            return
        self.next_s = now + PERIOD_S
        with self.lock:
            newest = dict(self.newest)
        if "camera/color/image_raw" in newest and "map" in newest:
            self.frames.append(compose(self._camera(newest), self._map(newest), stage, newest.get("task/say")))

    def _camera(self, newest):
        from extperfc.calibrate.messages import image_of_message
        message = newest["camera/color/image_raw"]
        image = image_of_message(message).copy()
        detections = newest.get("detections")
        if detections is not None and abs((detections.header.stamp - message.header.stamp).to_sec()) < 0.3:
            for one in detections.detections:
                x, y, w, h = one.bbox.center.x, one.bbox.center.y, one.bbox.size_x, one.bbox.size_y
                low, high = (int(x - w / 2), int(y - h / 2)), (int(x + w / 2), int(y + h / 2))
                cv2.rectangle(image, low, high, (60, 220, 60), 3, cv2.LINE_AA)
                name = self.names.get(one.results[0].id, "") if one.results else ""
                cv2.putText(image, name, (low[0], low[1] - 8), cv2.FONT_HERSHEY_SIMPLEX, 0.8, (60, 220, 60), 2, cv2.LINE_AA)
        return cv2.resize(image, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA)

    def _map(self, newest):
        plan = newest.get("move_base/global_plan")
        places = [(pose.pose.position.x, pose.pose.position.y) for pose in plan.poses] if plan is not None else []
        return draw_map(newest["map"], self.observer.path, self.observer.pose, places)

    def save(self, file):
        """An animated WebP. Raises ValueError without an image."""
        if not self.frames:
            raise ValueError("no image of the camera came together with a map")
        images = [Image.fromarray(frame[..., ::-1]) for frame in self.frames]
        images[0].save(file, save_all=True, append_images=images[1:], duration=10 * DELAY_CS, loop=0, quality=QUALITY, method=4)


def draw_map(message, path, pose, plan):
    """The map from MAP_M's corners on, north up, with the robot, its path (blue) and its plan (orange)."""
    scale = min(WIDTH / (MAP_M[2] - MAP_M[0]), HEIGHT / (MAP_M[3] - MAP_M[1]))
    image = numpy.full((HEIGHT, WIDTH, 3), 205, numpy.uint8)

    def pixels(places):
        places = numpy.asarray(places, float).reshape(-1, 2)
        return numpy.column_stack([(places[:, 0] - MAP_M[0]) * scale, HEIGHT - (places[:, 1] - MAP_M[1]) * scale]).astype(numpy.int32)

    info = message.info
    cells = numpy.array(message.data, numpy.int8).reshape(info.height, info.width)
    grey = numpy.where(cells < 0, 205, numpy.where(cells >= 50, 40, 252)).astype(numpy.uint8)
    matrix = numpy.array([[info.resolution * scale, 0, (info.origin.position.x - MAP_M[0]) * scale],
                          [0, -info.resolution * scale, HEIGHT - (info.origin.position.y - MAP_M[1]) * scale]])
    grey = cv2.warpAffine(grey, matrix, (WIDTH, HEIGHT), flags=cv2.INTER_NEAREST, borderValue=205)
    image[:] = grey[..., None]
    if len(path) > 1:
        cv2.polylines(image, [pixels(path)], False, (210, 140, 60), 2, cv2.LINE_AA)
    if len(plan) > 1:
        cv2.polylines(image, [pixels(plan)], False, (30, 140, 250), 2, cv2.LINE_AA)
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    outline = CHASSIS @ numpy.array([[cos, sin], [-sin, cos]]) + pose[:2]
    cv2.fillPoly(image, [pixels(outline)], (150, 90, 40), cv2.LINE_AA)
    cv2.line(image, *map(tuple, pixels([pose[:2], (pose[0] + 0.4 * cos, pose[1] + 0.4 * sin)]).tolist()), (255, 255, 255), 2, cv2.LINE_AA)
    return image


def compose(camera, floor, stage, said):
    image = numpy.vstack([numpy.hstack([camera, numpy.full((HEIGHT, 4, 3), 255, numpy.uint8), floor]),
                          numpy.full((CAPTION, 2 * WIDTH + 4, 3), 255, numpy.uint8)])
    text = stage if said is None else f"{stage} - {said.data}"
    cv2.putText(image, text, (10, HEIGHT + 23), cv2.FONT_HERSHEY_SIMPLEX, 0.6, (40, 40, 40), 1, cv2.LINE_AA)
    return image

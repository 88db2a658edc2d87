"""The guide of a collection: takes views that add something, and says which motion is missing. No ROS is needed."""

import dataclasses

import numpy

from extperfc.calibrate import drawing, motions, views

DEFAULT_VIEWS = 20
STILL_S = 0.3            # the robot has to stand still for so long before an image,
STILL_M = 5e-4           # within this
STILL_RAD = 2e-3


@dataclasses.dataclass(frozen=True)
class Answer:
    """What became of an image."""
    taken: bool
    text: str
    image: numpy.ndarray  # BGR with the corners drawn, or as it was where the board was not searched or not found


def stands_still(now, before):
    """Whether two parent_T_carrier, STILL_S apart, are of a robot at rest."""
    return (numpy.linalg.norm(now[:3, 3] - before[:3, 3]) < STILL_M) and motions.angle_between(now, before) < STILL_RAD


class Collector:
    """Decides about images and writes those that it takes into a folder of views."""

    def __init__(self, folder, camera, board, frames, wanted_views=DEFAULT_VIEWS):
        self._writer = views.FolderWriter(folder, camera, board, frames)
        self._camera, self._board, self._frames, self._wanted = camera, board, frames, wanted_views
        self.poses, self.pixels = [], []

    def offer(self, image, parent_T_carrier, is_still=True):
        """The Answer to an image (BGR or grey) taken at this pose of the robot."""
        if not is_still:
            return Answer(False, "the robot moves: hold it still", image)
        detection = self._board.detect(views.grey_of(image))
        if detection is None:
            return Answer(False, "the board is not seen: bring all of it into the image, without glare", image)
        drawn = drawing.corners_image(image, detection.pixels)
        if not motions.is_new(parent_T_carrier, self.poses):
            return Answer(False, "this view is like one before: " + self.advice(), drawn)
        name = self._writer.add(image, parent_T_carrier)
        self.poses.append(parent_T_carrier)
        self.pixels.append(detection.pixels)
        return Answer(True, f"{name} taken ({len(self.poses)}); " + self.advice(), drawn)

    def _missing(self):
        found = motions.diversity(self.poses, self.pixels, (self._camera.width, self._camera.height))
        return motions.missing(found, self._frames.carrier, self._wanted)

    def advice(self):
        """What to do next."""
        needs = self._missing()
        return "next: " + needs[0] if needs else "enough views"

    def is_complete(self):
        """Whether the views suffice; what is merely advised (coverage of the image) may still be missing."""
        found = motions.diversity(self.poses)
        return not motions.missing(found, self._frames.carrier, self._wanted, coverage_wanted=0.0)

"""What stands upright around the robot, for its arms: the depth camera sees what is before it only."""

from extperfc.tasks.arm_leaves import scene
from extperfc.tasks.leaf import Leaf
from extperfc.tasks.search import Lidar, base_pose

NEAR_M, FAR_M = 0.55, 1.5   # from the base's middle: nearer is the robot itself, farther no arm comes
PREFIX = "around_"          # of the names of these objects in the scene


class SeeAround(Leaf):
    """Puts walls, shelves and cabinets that the lidar has seen around the base, since setup(), into the arm node's scene, as
    boxes from the floor upwards, in place of those of an earlier time. Tables are left out: SeeSupport and the depth camera
    see them better. The base must stand, and the leaf runs again after a drive. Needs the topic `velodyne_points`."""

    def __init__(self, frame="map", name=None):
        super().__init__(name or "see what stands around")
        self.frame = frame

    def setup(self, **_):
        Lidar.of(self.frame)

    def step(self):
        lidar = Lidar.of(self.frame)
        boxes = lidar.boxes(base_pose(self.frame)[:2], NEAR_M, FAR_M)
        arms = scene()
        for name in arms.objects:
            if name.startswith(PREFIX):
                arms.remove(name)
        for number, (size, middle) in enumerate(boxes):
            arms.add_box(f"{PREFIX}{number}", size, middle, self.frame)
        self.feedback_message = f"{len(boxes)} boxes"
        return True

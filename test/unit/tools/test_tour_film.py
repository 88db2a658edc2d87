"""Images of the animation of tools/demo tour."""

import pathlib
import sys
import tempfile
import types
import unittest

import numpy

REPO = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(REPO / "tools" / "lib"))

import tour_film  # noqa: E402

try:
    from PIL import Image
except ModuleNotFoundError:
    Image = None


def grid(cells, resolution, x, y):
    origin = types.SimpleNamespace(position=types.SimpleNamespace(x=x, y=y))
    info = types.SimpleNamespace(width=cells.shape[1], height=cells.shape[0], resolution=resolution, origin=origin)
    return types.SimpleNamespace(info=info, data=cells.ravel().tolist())


def pixel(x, y):
    scale = min(tour_film.WIDTH / (tour_film.MAP_M[2] - tour_film.MAP_M[0]), tour_film.HEIGHT / (tour_film.MAP_M[3] - tour_film.MAP_M[1]))
    return int(tour_film.HEIGHT - (y - tour_film.MAP_M[1]) * scale), int((x - tour_film.MAP_M[0]) * scale)


class Map(unittest.TestCase):
    def setUp(self):
        cells = numpy.zeros((60, 80), numpy.int8)
        cells[40:44, 60:64] = 100  # at (4.0, 2.0) to (4.2, 2.2)
        cells[:, :10] = -1
        self.message = grid(cells, 0.05, 1.0, 0.0)

    def test_walls_free_space_and_the_unknown_are_where_they_are(self):
        image = tour_film.draw_map(self.message, [], (2.5, 0.8, 0.0), [])
        self.assertLess(image[pixel(4.1, 2.1)].max(), 60)
        self.assertGreater(image[pixel(4.1, 1.0)].min(), 240)
        self.assertEqual([205] * 3, image[pixel(1.2, 1.0)].tolist())
        self.assertEqual([205] * 3, image[pixel(-2.0, -2.0)].tolist())

    def test_the_robot_and_its_paths_are_drawn(self):
        image = tour_film.draw_map(self.message, [(1.8, 2.6), (4.5, 2.6)], (2.5, 0.8, 1.57), [(1.8, 1.6), (4.5, 1.6)])
        self.assertEqual([150, 90, 40], image[pixel(2.3, 0.6)].tolist())
        self.assertGreater(int(image[pixel(3.5, 2.6)][0]), int(image[pixel(3.5, 2.6)][2]) + 60, "blue: where it was")
        self.assertGreater(int(image[pixel(3.5, 1.6)][2]), int(image[pixel(3.5, 1.6)][0]) + 60, "orange: where it goes")


@unittest.skipIf(Image is None, "python3-pil is not installed")
class File(unittest.TestCase):
    def film(self, frames):
        made = tour_film.Film.__new__(tour_film.Film)
        made.frames = frames
        return made

    def test_every_image_is_in_it(self):
        camera = numpy.zeros((tour_film.HEIGHT, tour_film.WIDTH, 3), numpy.uint8)
        frames = [tour_film.compose(camera + 60 * i, camera, "search", types.SimpleNamespace(data="done")) for i in range(3)]
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "tour.webp"
            self.film(frames).save(file)
            with Image.open(file) as image:
                self.assertEqual((3, 2 * tour_film.WIDTH + 4), (image.n_frames, image.size[0]))

    def test_none_is_an_error(self):
        with self.assertRaisesRegex(ValueError, "no image of the camera"):
            self.film([]).save("nowhere.webp")


if __name__ == "__main__":
    unittest.main()

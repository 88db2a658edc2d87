"""Boards: their points are found in images, in the right order, and bad ones are refused."""

import math
import pathlib
import re
import sys
import unittest

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import rendered  # noqa: E402

from extperfc.calibrate import board as boards  # noqa: E402

CHESSBOARD = boards.Chessboard(9, 6, 0.025)
ARUCO = boards.ArucoBoard(5, 4, 0.035, 0.008)


class Found(unittest.TestCase):
    def detect(self, board, **arguments):
        pose = rendered.pose(board, **arguments)
        found = board.detect(rendered.render(board, pose))
        self.assertIsNotNone(found)
        expected = rendered.CAMERA.project(board.points()[found.indices], pose)
        return found, numpy.linalg.norm(found.pixels - expected, axis=1)

    def test_all_corners_of_a_chessboard_are_found_within_a_fifth_of_a_pixel(self):
        found, errors = self.detect(CHESSBOARD)
        self.assertEqual(list(range(54)), list(found.indices))
        self.assertLess(errors.max(), 0.2)

    def test_a_board_that_is_upside_down_has_its_corners_in_the_same_order(self):
        for roll in (0.5 * math.pi, math.pi, -0.5 * math.pi):
            with self.subTest(roll=roll):
                _, errors = self.detect(CHESSBOARD, tilt=(0.2, -0.2, roll))
                self.assertLess(errors.max(), 0.2)

    def test_markers_are_found_within_half_a_pixel(self):
        found, errors = self.detect(ARUCO)
        self.assertEqual(80, len(found.indices))
        self.assertLess(errors.max(), 0.5)

    def test_markers_suffice_where_part_of_the_board_is_outside(self):
        found, errors = self.detect(ARUCO, middle=(0.22, 0.0))
        self.assertLess(len(found.indices), 80)
        self.assertLess(errors.max(), 0.5)

    def test_an_image_without_the_board_has_none(self):
        empty = numpy.full((480, 640), 128, numpy.uint8)
        for board in (CHESSBOARD, ARUCO):
            self.assertIsNone(board.detect(empty))
        outside = rendered.render(CHESSBOARD, rendered.pose(CHESSBOARD, middle=(0.3, 0.0)))
        self.assertIsNone(CHESSBOARD.detect(outside))


class Described(unittest.TestCase):
    def test_texts_and_dictionaries_describe_boards(self):
        self.assertEqual(CHESSBOARD, boards.parse_board("chessboard:9x6:0.025"))
        self.assertEqual(ARUCO, boards.parse_board("aruco:5x4:0.035:0.008"))
        self.assertEqual("DICT_5X5_50", boards.parse_board("aruco:5x4:0.035:0.008:DICT_5X5_50").dictionary)
        for board in (CHESSBOARD, ARUCO):
            self.assertEqual(board, boards.board_of_dict(board.as_dict()))

    def test_bad_boards_are_refused_with_a_remedy(self):
        for text, remedy in (("chessboard:8x6:0.025", "8 x 7"), ("chessboard:9x6:25", "metres"),
                             ("chessboard:2x3:0.02", "3 x 3"), ("paper:9x6:0.025", "chessboard:9x6:0.025"),
                             ("aruco:5x4:0.03", "aruco:5x4:0.03:0.006"), ("aruco:20x20:0.03:0.01", "larger dictionary"),
                             ("aruco:5x4:0.03:0.006:DICT_9", "DICT_4X4_100")):
            with self.subTest(text), self.assertRaisesRegex(boards.BoardError, remedy):
                boards.parse_board(text)
        with self.assertRaisesRegex(boards.BoardError, "kind must be one of"):
            boards.board_of_dict({"kind": "paper"})

    def test_the_print_has_true_size(self):
        text = boards.svg(CHESSBOARD)
        self.assertIn('width="300.000mm" height="225.000mm"', text)
        self.assertEqual(35 + 1, len(re.findall("<rect", text)))  # 10 x 7 squares, half of them black, on white


if __name__ == "__main__":
    unittest.main()

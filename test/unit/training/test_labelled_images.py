"""Reading, checking, splitting and augmenting labelled images."""

import json
import pathlib
import shutil
import sys
import tempfile
import unittest

import cv2
import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "src"))

from extperfc.training.data import DataError, coco, drawn, read_dataset, scan  # noqa: E402
from extperfc.training.data.fingerprints import are_alike, fingerprint, groups_of, near_pairs, phash  # noqa: E402
from extperfc.training.data.placement import make_input, place  # noqa: E402
from extperfc.training.data.splits import split_names, write_splits  # noqa: E402
from extperfc.training.data.validation import check  # noqa: E402

OBJECT = ("<object><name>{}</name><difficult>{}</difficult><bndbox><xmin>{}</xmin><ymin>{}</ymin><xmax>{}</xmax>"
          "<ymax>{}</ymax></bndbox></object>")


def write_image(file, seed, size=(64, 48)):
    file.parent.mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng(seed)
    coarse = rng.integers(0, 255, (6, 8, 3), np.uint8)
    cv2.imwrite(str(file), cv2.resize(coarse, size, interpolation=cv2.INTER_CUBIC))


def write_voc(root, images, labels=("cone", "cube")):
    """images: {name: [(class, difficult, xmin, ymin, xmax, ymax)]}, corners as in the files."""
    for folder in ("Annotations", "JPEGImages", "ImageSets/Main"):
        (root / folder).mkdir(parents=True, exist_ok=True)
    (root / "labels.txt").write_text("\n".join(labels) + "\n")
    for number, (name, objects) in enumerate(images.items()):
        write_image(root / "JPEGImages" / f"{name}.png", number)
        write_labels(root, name, objects)


def write_labels(root, name, objects, size=(64, 48)):
    text = "".join(OBJECT.format(*o) for o in objects)
    (root / "Annotations" / f"{name}.xml").write_text(
        f"<annotation><filename>{name}.png</filename><size><width>{size[0]}</width><height>{size[1]}</height>"
        f"<depth>3</depth></size>{text}</annotation>")


class Folder(unittest.TestCase):
    def setUp(self):
        self.place = tempfile.TemporaryDirectory()
        self.addCleanup(self.place.cleanup)
        self.root = pathlib.Path(self.place.name) / "set"

    def kinds(self, path=None):
        return sorted({p.kind for p in check(path or self.root).problems})


class PascalVoc(Folder):
    def test_corners_count_from_one_and_include_both_ends(self):
        write_voc(self.root, {"a": [("cube", 0, 1, 1, 64, 48), ("cone", 1, 11, 21, 20, 30)], "b": []})
        (self.root / "ImageSets/Main/train.txt").write_text("a\n")
        (self.root / "ImageSets/Main/val.txt").write_text("b\n")
        (self.root / "ImageSets/Main/trainval.txt").write_text("a\nb\n")
        dataset = read_dataset(self.root)
        np.testing.assert_array_equal([[0, 0, 64, 48], [10, 20, 20, 30]], dataset.samples[0].boxes)
        self.assertEqual([1, 0], dataset.samples[0].labels.tolist())
        self.assertEqual([False, True], dataset.samples[0].difficult.tolist())
        self.assertEqual({"train": ("a",), "val": ("b",)}, dataset.splits)
        self.assertEqual(0, len(dataset.split("val").samples[0].boxes))
        self.assertEqual({"cone": 1, "cube": 1}, dataset.counts())

    def test_every_error_is_named_at_once(self):
        write_voc(
            self.root, {
                "a": [("cup", 0, 1, 1, 9, 9)],
                "b": [("cone", 0, 20, 5, 10, 9)],
                "c": [("cone", 0, 5, 6, 4, 9)],
                "d": [("cone", 0, 70, 5, 90, 9)],
                "e": [],
                "f": []
            })
        (self.root / "JPEGImages/e.png").unlink()
        (self.root / "Annotations/f.xml").write_text("<annotation>")
        with self.assertRaises(DataError) as raised:
            read_dataset(self.root)
        for text in ("6 errors", "\"cup\", which labels.txt does not list", "corners exchanged", "is empty",
                     "outside its image", "no image JPEGImages/e.jpg", "is no XML"):
            self.assertIn(text, str(raised.exception))

    def test_a_box_over_the_edge_is_cut_and_reported(self):
        write_voc(self.root, {"a": [("cone", 0, 50, 30, 80, 40)]})
        dataset, problems = scan(self.root)
        np.testing.assert_array_equal([[49, 29, 64, 40]], dataset.samples[0].boxes)
        self.assertEqual([("box_over_edge", False)], [(p.kind, p.is_error) for p in problems])

    def test_names_of_splits_without_an_image_are_errors(self):
        write_voc(self.root, {"a": []})
        (self.root / "ImageSets/Main/train.txt").write_text("a\nghost\n")
        self.assertEqual(["unknown_name"], [p.kind for p in scan(self.root)[1] if p.is_error])

    def test_a_folder_of_neither_format_is_refused(self):
        self.root.mkdir()
        with self.assertRaisesRegex(DataError, "neither a Pascal VOC folder"):
            read_dataset(self.root)
        with self.assertRaisesRegex(DataError, "no such file"):
            read_dataset(self.root / "nowhere")

    def test_other_classes_are_mapped_or_refused(self):
        write_voc(self.root, {"a": [("cube", 0, 1, 1, 9, 9)]}, ("cone", "cube"))
        dataset = read_dataset(self.root)
        self.assertEqual([0], dataset.with_classes(("cube", "sphere")).samples[0].labels.tolist())
        with self.assertRaisesRegex(DataError, "objects of cube, but the classes to learn are cone"):
            dataset.with_classes(("cone",))


class Coco(Folder):
    def test_is_the_same_as_voc(self):
        write_voc(self.root, {"a": [("cube", 0, 3, 4, 30, 40), ("cone", 1, 11, 21, 20, 30)], "b": []})
        voc = read_dataset(self.root)
        checksum = voc.checksum()
        shutil.rmtree(self.root / "Annotations")
        (self.root / "JPEGImages").rename(self.root / "images")
        (self.root / "annotations").mkdir()
        (self.root / "annotations" / "instances_train2017.json").write_text(json.dumps(coco.to_coco(voc)))
        found = read_dataset(self.root)
        self.assertEqual({"train": ("a", "b")}, found.splits)
        self.assertEqual(voc.class_names, found.class_names)
        for one, other in zip(voc.samples, found.samples):
            np.testing.assert_array_equal(one.boxes, other.boxes)
            np.testing.assert_array_equal(one.labels, other.labels)
            np.testing.assert_array_equal(one.difficult, other.difficult)
        self.assertEqual(checksum, found.checksum())

    def test_errors(self):
        write_image(self.root / "images/a.png", 1)
        (self.root / "all.json").write_text(json.dumps({
            "images": [{"id": 1, "file_name": "a.png", "width": 64, "height": 48}, {"id": 2, "file_name": "gone.png"}],
            "categories": [{"id": 7, "name": "cone"}],
            "annotations": [{"id": 1, "image_id": 9, "category_id": 7, "bbox": [0, 0, 5, 5]},
                            {"id": 2, "image_id": 1, "category_id": 8, "bbox": [0, 0, 5, 5]},
                            {"id": 3, "image_id": 1, "category_id": 7, "bbox": [0, 0, 5]},
                            {"id": 4, "image_id": 1, "category_id": 7, "bbox": [10, 10, -4, 5]},
                            {"id": 5, "image_id": 1, "category_id": 7, "bbox": [10, 10, 20, 5]}]}))
        dataset, problems = scan(self.root)
        self.assertEqual(["bad_annotation", "unknown_class", "bad_annotation", "missing_image", "inverted_box"],
                         [p.kind for p in problems])
        np.testing.assert_array_equal([[10, 10, 30, 15]], dataset.samples[0].boxes)

    def test_splitting_a_file_writes_files_that_are_its_splits(self):
        drawn.write_drawn(self.root, "solids", 12, 1, (64, 48))
        dataset = read_dataset(self.root)
        shutil.rmtree(self.root / "Annotations")
        (self.root / "JPEGImages").rename(self.root / "images")
        (self.root / "all.json").write_text(json.dumps(coco.to_coco(dataset)))
        single = read_dataset(self.root / "all.json")
        names = split_names(single, 3, pairs=[])
        write_splits(single, names, 3)
        (self.root / "all.json").unlink()
        self.assertEqual(names, read_dataset(self.root).splits)


class Checks(Folder):
    def test_a_sound_folder_has_no_errors(self):
        drawn.write_drawn(self.root, "solids", 12, 1, (96, 72))
        report = check(self.root)
        self.assertEqual([], report.errors)
        self.assertIn("0 errors", report.text())
        self.assertEqual(12, report.as_dict()["images"])

    def test_damaged_images_and_wrong_sizes(self):
        write_voc(self.root, {"a": [], "b": [], "c": [("cone", 0, 5, 5, 6, 6)]})
        (self.root / "JPEGImages/a.png").write_bytes(b"no image")
        write_labels(self.root, "b", [], (640, 480))
        found = {(p.kind, p.is_error) for p in check(self.root).problems}
        self.assertLessEqual({("unreadable_image", True), ("wrong_size", True), ("tiny_box", False)}, found)

    def test_duplicates_by_content_and_by_looks(self):
        write_voc(self.root, {"a": [("cone", 0, 5, 5, 20, 20)], "b": [("cone", 0, 5, 5, 20, 20)], "c": [], "d": []})
        shutil.copy(self.root / "JPEGImages/a.png", self.root / "JPEGImages/b.png")
        image = cv2.imread(str(self.root / "JPEGImages/c.png"))
        cv2.imwrite(str(self.root / "JPEGImages/d.png"), np.clip(image.astype(int) + 3, 0, 255).astype(np.uint8))
        problems = [p for p in check(self.root).problems if "duplicate" in p.kind]
        self.assertEqual([("duplicate_image", "b", False), ("near_duplicate", "d", False)],
                         [(p.kind, p.where, p.is_error) for p in problems])
        write_labels(self.root, "b", [])
        self.assertIn("duplicate_image", {p.kind for p in check(self.root).errors})

    def test_leakage_between_splits(self):
        write_voc(self.root, {"a": [], "b": [], "c": []})
        shutil.copy(self.root / "JPEGImages/a.png", self.root / "JPEGImages/b.png")
        (self.root / "ImageSets/Main/train.txt").write_text("a\nc\n")
        (self.root / "ImageSets/Main/test.txt").write_text("b\nc\n")
        leaks = [p for p in check(self.root).errors if p.kind == "split_leak"]
        self.assertEqual(["c", "b"], [p.where for p in leaks])


class Fingerprints(Folder):
    def test_survive_compression_and_brightness_but_not_another_image(self):
        write_image(self.root / "a.png", 1)
        write_image(self.root / "b.png", 2)
        image = cv2.imread(str(self.root / "a.png"))
        cv2.imwrite(str(self.root / "a.jpg"), np.clip(image * 1.02, 0, 255), [cv2.IMWRITE_JPEG_QUALITY, 70])
        one, other, again = (fingerprint(self.root / n) for n in ("a.png", "b.png", "a.jpg"))
        self.assertTrue(are_alike(one, again))
        self.assertFalse(are_alike(one, other))
        self.assertNotEqual(one.sha256, again.sha256)

    def test_bands_find_the_pairs_that_comparing_all_finds(self):
        rng = np.random.default_rng(3)
        base = [rng.integers(0, 255, (32, 32), np.uint8) for _ in range(20)]
        thumbnails = [cv2.GaussianBlur(t, (7, 7), 2) for t in base]
        thumbnails += [np.clip(t + rng.normal(0, 1.5, t.shape), 0, 255).astype(np.uint8) for t in thumbnails]
        prints = [
            type("P", (), {
                "phash": phash(t),
                "thumbnail": t,
                "sha256": str(i)
            }) for i, t in enumerate(thumbnails)
        ]
        every = [(i, j) for i in range(40) for j in range(i + 1, 40) if are_alike(prints[i], prints[j])]
        self.assertGreaterEqual(len(every), 15)
        self.assertEqual(every, near_pairs(prints))

    def test_groups(self):
        self.assertEqual([[0, 2, 4], [1], [3, 5]], groups_of(6, [(4, 2), (0, 4), (3, 5)]))


class Splits(Folder):
    def setUp(self):
        super().setUp()
        drawn.write_drawn(self.root, "household", 100, 5, (64, 48))
        self.dataset = read_dataset(self.root)

    def test_sizes_classes_and_seed(self):
        names = split_names(self.dataset, 1, pairs=[])
        self.assertEqual(100, len({n for members in names.values() for n in members}))
        for split, fraction in (("train", 0.7), ("val", 0.2), ("test", 0.1)):
            self.assertAlmostEqual(fraction, len(names[split]) / 100, delta=0.06)
        self.assertEqual(names, split_names(self.dataset, 1, pairs=[]))
        self.assertNotEqual(names, split_names(self.dataset, 2, pairs=[]))

    def test_stratified_better_than_by_chance(self):
        def imbalance(names):
            counts = np.array([[sum((s.labels == c).sum() for s in self.dataset.samples if s.name in set(members))
                                for c in range(len(self.dataset.class_names))] for members in names.values()])
            return np.abs(counts / counts.sum(0) - np.array([[0.7], [0.2], [0.1]])).mean()
        order = np.random.default_rng(1).permutation([s.name for s in self.dataset.samples])
        chance = {"train": order[:70], "val": order[70:90], "test": order[90:]}
        self.assertLess(imbalance(split_names(self.dataset, 1, pairs=[])), 0.5 * imbalance(chance))

    def test_what_looks_alike_stays_together(self):
        pairs = [(i, i + 1) for i in range(0, 100, 2)]
        home = {name: split for split, members in split_names(self.dataset, 4, pairs=pairs).items() for name in members}
        for i, j in pairs:
            self.assertEqual(home[self.dataset.samples[i].name], home[self.dataset.samples[j].name])

    def test_small_sets_fill_every_split(self):
        for count in (3, 4, 7):
            few = type(self.dataset)(self.root, self.dataset.class_names, self.dataset.samples[:count])
            self.assertTrue(all(split_names(few, 1, pairs=[]).values()), count)
        with self.assertRaisesRegex(DataError, "cannot fill 3 splits"):
            split_names(type(self.dataset)(self.root, self.dataset.class_names, self.dataset.samples[:2]), 1, pairs=[])

    def test_splits_on_disk_are_not_written_over_by_accident(self):
        names = split_names(self.dataset, 1, pairs=[])
        with self.assertRaisesRegex(DataError, "--replace"):
            write_splits(self.dataset, names, 1)
        write_splits(self.dataset, names, 1, replace=True)
        self.assertEqual(names, read_dataset(self.root).splits)


class Placements(unittest.TestCase):
    def test_letterbox_as_on_the_robot(self):
        placement, area = place((640, 480), (320, 256), "letterbox")
        self.assertEqual((0, 8, 320, 240), area)
        np.testing.assert_allclose([[50, 33, 60, 58]], placement.to_input([[100, 50, 120, 100]]))
        np.testing.assert_allclose([[100, 50, 120, 100]],
                                   placement.to_image(placement.to_input([[100, 50, 120, 100]])),
                                   atol=1e-4)

    def test_input_has_grey_bars_and_the_image_between(self):
        image = np.full((30, 40, 3), 200, np.uint8)
        pixels, placement = make_input(image, (64, 64), "letterbox")
        self.assertEqual((64, 64, 3), pixels.shape)
        self.assertTrue((pixels[:8] == 114).all() and (pixels[56:] == 114).all() and (pixels[8:56] == 200).all())
        self.assertEqual((1.6, 1.6, 0.0, 8.0), tuple(round(v, 6) for v in placement))
        self.assertEqual((64, 64, 3), make_input(image, (64, 64), "stretch")[0].shape)


class DrawnImages(Folder):
    def test_the_same_seed_draws_the_same_images(self):
        one = drawn.write_drawn(self.root / "one", "household", 4, 7, (64, 48))
        other = drawn.write_drawn(self.root / "other", "household", 4, 7, (64, 48))
        third = drawn.write_drawn(self.root / "third", "household", 4, 8, (64, 48))
        self.assertEqual(one.checksum(), other.checksum())
        self.assertNotEqual(one.checksum(), third.checksum())

    def test_the_source_domain_has_other_classes(self):
        self.assertGreaterEqual(len(drawn.DOMAINS["household"]), 12)
        self.assertFalse(set(drawn.DOMAINS["household"]) & set(drawn.SOLIDS))

    def test_what_is_read_is_what_was_drawn(self):
        made = drawn.write_drawn(self.root, "solids", 6, 2, (96, 72))
        self.assertEqual(made.checksum(), read_dataset(self.root).checksum())
        self.assertEqual(made.splits, read_dataset(self.root).splits)
        with self.assertRaisesRegex(DataError, "not empty"):
            drawn.write_drawn(self.root, "solids", 6, 2)


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/python3
"""Files of the labelling tool: atomic writing, Pascal VOC, folders, COCO."""

import errno
import json
import pathlib
import struct
import sys
import tempfile
import unittest
import xml.etree.ElementTree
from unittest import mock

import cv2
import numpy

REPO = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(REPO / "src"))

from extperfc import atomic_files  # noqa: E402
from extperfc.label import coco, voc  # noqa: E402
from extperfc.label.boxes import Box  # noqa: E402
from extperfc.label.document import Document  # noqa: E402
from extperfc.label.folder import FolderError, ImageFolder, image_size  # noqa: E402

# As tools/extperfc-render writes it.
RENDERED = b"""<annotation>
  <folder>JPEGImages</folder>
  <filename>000001.jpg</filename>
  <source><database>extperfc-render</database></source>
  <size>
    <width>160</width>
    <height>120</height>
    <depth>3</depth>
  </size>
  <segmented>0</segmented>
  <object>
    <name>cone</name>
    <pose>Unspecified</pose>
    <truncated>1</truncated>
    <occluded>0</occluded>
    <difficult>0</difficult>
    <visible>0.874</visible>
    <bndbox>
      <xmin>1</xmin>
      <ymin>11</ymin>
      <xmax>30</xmax>
      <ymax>60</ymax>
    </bndbox>
  </object>
</annotation>
"""


class Temporary(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.path = pathlib.Path(temporary.name)

    def images(self, count=3, size=(160, 120), folder="JPEGImages"):
        """Writes images 000001.jpg ... of one colour."""
        (self.path / folder).mkdir(exist_ok=True)
        for i in range(1, count + 1):
            cv2.imwrite(str(self.path / folder / f"{i:06d}.jpg"), numpy.full((size[1], size[0], 3), 40 * i,
                                                                             numpy.uint8))
        return self.path


class AtomicFiles(Temporary):
    def test_replaces_and_leaves_nothing_else(self):
        file = self.path / "a.xml"
        for data in (b"first", b"second"):
            atomic_files.replace_file(file, data)
            self.assertEqual(data, file.read_bytes())
        self.assertEqual([file], list(self.path.iterdir()))

    def test_a_full_disk_leaves_the_old_file_and_names_the_remedy(self):
        file = self.path / "a.xml"
        file.write_bytes(b"old")
        with mock.patch("os.fsync", side_effect=OSError(errno.ENOSPC, "No space left on device")):
            with self.assertRaisesRegex(atomic_files.WriteError, "disk is full.*a.xml.*free some space"):
                atomic_files.replace_file(file, b"new")
        self.assertEqual(b"old", file.read_bytes())
        self.assertEqual([file], list(self.path.iterdir()))

    def test_never_creates_over_a_file(self):
        file = self.path / "a.jpg"
        atomic_files.create_file(file, b"first")
        with self.assertRaises(FileExistsError):
            atomic_files.create_file(file, b"second")
        self.assertEqual(b"first", file.read_bytes())
        self.assertEqual([file], list(self.path.iterdir()))

    def test_creates_where_there_are_no_hard_links(self):
        file = self.path / "a.jpg"
        with mock.patch("os.link", side_effect=OSError(errno.EPERM, "Operation not permitted")):
            atomic_files.create_file(file, b"first")
            with self.assertRaises(FileExistsError):
                atomic_files.create_file(file, b"second")
        self.assertEqual(b"first", file.read_bytes())

    def test_a_missing_folder_is_named(self):
        with self.assertRaisesRegex(atomic_files.WriteError, "gone/a.xml"):
            atomic_files.replace_file(self.path / "gone" / "a.xml", b"")


class PascalVoc(unittest.TestCase):
    def test_file_of_the_renderer_comes_back_byte_by_byte(self):
        self.assertEqual(RENDERED, voc.to_xml(voc.parse(RENDERED, "a.xml")))

    def test_pixels_of_the_file_count_from_one_and_include_both_ends(self):
        box = voc.parse(RENDERED, "a.xml").boxes[0]
        self.assertEqual((0, 10, 30, 60), box.corners)
        self.assertEqual((True, False, 0.874), (box.truncated, box.difficult, box.visible))

    def test_unknown_elements_are_kept(self):
        text = RENDERED.replace(b"<pose>",
                                b"<part><name>tip</name></part><pose>").replace(b"<segmented>",
                                                                                b"<owner>x &amp; y</owner><segmented>")
        again = voc.parse(voc.to_xml(voc.parse(text, "a")), "b")
        self.assertEqual(voc.parse(text, "a"), again)
        self.assertIn("<owner>x &amp; y</owner>", again.extra)
        self.assertIn("<name>tip</name>", again.boxes[0].extra[0])

    def test_names_with_markup_survive(self):
        box = Box("R&D <cup>", 1, 2, 30, 40)
        data = voc.to_xml(voc.Annotation("a&b.jpg", 100, 100, (box,)))
        self.assertEqual((box,), voc.parse(data, "a").boxes)

    def test_errors_name_file_and_element(self):
        for text, expected in ((b"<annotation", "a.xml is no XML"), (b"<html/>", "<html>"),
                               (RENDERED.replace(b"<xmin>1<", b"<xmin>left<"), "bndbox/xmin.*'left'"),
                               (RENDERED.replace(b"<xmax>30<", b"<xmax>0<"), "cone.*inverted"),
                               (RENDERED.replace(b"<ymax>60</ymax>", b""), "bndbox/ymax"),
                               (RENDERED.replace(b"<xmin>1<", b"<xmin>inf<"), "finite"),
                               (RENDERED.replace(b"<name>cone</name>", b""), "no <name>")):
            with self.subTest(expected), self.assertRaisesRegex(voc.FormatError, expected):
                voc.parse(text, "a.xml")


class Folders(Temporary):
    def test_both_layouts_and_natural_order(self):
        for name in ("image10.png", "image9.png", "notes.txt", ".hidden.png"):
            (self.path / name).write_bytes(b"")
        self.assertEqual(["image9", "image10"], ImageFolder(self.path).names)
        self.images(2)
        self.assertEqual(["000001", "000002"], ImageFolder(self.path).names)

    def test_refuses_what_cannot_be_labelled(self):
        with self.assertRaisesRegex(FolderError, "no folder"):
            ImageFolder(self.path / "gone")
        with self.assertRaisesRegex(FolderError, "no images"):
            ImageFolder(self.path)
        for name in ("a.png", "a.jpg"):
            (self.path / name).write_bytes(b"")
        with self.assertRaisesRegex(FolderError, "rename one"):
            ImageFolder(self.path)

    def test_classes_are_read_and_appended(self):
        self.images(1)
        (self.path / "labels.txt").write_text("cone\n\ncube \ncone\n")
        folder = ImageFolder(self.path)
        folder.add_class("cup")
        folder.add_class("cube")
        self.assertEqual(["cone", "cube", "cup"], folder.classes)
        self.assertEqual("cone\ncube\ncup\n", (self.path / "labels.txt").read_text())
        with self.assertRaises(FolderError):
            folder.add_class("  ")

    def test_one_window_at_a_time(self):
        self.images(1)
        first, second = ImageFolder(self.path), ImageFolder(self.path)
        first.lock()
        with self.assertRaisesRegex(FolderError, "another extperfc-label"):
            second.lock()
        first.unlock()
        second.lock()
        second.unlock()

    def test_sizes_from_headers_and_by_decoding(self):
        image = numpy.zeros((7, 13, 3), numpy.uint8)
        for suffix in ("jpg", "png", "bmp"):
            file = self.path / f"a.{suffix}"
            cv2.imwrite(str(file), image)
            self.assertEqual((13, 7), image_size(file), suffix)
        data = (self.path / "a.jpg").read_bytes()
        profile = b"\xff\xe2" + struct.pack(">H", 60002) + bytes(60000)  # a colour profile before the size
        (self.path / "long.jpg").write_bytes(data[:2] + profile + data[2:])
        self.assertEqual((13, 7), image_size(self.path / "long.jpg"))
        (self.path / "bad.jpg").write_bytes(b"no image")
        with self.assertRaisesRegex(FolderError, "bad.jpg"):
            image_size(self.path / "bad.jpg")


class Coco(Temporary):
    BOXES = (Box("cone", 0, 10, 30, 60, truncated=True), Box("cube", 5, 5, 20, 25, difficult=True, occluded=True))

    def document(self):
        return Document(ImageFolder(self.path))

    def exported(self):
        self.images(3)
        document = self.document()
        document.change("000001", self.BOXES, "draw")
        document.change("000003", (), "empty")
        self.assertEqual((2, 2), coco.export_file(document, self.path / "out.json"))
        return json.loads((self.path / "out.json").read_text())

    def test_export_follows_the_format(self):
        content = self.exported()
        self.assertEqual(["000001.jpg", "000003.jpg"], [image["file_name"] for image in content["images"]])
        self.assertEqual([(160, 120)] * 2, [(image["width"], image["height"]) for image in content["images"]])
        self.assertEqual([(1, "cone"), (2, "cube")], [(one["id"], one["name"]) for one in content["categories"]])
        first = content["annotations"][0]
        self.assertEqual(([0, 10, 30, 50], 1500, 0, 1, 1),
                         (first["bbox"], first["area"], first["iscrowd"], first["image_id"], first["category_id"]))
        self.assertEqual(len({one["id"] for one in content["annotations"]}), 2)

    def test_import_gives_back_what_export_wrote(self):
        self.exported()
        for file in (self.path / "Annotations").iterdir():
            file.unlink()
        document = self.document()
        done = coco.import_file(document, self.path / "out.json")
        self.assertEqual((2, 2, 0, []), (done.images, done.boxes, done.replaced, done.skipped))
        self.assertEqual(self.BOXES, document.boxes("000001"))
        self.assertTrue(document.is_labelled("000003"))
        self.assertFalse(document.is_labelled("000002"))
        self.assertEqual(["cone", "cube"], document.folder.classes)
        self.assertEqual(self.BOXES, self.document().boxes("000001"), "on the disk")

    def test_import_keeps_labels_unless_asked(self):
        self.exported()
        document = self.document()
        other = (Box("cup", 1, 1, 9, 9),)
        document.change("000001", other, "draw")
        done = coco.import_file(document, self.path / "out.json")
        self.assertEqual((0, other), (done.images, document.boxes("000001")))
        self.assertIn("--replace", done.skipped[0][1])
        self.assertEqual(2, coco.import_file(document, self.path / "out.json", replace=True).replaced)
        self.assertEqual(self.BOXES, document.boxes("000001"))

    def test_import_reports_what_it_leaves_out(self):
        self.images(1)
        (self.path / "in.json").write_text(json.dumps({
            "images": [{"id": 7, "file_name": "some/where/000001.jpg"}, {"id": 8, "file_name": "other.jpg"}],
            "categories": [{"id": 3, "name": "cup"}],
            "annotations": [{"id": 1, "image_id": 7, "category_id": 3, "bbox": [10.4, 20.6, 30, 40]},
                            {"id": 2, "image_id": 7, "category_id": 3, "bbox": [500, 20, 30, 40]},
                            {"id": 3, "image_id": 7, "category_id": 3, "bbox": [1, 1, 9, 9], "iscrowd": 1},
                            {"id": 4, "image_id": 8, "category_id": 3, "bbox": [1, 1, 9, 9]}]}))
        document = self.document()
        done = coco.import_file(document, self.path / "in.json")
        self.assertEqual((Box("cup", 10, 21, 40, 61),), document.boxes("000001"))
        self.assertEqual(["other.jpg", "annotation 2", "annotation 3"], [what for what, _ in done.skipped])

    def test_bad_files_are_named(self):
        self.images(1)
        for text, expected in (("{", "no JSON"), ("[]", "no list images"),
                               ('{"images": [{}], "annotations": [], "categories": []}',
                                "KeyError"), ('{"images": [], "annotations": []}', "categories")):
            (self.path / "in.json").write_text(text)
            with self.subTest(expected), self.assertRaisesRegex(coco.CocoError, f"in.json.*{expected}"):
                coco.import_file(self.document(), self.path / "in.json")


class WrittenXml(Temporary):
    def test_a_document_writes_what_other_readers_expect(self):
        self.images(1)
        Document(ImageFolder(self.path)).change("000001", (Box("cone", 3, 4, 10, 20),), "draw")
        root = xml.etree.ElementTree.parse(self.path / "Annotations" / "000001.xml").getroot()
        self.assertEqual("000001.jpg", root.findtext("filename"))
        self.assertEqual(["160", "120", "3"], [root.findtext(f"size/{key}") for key in ("width", "height", "depth")])
        self.assertEqual(["4", "5", "10", "20"],
                         [root.findtext(f"object/bndbox/{key}") for key in ("xmin", "ymin", "xmax", "ymax")])


if __name__ == "__main__":
    unittest.main()

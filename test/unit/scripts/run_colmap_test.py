#!/usr/bin/python3
"""Checks what scripts/run_colmap tells COLMAP, and that it goes on where it was stopped: with a program in COLMAP's
place that writes down its arguments."""

import contextlib
import importlib.machinery
import importlib.util
import io
import json
import os
import stat
import tempfile
import unittest

import cv2
import numpy as np
import rosbag
import rospy
from sensor_msgs.msg import Image

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..")

CAMERA = """%YAML:1.0
model_type: PINHOLE
image_topic: "/cam0/image_raw"
image_width: 32
image_height: 24
distortion_parameters: {k1: -0.25, k2: 0.0625, p1: 0.001, p2: 0.002}
projection_parameters: {fx: 25.0, fy: 26.0, cx: 15.0, cy: 12.0}
"""

FISHEYE = """%YAML:1.0
model_type: KANNALA_BRANDT
image_width: 32
image_height: 24
projection_parameters: {k2: 0.5, k3: 0.25, k4: 0.125, k5: 1.0, mu: 25.0, mv: 26.0, u0: 15.0, v0: 12.0}
"""

# Fails while the file "broken_<command>" is beside it; its mapper writes two models, the larger one second.
FAKE = """#!/usr/bin/python3
import json, os, struct, sys
here = os.path.dirname(os.path.abspath(sys.argv[0]))
command = sys.argv[1]
options = dict(zip(sys.argv[2::2], sys.argv[3::2]))
with open(os.path.join(here, "calls"), "a") as file:
    file.write(json.dumps([command, options]) + "\\n")
def model(folder, count):
    os.makedirs(folder, exist_ok=True)
    with open(os.path.join(folder, "images.bin"), "wb") as file:
        file.write(struct.pack("<Q", count))
if command == "mapper":
    model(os.path.join(options["--Mapper.snapshot_path"], "111"), 2)
if os.path.exists(os.path.join(here, "broken_" + command)):
    print("no luck today")
    sys.exit(7)
if command == "mapper" and "--input_path" in options:
    model(options["--output_path"], 4)
elif command == "mapper":
    model(os.path.join(options["--output_path"], "0"), 2)
    model(os.path.join(options["--output_path"], "1"), 3)
"""


def load_script(path):
    loader = importlib.machinery.SourceFileLoader("run_colmap", path)
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("run_colmap", loader))
    loader.exec_module(module)
    return module


script = load_script(os.path.join(ROOT, "scripts", "run_colmap"))


class RunColmapTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.write("camera.yaml", CAMERA)
        self.write("colmap", FAKE)
        os.chmod(self.path("colmap"), stat.S_IRWXU)
        os.mkdir(self.path("images"))
        for i in range(5):
            cv2.imwrite(self.path("images", f"{1000 + i}.png"), np.full((24, 32), i, np.uint8))

    def path(self, *parts):
        return os.path.join(self.folder.name, *parts)

    def write(self, name, text):
        with open(self.path(name), "w", encoding="utf-8") as file:
            file.write(text)

    def run_script(self, *arguments):
        """Exit code and what it said."""
        said = io.StringIO()
        command = ["--camera", self.path("camera.yaml"), "--out", self.path("out"), "--colmap", self.path("colmap")]
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            code = script.main([*command, *arguments])
        return code, said.getvalue()

    def run_images(self, *arguments):
        return self.run_script("--images", self.path("images"), *arguments)

    def calls(self):
        with open(self.path("calls"), encoding="utf-8") as file:
            return [json.loads(line) for line in file]

    def test_tells_colmap_the_calibration(self):
        code, said = self.run_images("--every", "2", "--json", self.path("counts.json"))
        self.assertEqual(code, 0, said)
        commands = self.calls()
        self.assertEqual([c[0] for c in commands], ["feature_extractor", "sequential_matcher", "mapper"])
        features = commands[0][1]
        self.assertEqual(features["--ImageReader.camera_model"], "OPENCV")
        # COLMAP's pixels begin half a pixel earlier.
        self.assertEqual(features["--ImageReader.camera_params"], "25,26,15.5,12.5,-0.25,0.0625,0.001,0.002")
        self.assertEqual(features["--SiftExtraction.use_gpu"], "0")
        self.assertEqual(commands[2][1]["--Mapper.ba_refine_focal_length"], "0")
        with open(features["--image_list_path"], encoding="utf-8") as file:
            self.assertEqual(file.read().split(), ["1000.png", "1002.png", "1004.png"])
        # As in the model: nothing that would have to be told apart later.
        self.assertEqual(sorted(os.listdir(features["--image_path"])), ["1000.png", "1002.png", "1004.png"])
        self.assertEqual(cv2.imread(self.path("out", "images", "1002.png"), 0)[0, 0], 2)
        with open(self.path("counts.json"), encoding="utf-8") as file:
            self.assertEqual(json.load(file)["registered"], 3)

    def test_takes_eurocs_folder(self):
        os.makedirs(self.path("asl", "mav0", "cam0"))
        os.rename(self.path("images"), self.path("asl", "mav0", "cam0", "data"))
        code, said = self.run_script("--images", self.path("asl"))
        self.assertEqual(code, 0, said)
        self.assertEqual(len(os.listdir(self.path("out", "images"))), 5)

    def test_keeps_the_largest_model_first(self):
        code, said = self.run_images()
        self.assertEqual(code, 0, said)
        self.assertIn("3 of 5 images", said)
        self.assertEqual(script.count_images(self.path("out", "sparse", "0")), 3)
        self.assertEqual(script.count_images(self.path("out", "sparse", "1")), 2)
        self.assertFalse(os.path.exists(self.path("out", "sparse.partial")))

    def test_goes_on_where_it_was_stopped(self):
        self.write("broken_sequential_matcher", "")
        code, said = self.run_images()
        self.assertEqual(code, 1)
        self.assertIn("sequential_matcher failed with 7", said)
        self.assertIn("no luck today", said)
        os.remove(self.path("broken_sequential_matcher"))
        self.write("broken_mapper", "")
        self.assertEqual(self.run_images()[0], 1)
        os.remove(self.path("broken_mapper"))
        code, said = self.run_images()
        self.assertEqual(code, 0, said)
        commands = self.calls()
        self.assertEqual(
            [c[0] for c in commands],
            ["feature_extractor", "sequential_matcher", "sequential_matcher", "mapper", "mapper"],
        )
        self.assertTrue(commands[-1][1]["--input_path"].endswith("snapshots/111"))
        self.assertEqual(script.count_images(self.path("out", "sparse", "0")), 4)
        # All is done: nothing is called again.
        self.assertEqual(self.run_images()[0], 0)
        self.assertEqual(len(self.calls()), len(commands))

    def test_other_arguments_are_refused(self):
        self.assertEqual(self.run_images()[0], 0)
        code, said = self.run_images("--overlap", "5")
        self.assertEqual(code, 1)
        self.assertIn("another overlap", said)

    def test_knows_the_fisheye(self):
        self.write("camera.yaml", FISHEYE)
        self.assertEqual(self.run_images()[0], 0)
        features = self.calls()[0][1]
        self.assertEqual(features["--ImageReader.camera_model"], "OPENCV_FISHEYE")
        self.assertEqual(features["--ImageReader.camera_params"], "25,26,15.5,12.5,0.5,0.25,0.125,1")

    def test_takes_images_from_a_bag(self):
        with rosbag.Bag(self.path("a.bag"), "w") as bag:
            for i in range(4):
                message = Image(height=24, width=32, encoding="mono8", step=32, data=bytes([i]) * (24 * 32))
                message.header.stamp = rospy.Time(100, i)
                bag.write("/cam0/image_raw", message, message.header.stamp)
        code, said = self.run_script("--bag", self.path("a.bag"), "--every", "3")
        self.assertEqual(code, 0, said)
        images = sorted(os.listdir(self.path("out", "images")))
        self.assertEqual(images, ["100000000000.png", "100000000003.png"])
        self.assertEqual(cv2.imread(self.path("out", "images", images[1]), 0)[0, 0], 3)
        code, said = self.run_script("--bag", self.path("a.bag"), "--topic", "/none", "--out", self.path("b"))
        self.assertEqual(code, 1)
        self.assertIn("/cam0/image_raw", said)

    def test_names_what_is_wrong(self):
        for text, expected in (
            ("%YAML:1.0\nmodel_type: MEI\n", "MEI"),
            ("%YAML:1.0\nmodel_type: PINHOLE\n", "projection_parameters.fx"),
            (CAMERA.replace("32", "33"), "32 x 24"),
        ):
            self.write("camera.yaml", text)
            code, said = self.run_images()
            self.assertEqual(code, 1)
            self.assertIn(expected, said)
        self.write("camera.yaml", CAMERA)
        code, said = self.run_script("--images", self.path("none"))
        self.assertIn("no such folder", said)
        # What was refused has not begun anything.
        self.assertEqual(self.run_images()[0], 0)
        code, said = self.run_images("--colmap", "no-such-program")
        self.assertEqual(code, 1)
        self.assertIn("'no-such-program' is not installed", said)


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/python3
"""views_images_test.py TOOL FLIGHT PRESET: `deja_view views` of a folder of images gives what it gives of a bag of the
same images. FLIGHT is the directory of a simulated flight with images and models/room.dvn."""

import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import cv2
import numpy as np
import rosbag

TOOL, FLIGHT, PRESET = sys.argv[1:4]
IMAGE, FRAME, POSES = "/cam0/image_raw", "/virtual_cam0/frame", "/odometry"
CAMERA = ["--camera", os.path.join(FLIGHT, "camera.yaml")]
TRUTH = os.path.join(FLIGHT, "groundtruth.txt")


def sources(poses=TRUTH, align_to="off", model="room"):
    return [*CAMERA, "--poses", poses, "--align-to", align_to, "--model",
            os.path.join(FLIGHT, "models", model + ".dvn"), "--preset", PRESET]


SOURCES = sources()
RENDER = ["render", *SOURCES, "--quiet"]


def stamp(path):
    return int(os.path.splitext(os.path.basename(path))[0])


class ViewsImagesTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.images = sorted(os.path.join(FLIGHT, "images", name) for name in os.listdir(os.path.join(FLIGHT, "images")))

    def path(self, *names):
        path = os.path.join(self.folder, *names)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        return path

    def asl(self, count=40):
        """The first images in EuRoC's layout."""
        for image in self.images[:count]:
            shutil.copy(image, self.path("asl", "mav0", "cam0", "data", os.path.basename(image)))
        return self.path("asl")

    def views(self, *arguments, code=0):
        result = subprocess.run([TOOL, "views", *arguments], capture_output=True, text=True, check=False)
        self.assertEqual(result.returncode, code, result.stderr)
        return result.stderr

    def frames(self, path):
        with rosbag.Bag(path) as bag:
            return [raw[1] for _, raw, _ in bag.read_messages([FRAME], raw=True)]

    def test_equals_a_bag_of_the_same_images(self):
        folder, bag = self.path("folder.bag"), self.path("bag.bag")
        self.views(*RENDER, "--images", os.path.join(FLIGHT, "images"), "--out", folder)
        self.views(*RENDER, "--bag", os.path.join(FLIGHT, "flight.bag"), "--sources", "images", "--out", bag)
        self.assertGreater(len(self.frames(folder)), 4)
        self.assertEqual(self.frames(folder), self.frames(bag))
        with rosbag.Bag(folder) as out:
            images = [(time.to_nsec(), message) for _, message, time in out.read_messages([IMAGE])]
            poses = [(time.to_nsec(), message) for _, message, time in out.read_messages([POSES])]
            times = [time.to_nsec() for _, _, time in out.read_messages()]
        self.assertEqual(times, sorted(times))
        self.assertEqual([time for time, _ in images], [stamp(path) for path in self.images])
        for (time_ns, message), path in zip(images, self.images):
            self.assertEqual(message.header.stamp.to_nsec(), time_ns)
            pixels = np.frombuffer(message.data, np.uint8).reshape(message.height, message.width)
            self.assertTrue(np.array_equal(pixels, cv2.imread(path, cv2.IMREAD_UNCHANGED)))
        truth = np.loadtxt(TRUTH)
        for time_ns, message in poses:
            self.assertEqual(message.header.stamp.to_nsec(), time_ns)
            p = message.pose.pose.position
            nearest = truth[np.argmin(np.abs(truth[:, 0] - time_ns * 1e-9)), 1:4]
            self.assertLess(np.linalg.norm(nearest - [p.x, p.y, p.z]), 0.02)
        # The new bag is a source of its own.
        self.views("check", *SOURCES, "--bag", bag, "--count", "2", "--ways", "bicubic", "--quiet")

    def test_shares_and_a_kill_give_the_same_file(self):
        whole = self.path("whole.bag")
        asl = self.asl()
        self.views(*RENDER, "--images", asl, "--out", whole)
        parts = [self.path("part%d.bag" % i) for i in range(2)]
        for i, part in enumerate(parts):
            command = [*RENDER, "--images", asl, "--shard", "%d/2" % i, "--threads", "1", "--out", part]
            run = subprocess.Popen([TOOL, "views", *command], stdout=subprocess.DEVNULL)
            while run.poll() is None and not os.path.isdir(part + ".work"):
                time.sleep(0.01)
            run.send_signal(signal.SIGKILL)
            run.wait()
            self.views(*command)
        merged = self.path("merged.bag")
        self.views("merge", "--images", asl, *CAMERA, *reversed(parts), "--out", merged)
        with open(whole, "rb") as one, open(merged, "rb") as other:
            self.assertEqual(one.read(), other.read())

    def test_checks_matches_and_places(self):
        asl = self.asl()
        self.views("check", *SOURCES, "--images", asl, "--count", "2", "--ways", "bicubic", "--quiet")
        with open(self.path("places.txt"), "w", encoding="utf-8") as file:
            file.write("%d.%09d 0 0 0 0 0 0 1\n" % divmod(stamp(self.images[7]), 10**9))
        out = self.path("places.bag")
        self.views(*RENDER, "--images", asl, "--places", self.path("places.txt"), "--plain-topics", "--out", out)
        with rosbag.Bag(out) as bag:
            stamps = {message.header.stamp.to_nsec() for _, message, _ in bag.read_messages([FRAME])}
            self.assertGreater(bag.get_message_count("/virtual_cam0/image_raw"), 0)
        self.assertEqual(stamps, {stamp(self.images[7])})

    def test_fields_of_colmap_need_a_place(self):
        asl, out = self.asl(), self.path("out.bag")

        def frames(*arguments):
            self.views("render", *sources(*arguments), "--images", asl, "--depth", "--quiet", "--out", out)
            with rosbag.Bag(out) as bag:
                return [message for _, message, _ in bag.read_messages([FRAME])]

        error = self.views("render", *sources(model="colmap"), "--images", asl, "--out", out, code=1)
        self.assertIn("colmap.dvn", error)
        self.assertIn("nerf align", error)
        # By their own poses, aligned with the truth, and once for all: the same views, in metres.
        by_poses = frames(os.path.join(FLIGHT, "colmap"), TRUTH, "colmap")
        by_place = frames(TRUTH, "off", "aligned")
        self.assertGreater(len(by_place), 4)
        self.assertEqual(len(by_poses), len(by_place))
        for one, other in zip(by_poses, by_place):
            self.assertEqual(one.header.stamp, other.header.stamp)
            positions = [np.array([m.T_C_V.position.x, m.T_C_V.position.y, m.T_C_V.position.z]) for m in (one, other)]
            self.assertLess(np.linalg.norm(positions[0] - positions[1]), 1e-9)
            self.assertTrue(0.05 <= np.linalg.norm(positions[0]) <= 0.1)
            depths = [cv2.imdecode(np.frombuffer(bytes(m.depth_png), np.uint8), cv2.IMREAD_UNCHANGED) / 1e3
                      for m in (one, other)]
            self.assertLess(np.median(np.abs(depths[0] - depths[1])), 0.01)
            self.assertTrue(0.3 < np.median(depths[0]) < 20)

    def test_names_what_is_wrong(self):
        out = self.path("out.bag")

        def error(*arguments):
            text = self.views(*RENDER, "--out", out, *arguments, code=1)
            self.assertFalse(os.path.exists(out))
            return text

        asl = self.asl(20)
        data = os.path.join(asl, "mav0", "cam0", "data")
        self.assertIn("either --bag or --images, found none", error())
        self.assertIn("no keyframes", error("--images", asl, "--sources", "keyframes"))
        self.assertIn("VIO's points", error("--images", asl, "--renderer", "warp"))
        no_topic = ["render", *sources(poses="/odometry"), "--images", asl, "--out", out]
        self.assertIn("no such file or topic", self.views(*no_topic, code=1))
        shutil.copy(os.path.join(FLIGHT, "flight.bag"), self.path("part.bag"))
        self.assertIn("needs --camera", self.views("merge", "--images", asl, self.path("part.bag"), "--out", out, code=1))
        for name, image, expected in (("frame7.png", np.zeros((480, 752), np.uint8), "as the image's name"),
                                      ("99.png", np.zeros((48, 64), np.uint8), "64 x 48 px"),
                                      ("98.png", None, "can't be read as an image")):
            path = os.path.join(data, name)
            if image is None:
                with open(path, "w", encoding="utf-8") as file:
                    file.write("no picture")
            else:
                cv2.imwrite(path, image)
            text = error("--images", asl)
            self.assertIn(path, text)
            self.assertIn(expected, text)
            os.remove(path)
        empty = self.path("empty", "")
        self.assertIn("holds no image", error("--images", empty))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])

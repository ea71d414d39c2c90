#!/usr/bin/python3
"""replay_test.py TOOL FLIGHT: what `deja_view replay` does with the simulated flight in the directory FLIGHT, and with
bags and cameras that don't go together."""

import json
import math
import os
import subprocess
import sys
import tempfile
import unittest

import rosbag

TOOL, FLIGHT = sys.argv[1:3]
BAG, CAMERA = os.path.join(FLIGHT, "flight.bag"), os.path.join(FLIGHT, "camera.yaml")
POSES = "/vins_estimator/odometry"
ODOMETRY = ["--host", "odometry", "--odometry-topic", POSES]


class ReplayTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def replay(self, bag=BAG, camera=CAMERA, *arguments):
        command = [TOOL, "replay", "--bag", bag, "--camera", camera, "--quiet", *arguments]
        return subprocess.run(command, capture_output=True, text=True, check=False)

    def spoilt_camera(self, before, after):
        path = os.path.join(self.folder, "camera.yaml")
        with open(CAMERA, encoding="utf-8") as file, open(path, "w", encoding="utf-8") as out:
            text = file.read()
            self.assertIn(before, text)
            out.write(text.replace(before, after))
        return path

    def figures(self, bag, *arguments):
        file = os.path.join(self.folder, "figures.json")
        truth = os.path.join(FLIGHT, "groundtruth.txt")
        result = self.replay(bag, CAMERA, "--groundtruth", truth, "--json", file, *arguments)
        self.assertEqual(result.returncode, 0, result.stderr)
        with open(file, encoding="utf-8") as lines:
            return json.load(lines), result

    def edited(self, edit):
        """A copy of the bag; edit(topic, message, seconds since its beginning) returns the message, or none."""
        path = os.path.join(self.folder, "edited.bag")
        with rosbag.Bag(BAG) as bag, rosbag.Bag(path, "w") as out:
            begin = bag.get_start_time()
            for topic, message, time in bag.read_messages():
                message = edit(topic, message, message.header.stamp.to_sec() - begin)
                if message is not None:
                    out.write(topic, message, time)
        return path

    def test_a_restart_in_flight_is_joined_by_the_next_loops(self):
        """The VIO is silent for 1.4 s and begins anew, 3 m and 100 degrees off, with tracks of its own."""
        pause_s, c, s = (9.0, 10.4), math.cos(1.75), math.sin(1.75)

        def moved(point):
            point.x, point.y, point.z = c * point.x - s * point.y + 2.5, s * point.x + c * point.y - 1.6, point.z + 0.4

        def restart(topic, message, time_s):
            if not topic.startswith("/vins_estimator/") or time_s < pause_s[0] or topic.endswith("extrinsic"):
                return message
            if time_s < pause_s[1]:
                return None
            if topic.endswith("keyframe_point"):
                for point, channel in zip(message.points, message.channels):
                    moved(point)
                    channel.values = [*channel.values[:4], channel.values[4] + 100000]
            else:
                pose = message.pose.pose
                moved(pose.position)
                q, (w, z) = pose.orientation, (math.cos(0.875), math.sin(0.875))
                q.x, q.y, q.z, q.w = w * q.x - z * q.y, w * q.y + z * q.x, w * q.z + z * q.w, w * q.w - z * q.z
            return message

        out = os.path.join(self.folder, "out")
        plain, _ = self.figures(BAG)
        figures, result = self.figures(self.edited(restart), "--out", out)
        self.assertGreater(figures["vio_ape_mean_m"], 1.0)  # the odometry alone is lost
        self.assertEqual(figures["precision"], 1.0)
        self.assertLess(figures["ape_mean_m"], 1.5 * plain["ape_mean_m"])
        self.assertEqual(figures["restarts"], 1)
        self.assertIn("the VIO started anew", result.stderr)

    def test_images_of_another_size_are_told_in_a_line(self):
        camera = self.spoilt_camera("image_width: ", "image_width: 1")
        for host in ([], ODOMETRY):
            result = self.replay(BAG, camera, "--out", os.path.join(self.folder, "out"), *host)
            self.assertEqual(result.returncode, 1)
            self.assertEqual(result.stdout, "")
            self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
            self.assertIn("flight.bag: no keyframe could be used", result.stderr)
            self.assertIn("expected", result.stderr)
        self.assertFalse(os.path.exists(os.path.join(self.folder, "out", "loops.csv")))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])

#!/usr/bin/python3
"""check_test.py TOOL FLIGHT: what `deja_view check` says of the simulated flight in the directory FLIGHT, and of what is
wrong with spoilt copies of it."""

import json
import os
import subprocess
import sys
import tempfile
import unittest

import rosbag
import rospy

TOOL, FLIGHT = sys.argv[1:3]
BAG, CAMERA = os.path.join(FLIGHT, "flight.bag"), os.path.join(FLIGHT, "camera.yaml")
ODOMETRY, POINTS = "/vins_estimator/odometry", "/vins_estimator/keyframe_point"


class CheckTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def check(self, bag, camera=CAMERA):
        file_name = os.path.join(self.folder, "check.json")
        command = [TOOL, "check", "--bag", bag, "--camera", camera, "--json", file_name]
        result = subprocess.run(command, capture_output=True, text=True, check=False)
        with open(file_name, encoding="utf-8") as file:
            figures = json.load(file)
        self.assertEqual(result.returncode, 3 if figures["problems"] else 0, result.stderr)
        return figures

    def spoilt(self, edit):
        """A copy of the bag's first messages; edit(number, topic, message) returns false for what is left out."""
        path = os.path.join(self.folder, "spoilt.bag")
        with rosbag.Bag(BAG) as bag, rosbag.Bag(path, "w") as out:
            for number, (topic, message, time) in enumerate(bag.read_messages()):
                if edit(number, topic, message):
                    out.write(topic, message, time)
        return path

    def spoilt_camera(self, before, after):
        path = os.path.join(self.folder, "camera.yaml")
        with open(CAMERA, encoding="utf-8") as file, open(path, "w", encoding="utf-8") as out:
            text = file.read()
            self.assertIn(before, text)
            out.write(text.replace(before, after))
        return path

    def test_a_good_flight_is_good_for_two_hosts(self):
        figures = self.check(BAG)
        self.assertEqual(figures["problems"], [])
        commands = {host["host"]: host["command"] for host in figures["hosts"]}
        self.assertEqual(sorted(commands), ["odometry", "vins_mono"])
        self.assertIn("--odometry-topic " + ODOMETRY, commands["odometry"])
        images = next(t for t in figures["topics"] if t["name"] == "/cam0/image_raw")
        self.assertGreater(images["rate_hz"], 5)
        command = commands["vins_mono"].split()
        self.assertEqual(subprocess.run([TOOL, *command[1:], "--quiet"], capture_output=True, check=False).returncode, 0)

    def test_another_cameras_file_is_told(self):
        problems = " ".join(self.check(BAG, self.spoilt_camera("image_width: ", "image_width: 1"))["problems"])
        self.assertIn("expected the camera's 1", problems)
        problems = " ".join(self.check(BAG, self.spoilt_camera("fx: ", "fx: 1"))["problems"])
        self.assertIn("miss their pixels", problems)

    def test_what_is_missing_and_what_goes_back_is_told(self):
        def edit(number, topic, message):
            if topic == ODOMETRY and number > 500:
                message.header.stamp -= rospy.Duration(5.0)
            return topic != POINTS

        figures = self.check(self.spoilt(edit))
        self.assertEqual({host["host"] for host in figures["hosts"]}, {"odometry"})
        self.assertIn(ODOMETRY, " ".join(p for p in figures["problems"] if "go back" in p))

    def test_a_world_on_its_side_is_told(self):
        def edit(_, topic, message):
            """Turns the world by 90 degrees about x."""
            if topic == ODOMETRY:
                p, q = message.pose.pose.position, message.pose.pose.orientation
                p.y, p.z = -p.z, p.y
                s = 0.5**0.5
                q.w, q.x, q.y, q.z = s * (q.w - q.x), s * (q.x + q.w), s * (q.y - q.z), s * (q.z + q.y)
            return topic in (ODOMETRY, "/cam0/image_raw")

        figures = self.check(self.spoilt(edit))
        self.assertEqual(figures["hosts"], [])
        self.assertIn("tilted by 9", " ".join(figures["problems"]).replace("8", "9"))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])

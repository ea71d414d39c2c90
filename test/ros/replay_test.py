#!/usr/bin/python3
"""replay_test.py TOOL FLIGHT VIEWS: what `deja_view replay` does with the simulated flight in the directory FLIGHT, with
the views of the one in VIEWS, and with bags and cameras that don't go together."""

import json
import math
import os
import subprocess
import sys
import tempfile
import unittest

import rosbag
from geometry_msgs.msg import TransformStamped
from tf2_msgs.msg import TFMessage

TOOL, FLIGHT, VIEWS = sys.argv[1:4]
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

    def edited(self, edit, source=BAG):
        """A copy of the bag; edit(topic, message, seconds since its beginning) returns the message, none, or a topic and
        its message."""
        path = os.path.join(self.folder, "edited.bag")
        with rosbag.Bag(source) as bag, rosbag.Bag(path, "w") as out:
            begin = bag.get_start_time()
            for topic, message, time in bag.read_messages():
                message = edit(topic, message, message.header.stamp.to_sec() - begin)
                if isinstance(message, tuple):
                    topic, message = message
                if message is not None:
                    out.write(topic, message, time)
        return path

    def test_refused_views_take_one_line_when_quiet(self):
        spoilt = []

        def spoil(topic, message, _):
            if topic == "/virtual_cam0/frame":
                spoilt.append(topic)
                if len(spoilt) % 2:
                    message.depth = message.depth[:-1]
                else:
                    message.camera_model = "NONE\nWHATEVER"
            return message

        figures, result = self.figures(self.edited(spoil, os.path.join(VIEWS, "flight.bag")))
        self.assertGreater(len(spoilt), 50)
        self.assertEqual(figures["problems"], len(spoilt))
        lines = result.stderr.splitlines()
        self.assertEqual(len(lines), 1, result.stderr)
        self.assertRegex(lines[0], r"^warning: .*/virtual_cam0/frame.* \(and \d+ more")
        self.assertLess(len(lines[0]), 400)

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

    def test_a_part_of_a_flight_is_what_it_says(self):
        def stamps(*arguments):
            out = os.path.join(self.folder, "run")
            self.figures(BAG, "--out", out, *arguments)
            with open(os.path.join(out, "vio.txt"), encoding="utf-8") as file:
                return [float(line.split()[0]) for line in file if not line.startswith("#")]

        whole = stamps()
        seconds = [stamp - whole[0] for stamp in whole]
        first, second = stamps("--duration", "8"), stamps("--start", "8")
        self.assertEqual(first, [stamp for stamp, s in zip(whole, seconds) if s < 8])
        self.assertEqual(second, [stamp for stamp, s in zip(whole, seconds) if s >= 8])
        self.assertEqual(len(first) + len(second), len(whole))
        self.assertEqual(stamps("--start", "3", "--duration", "5"), [t for t, s in zip(whole, seconds) if 3 <= s < 8])
        late = self.replay(BAG, CAMERA, "--start", "10000")
        self.assertEqual(late.returncode, 1)
        self.assertIn("no keyframe could be used", late.stderr)

    def test_poses_of_tf_are_as_good_as_a_topic(self):
        def transforms(parent, child, message):
            link = TransformStamped(header=message.header, child_frame_id=child)
            link.header.frame_id = parent
            pose = message.pose.pose
            for axis in "xyz":
                setattr(link.transform.translation, axis, getattr(pose.position, axis))
            link.transform.rotation = pose.orientation
            return TFMessage([link])

        def as_tf(topic, message, _):
            if topic == "/vins_estimator/extrinsic":
                message.pose.pose.position.x, message.pose.pose.orientation.w = 0.0, 1.0
                for axis in "xyz":
                    setattr(message.pose.pose.position, axis, 0.0)
                    setattr(message.pose.pose.orientation, axis, 0.0)
                return "/tf_static", transforms("base", "imu", message)
            return ("/tf", transforms("odom", "base", message)) if topic == POSES else message

        bag = self.edited(as_tf)
        expected, _ = self.figures(BAG, *ODOMETRY)
        found, _ = self.figures(bag, "--host", "odometry", "--odometry-topic", "tf:odom,imu")
        for figure in ("keyframes", "loops_accepted", "recall", "precision", "ape_mean_m"):
            self.assertEqual(found[figure], expected[figure], figure)
        self.assertGreater(found["recall"], 0.8)
        result = self.replay(bag, CAMERA, "--host", "odometry", "--odometry-topic", "tf:world,imu")
        self.assertEqual(result.returncode, 1)
        self.assertIn("no transform from world to imu; there are base -> imu, odom -> base", result.stderr)

    def test_a_world_on_its_side_is_refused_unless_it_is_to_be_levelled(self):
        def tilt(topic, message, _):
            if topic == POSES:
                position, q, half = message.pose.pose.position, message.pose.pose.orientation, math.sqrt(0.5)
                position.y, position.z = -position.z, position.y
                q.x, q.y, q.z, q.w = half * (q.w + q.x), half * (q.y - q.z), half * (q.z + q.y), half * (q.w - q.x)
            return message

        bag = self.edited(tilt)
        result = self.replay(bag, CAMERA, *ODOMETRY)
        self.assertEqual(result.returncode, 1)
        self.assertIn("the odometry's world is tilted by", result.stderr)
        self.assertIn("gravity: estimate", result.stderr)
        expected, _ = self.figures(BAG, *ODOMETRY)
        found, _ = self.figures(bag, *ODOMETRY, "--gravity", "estimate")
        self.assertEqual(found["precision"], 1.0)
        self.assertGreater(found["recall"], 0.9 * expected["recall"])
        self.assertLess(found["ape_mean_m"], 1.5 * expected["ape_mean_m"])
        self.assertEqual(self.replay(BAG, CAMERA, "--gravity", "estimate").returncode, 1)

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

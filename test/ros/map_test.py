#!/usr/bin/python3
"""map_test.py TOOL FLIGHT SECOND: what `deja_view map` makes of the simulated flight in the directory FLIGHT, what of it
is made again, and what another flight of the same hall, in SECOND, adds to it."""

import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import rosbag
from colmap_model import write_model

TOOL, FLIGHT, SECOND = sys.argv[1:4]
BAG, CAMERA = os.path.join(FLIGHT, "flight.bag"), os.path.join(FLIGHT, "camera.yaml")
STAGES = ["bundle", "field", "field_quality", "loops", "views", "map", "gain"]


class MapTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.out, self.bag = os.path.join(folder.name, "place"), BAG

    def command(self, *arguments):
        return [TOOL, "map", "--bag", self.bag, "--camera", CAMERA, "--out", self.out, *arguments]

    def map(self, *arguments, code=0):
        result = subprocess.run(self.command("--steps", "60", *arguments), capture_output=True, text=True, check=False)
        self.assertEqual(result.returncode, code, result.stderr)
        return result

    def stages(self, stderr, what):
        lines = stderr.replace("\r", "\n").splitlines()
        return [stage for stage in STAGES if f"{stage}: {what}" in lines]

    def test_makes_a_map_and_only_what_changed_again(self):
        first = self.map()
        figures = json.loads(first.stdout)
        self.assertEqual(self.stages(first.stderr, "begins"), STAGES)
        for name in ("map.dvm", "field.dvn", "views.bag", "bundle/poses.txt", "map.json", "map.html"):
            self.assertTrue(os.path.exists(os.path.join(self.out, name)), name)
        self.assertGreater(figures["map"]["places"], 0)
        self.check_gain(figures)
        self.check_page(figures)
        self.assertEqual(figures["field"]["steps"], 61)
        self.assertEqual(self.stages(self.map().stderr, "as it was"), STAGES)

        with open(os.path.join(self.out, "views.bag"), "rb") as file:
            views = file.read()
        other = self.map("--preset", "paper")
        self.assertEqual(self.stages(other.stderr, "as it was"), STAGES[:4])
        self.assertEqual(self.stages(other.stderr, "begins"), STAGES[4:])
        with open(os.path.join(self.out, "views.bag"), "rb") as file:
            self.assertNotEqual(file.read(), views)

        self.assertRegex(self.map("--preset", "none.yaml", code=1).stderr, "views: .*none.yaml")
        self.map("--preset", "paper")

        os.remove(os.path.join(self.out, "map.dvm"))
        self.assertEqual(self.stages(self.map("--preset", "paper").stderr, "begins"), STAGES[5:])

        os.remove(os.path.join(self.out, "field.dvn"))
        self.assertEqual(self.stages(self.map("--preset", "paper").stderr, "begins"), STAGES[1:])

    def check_gain(self, figures):
        """The second half of the flight on a map of the first: no part of either is in both."""
        gain, whole = figures["gain"], figures["loops"]
        self.assertGreater(gain["places"], 0)
        self.assertLess(gain["places"], whole["places"])
        self.assertAlmostEqual(gain["keyframes"], whole["keyframes"] / 2, delta=0.1 * whole["keyframes"])
        self.assertLessEqual(gain["found_without_views"], gain["keyframes"])

    def test_writes_the_flight_with_its_views(self):
        bag = os.path.join(os.path.dirname(self.out), "flight_views.bag")
        figures = json.loads(self.map("--bag-out", bag).stdout)
        with rosbag.Bag(bag) as written, rosbag.Bag(BAG) as flight:
            views = [message for _, message, _ in written.read_messages("/virtual_cam0/frame")]
            self.assertEqual(written.get_message_count("/cam0/image_raw"), flight.get_message_count("/cam0/image_raw"))
        self.assertEqual(len(views), figures["views"]["views"])
        self.assertTrue(all(view.image and view.u for view in views))

    def check_page(self, figures):
        """A field of 60 steps is a bad one, and is told to be."""
        self.assertLess(figures["field_quality"]["psnr_db"], 20)
        advice = [line for line in figures["advice"] if "--budget-s" in line]
        self.assertEqual(len(advice), 1)
        with open(os.path.join(self.out, "map.html"), encoding="utf-8") as file:
            page = file.read()
        self.assertIn(advice[0], page)
        pictures = re.findall(r'<img src="([^"]*)"', page)
        self.assertEqual(len(pictures), 8)
        for picture in pictures:
            self.assertTrue(os.path.exists(os.path.join(self.out, picture)), picture)

    def test_maps_the_flight_of_an_odometry(self):
        file_name = os.path.join(os.path.dirname(self.out), "figures.json")
        self.map("--host", "odometry", "--odometry-topic", "/vins_estimator/odometry", "--json", file_name)
        with open(file_name, encoding="utf-8") as file:
            figures = json.load(file)
        self.assertGreater(figures["map"]["places"], 0)
        self.assertEqual(figures["views"]["sources"], figures["loops"]["places"])

    def test_maps_a_flight_that_drifted_far(self):
        """Half a metre and more by its end: the adjusted poses are not those of the odometry any more."""
        drifted = os.path.join(os.path.dirname(self.out), "drifted.bag")
        with rosbag.Bag(BAG) as bag, rosbag.Bag(drifted, "w") as out:
            begin, end = bag.get_start_time(), bag.get_end_time()
            for topic, message, when in bag.read_messages():
                shift = 1.2 * (message.header.stamp.to_sec() - begin) / (end - begin)
                if topic in ("/vins_estimator/keyframe_pose", "/vins_estimator/odometry"):
                    message.pose.pose.position.x += shift
                elif topic == "/vins_estimator/keyframe_point":
                    for point in message.points:
                        point.x += shift
                out.write(topic, message, when)
        self.bag = drifted
        figures = json.loads(self.map().stdout)
        with open(os.path.join(self.out, "bundle", "poses.txt"), encoding="utf-8") as file:
            adjusted = {line.split()[0]: float(line.split()[1]) for line in file if not line.startswith("#")}
        with rosbag.Bag(drifted) as bag:
            poses = [message for _, message, _ in bag.read_messages("/vins_estimator/keyframe_pose")]
        x = {f"{message.header.stamp.secs}.{message.header.stamp.nsecs:09d}": message.pose.pose.position.x for message in poses}
        shifts = [abs(x[stamp] - adjusted[stamp]) for stamp in adjusted if stamp in x]
        self.assertGreater(len(shifts), 50)
        self.assertGreater(max(shifts), 0.5)
        self.assertGreater(figures["map"]["places"], 0)

    def beside(self, name):
        return os.path.join(os.path.dirname(self.out), name)

    def test_maps_images_with_given_poses(self):
        """Of a bag of nothing but images, from poses that drift away from where it really was."""
        self.bag, poses = self.beside("images.bag"), self.beside("poses.txt")
        stamps = []
        with rosbag.Bag(BAG) as bag, rosbag.Bag(self.bag, "w") as out:
            begin, end = bag.get_start_time(), bag.get_end_time()
            for topic, message, when in bag.read_messages("/cam0/image_raw"):
                out.write(topic, message, when)
                stamps.append(message.header.stamp.to_nsec())
        with open(os.path.join(FLIGHT, "groundtruth.txt"), encoding="utf-8") as truth, open(poses, "w", encoding="utf-8") as out:
            for line in truth:
                stamp, x, rest = line.split(" ", 2)
                if stamp != "#":
                    out.write(f"{stamp} {float(x) + 0.6 * (float(stamp) - begin) / (end - begin)} {rest}")
        self.assertRegex(self.map(code=1).stderr, "bundle: .*keyframe_pose")
        figures = json.loads(self.map("--poses", poses).stdout)
        self.assertGreater(figures["bundle"]["images"], 50)
        self.assertEqual(figures["views"]["sources"], figures["loops"]["places"])
        adjusted = os.path.join(self.out, "bundle", "poses.txt")
        self.assertLess(self.error(adjusted), 0.5 * self.error(poses))

        with open(poses, "a", encoding="utf-8") as file:
            file.write("1700000000 0 0 0 0 0 0 1\n")
        again = self.map("--poses", poses)
        self.assertEqual(self.stages(again.stderr, "begins"), STAGES)

        colmap = write_model(FLIGHT, self.beside("colmap"), stamps, 0.37)
        self.assertRegex(self.map("--poses", colmap, code=1).stderr, "neither scale nor level.*keyframe_pose")
        self.bag = BAG
        metric = json.loads(self.map("--poses", colmap).stdout)
        self.assertGreater(metric["map"]["places"], 0)
        self.assertLess(self.error(adjusted), 0.1)

    def test_adds_a_flight(self):
        """Both were flown in one hall, each in the world of an odometry of its own."""
        first, place = json.loads(self.map().stdout), self.out
        with open(os.path.join(place, "map.dvm"), "rb") as file:
            before = file.read()
        add = ["--add", place]
        self.bag, self.out = os.path.join(SECOND, "flight.bag"), self.beside("both")
        refused = self.map(*add, "--set", "verification.min_ransac_inliers=9999", code=1)
        self.assertRegex(refused.stderr, "loops: .*0 keyframes found one of its places, expected at least 10")

        added = self.map(*add)
        figures = json.loads(added.stdout)
        self.assertEqual(self.stages(added.stderr, "begins"), [stage for stage in STAGES if stage != "bundle"])
        self.assertLess(figures["loops"]["join"]["rmse_m"], 0.1)
        self.assertGreater(figures["map"]["places"], first["map"]["places"])
        self.assertGreaterEqual(figures["map"]["views"], first["map"]["views"])
        self.assertEqual(figures["views"]["sources"], figures["map"]["places"] - first["map"]["places"])
        self.assertEqual(len(figures["field_quality"]["others"]), 1)
        self.assertGreater(figures["field_quality"]["before"]["views"], 0)
        self.assertGreater(figures["field"]["images"], 1.5 * first["field"]["images"])
        self.check_frame(figures)
        with open(os.path.join(place, "map.dvm"), "rb") as file:
            self.assertEqual(file.read(), before)

        self.assertRegex(self.map("--add", self.out, code=1).stderr, "--out .*expected another directory")
        with open(os.path.join(place, "map.json"), "w", encoding="utf-8") as file:
            json.dump({"flights": [{**figures["flights"][0], "bag": "/none.bag"}]}, file)
        self.assertRegex(self.map(*add, code=1).stderr, "map.json: /none.bag: no such file")

    def check_frame(self, figures):
        """The poses of both flights against the truth of both, the second one's after the first one's."""
        shift = 1000
        paths = [os.path.join(self.out, flight["poses"]) for flight in figures["flights"]]
        files = {"estimate.txt": paths, "truth.txt": [os.path.join(flight, "groundtruth.txt") for flight in (FLIGHT, SECOND)]}
        for name, sources in files.items():
            with open(self.beside(name), "w", encoding="utf-8") as out:
                for number, source in enumerate(sources):
                    with open(source, encoding="utf-8") as file:
                        for line in file:
                            stamp, rest = line.split(" ", 1)
                            if stamp != "#":
                                out.write(f"{int(stamp[:10]) + shift * number}{stamp[10:]} {rest}")
        self.assertLess(self.error(self.beside("estimate.txt"), self.beside("truth.txt")), 0.1)

    def error(self, poses, truth=os.path.join(FLIGHT, "groundtruth.txt")):
        """RMSE of positions [m]."""
        figures = self.beside("ape.json")
        subprocess.run([TOOL, "ape", truth, poses, "--align", "yaw", "--json", figures], check=True, stdout=subprocess.DEVNULL)
        with open(figures, encoding="utf-8") as file:
            return json.load(file)["rmse"]

    def test_goes_on_after_an_interrupt(self):
        record = os.path.join(self.out, "stages.json")
        with subprocess.Popen(self.command("--steps", "60"), stderr=subprocess.PIPE, stdout=subprocess.DEVNULL) as process:
            for _ in range(1200):
                if os.path.exists(record):
                    with open(record, encoding="utf-8") as file:
                        if "field" in json.load(file):
                            break
                time.sleep(0.05)
            process.send_signal(signal.SIGINT)
            self.assertIn(b"goes on from here", process.communicate(timeout=120)[1])
            self.assertEqual(process.returncode, 130)
        again = self.map()
        self.assertEqual(self.stages(again.stderr, "as it was"), STAGES[:1])
        self.assertTrue(json.loads(again.stdout)["field"]["resumed"])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])

#!/usr/bin/python3
"""views_poses_test.py TOOL FLIGHT: what `deja_view views render --poses` reads, how it compares the poses with those
of the VIO in the bag, and what it says about bad ones. FLIGHT is the directory of a simulated flight."""

import json
import os
import subprocess
import sys
import tempfile
import unittest

import rosbag

from colmap_model import read_truth, write_model

TOOL, FLIGHT = sys.argv[1:3]
TOPIC = "/vins_estimator/keyframe_pose"


class ViewsPosesTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.truth = read_truth(FLIGHT)

    def path(self, *names):
        path = os.path.join(self.folder, *names)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        return path

    def write(self, lines, *names):
        with open(self.path(*names), "w", encoding="utf-8") as file:
            file.writelines(line + "\n" for line in lines)
        return self.path(*names)

    def csv(self, ending, step=1):
        """Lines `stamp, position, quaternion (w, x, y, z)`."""
        return ["%d,%s%s" % (stamp, ",".join("%.9f" % v for v in (*p, q[3], *q[:3])), ending)
                for stamp, p, q in self.truth[::step]]

    def colmap(self, scale, *names):
        """A model of every keyframe in another frame, in units of `scale` metres."""
        with rosbag.Bag(os.path.join(FLIGHT, "flight.bag")) as bag:
            stamps = [message.header.stamp.to_nsec() for _, message, _ in bag.read_messages([TOPIC])]
        return write_model(FLIGHT, self.path(*names), stamps, scale)

    def run_tool(self, poses, *arguments):
        report = self.path("report.json")
        result = subprocess.run(
            [TOOL, "views", "render", "--bag", os.path.join(FLIGHT, "flight.bag"), "--camera",
             os.path.join(FLIGHT, "camera.yaml"), "--poses", poses, "--renderer", "warp", "--set", "sampling.views=1",
             "--set", "sources.every_m=2", "--quiet", "--no-resume", "--json", report, "--out", self.path("out.bag"),
             *arguments], capture_output=True, text=True, check=False)
        if result.returncode != 0:
            self.assertEqual(result.returncode, 1, result.stderr)
            return result.stderr
        with open(report, encoding="utf-8") as file:
            return json.load(file)

    def check(self, poses, scale=1.0, tolerance=1e-3):
        figures = self.run_tool(poses)
        self.assertIsInstance(figures, dict, figures)
        self.assertGreater(figures["views"], 3)
        self.assertEqual(figures["without_pose"], 0)
        fit = figures["alignment"]
        self.assertGreater(fit["pairs"], 50)
        self.assertLess(fit["rmse_m"], 0.2)
        self.assertAlmostEqual(fit["scale"], scale, delta=tolerance * scale)
        return figures

    def test_reads_all_formats(self):
        tum = self.check(os.path.join(FLIGHT, "groundtruth.txt"))
        for poses in (self.write(self.csv(",0.1,0.2,0.3,"), "vins_result_no_loop.csv"),
                      self.write(["#timestamp, p_RS_R_x [m], ..."] + self.csv(",0,0,0,0,0,0,0,0,0"), "data.csv")):
            figures = self.check(poses)
            self.assertAlmostEqual(figures["alignment"]["rmse_m"], tum["alignment"]["rmse_m"], delta=1e-4)
            self.assertEqual(figures["views"], tum["views"])
        self.write(self.csv(",0,0,0"), "asl", "mav0", "state_groundtruth_estimate0", "data.csv")
        self.assertEqual(self.check(self.path("asl"))["views"], tum["views"])

    def test_reads_topics(self):
        for poses in (TOPIC, os.path.join(FLIGHT, "flight.bag") + ":" + TOPIC):
            self.assertLess(self.check(poses)["alignment"]["rmse_m"], 1e-9)

    def test_gives_colmap_the_scale_of_the_vio(self):
        self.check(self.colmap(4.0, "model", "sparse", "0"), 4.0, 0.02)

    def test_refuses_colmap_without_a_vio(self):
        few = self.write(["%d.000000000 %d 0 0 0 0 0 1" % (i, i) for i in range(5)], "few.txt")
        error = self.run_tool(self.colmap(4.0, "model"), "--align-to", few)
        self.assertIn("without a scale", error)
        self.assertIn("0 poses have a common stamp", error)

    def test_refuses_poses_that_do_not_fit(self):
        stretched = [(stamp, 3 * p, q) for stamp, p, q in self.truth]
        poses = self.write(["%.9f %s" % (stamp / 1e9, " ".join("%.9f" % v for v in (*p, *q)))
                            for stamp, p, q in stretched], "stretched.txt")
        error = self.run_tool(poses)
        self.assertIn("stretched.txt", error)
        self.assertIn("does not fit: RMSE", error)
        self.assertIn("expected at most 0.2 m", error)
        # The limit is an option, and so is the comparison.
        self.assertIsInstance(self.run_tool(poses, "--set", "poses.max_rmse_m=100", "--set",
                                            "poses.inlier_distance_m=100"), dict)
        self.assertIn("not_checked", self.run_tool(poses, "--align-to", "off")["alignment"])

    def test_names_what_is_malformed(self):
        lines = self.csv(",0,0,0")
        cut = self.write(lines[:10] + [lines[10][:40]] + lines[11:], "cut.csv")
        self.assertIn("cut.csv:11", self.run_tool(cut))
        self.assertIn("stamp_ns, tx", self.run_tool(cut))
        back = self.write(lines[:10] + [lines[5]], "back.csv")
        self.assertIn("back.csv:11", self.run_tool(back))
        self.assertIn("holds no pose", self.run_tool(self.write(["# nothing"], "empty.txt")))
        self.assertIn("no such file", self.run_tool(self.path("nowhere.txt")))
        self.assertIn("/nowhere", self.run_tool("/nowhere"))
        self.assertIn("topic", self.run_tool(os.path.join(FLIGHT, "flight.bag")))
        os.makedirs(self.path("folder"))
        self.assertIn("expected a model of COLMAP", self.run_tool(self.path("folder")))
        model = self.colmap(4.0, "broken")
        with open(os.path.join(model, "images.txt"), "a", encoding="utf-8") as file:
            file.write("77 1 0 0\n\n")
        self.assertIn("images.txt", self.run_tool(model))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])

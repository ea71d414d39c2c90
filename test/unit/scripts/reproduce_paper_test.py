#!/usr/bin/python3
"""Checks what scripts/reproduce_paper tells deja_view, what it makes of the answers, and that it goes on where it was
stopped: with a program in deja_view's place that writes down its arguments."""

import contextlib
import importlib.machinery
import importlib.util
import io
import json
import os
import stat
import tempfile
import unittest

import rosbag
import rospy
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Image

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..")

CAMERA = """%YAML:1.0
model_type: PINHOLE
image_topic: "/cam0/image_raw"
image_width: 8
image_height: 6
distortion_parameters: {k1: -0.25, k2: 0.0625, p1: 0.001, p2: 0.002}
projection_parameters: {fx: 5.0, fy: 6.0, cx: 4.0, cy: 3.0}
"""

# Writes down its arguments and the results that the script reads; fails while "broken_<command>" is beside it.
FAKE = """#!/usr/bin/python3
import json, os, sys
here = os.path.dirname(os.path.abspath(sys.argv[0]))
words = sys.argv[1:]
command = "_".join(word for word in words[:2] if not word.startswith("-"))
with open(os.path.join(here, "calls"), "a") as file:
    file.write(json.dumps(words) + "\\n")
if os.path.exists(os.path.join(here, "broken_" + command)):
    print("no luck today")
    sys.exit(7)
if os.path.exists(os.path.join(here, "drift")) and any(w.endswith("/odometry") for w in words):
    print("deja_view: " + [w for w in words if w.endswith("/odometry")][0].split("=")[1] + ": does not fit: RMSE 0.3 m")
    sys.exit(1)
def value(option):
    return words[words.index(option) + 1]
def write(path, content):
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "w") as file:
        json.dump(content, file)
if command == "nerf_compare-poses":
    write(value("--json"), {"sources": [{"name": "truth", "psnr_db": 27.125, "ssim": 0.75}]})
elif command == "views_check":
    write(value("--json"), {"images": 4, "nerf_direct": {"views": 8, "visible": 900.0, "matched": 500.0,
                                                         "correct": 400.0, "precision": 0.8}})
elif command == "evaluate":
    names = words[words.index("--only") + 1:]
    entry = {"loops_accepted": 100, "loops_correct": 99, "precision": 0.99, "recall": 0.5, "cpu_s": 2.0,
             "peak_rss_mb": 80.0}
    entry.update({f"{p}ape_{k}_m": 0.1 for p in ("", "vio_") for k in ("max", "mean", "rmse", "min", "median")})
    variants = [dict(entry, name=name, cpu_s=2.5 if "virtual_paper" in name else 2.0) for name in names]
    write(os.path.join(value("--out"), "evaluation.json"), {"variants": variants})
elif command == "views_render":
    write(value("--json"), {"views": 0 if os.path.exists(os.path.join(here, "poor")) else 30})
    write(value("--out"), {})
else:
    write(value("--html") if command == "report" else value("--out"), {})
"""


def load():
    loader = importlib.machinery.SourceFileLoader("reproduce_paper", os.path.join(ROOT, "scripts", "reproduce_paper"))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("reproduce_paper", loader))
    loader.exec_module(module)
    return module


class ReproducePaper(unittest.TestCase):
    def setUp(self):
        self.script = load()
        self.directory = tempfile.TemporaryDirectory()
        self.addCleanup(self.directory.cleanup)
        self.path = lambda *names: os.path.join(self.directory.name, *names)
        self.write("camera.yaml", CAMERA)
        self.write("truth.txt", "1 0 0 0 0 0 0 1\n")
        self.write("deja_view", FAKE)
        os.chmod(self.path("deja_view"), os.stat(self.path("deja_view")).st_mode | stat.S_IXUSR)
        self.write_bag("flight.bag", vio=True)

    def write(self, name, text):
        with open(self.path(name), "w", encoding="utf-8") as file:
            file.write(text)

    def write_bag(self, name, vio):
        with rosbag.Bag(self.path(name), "w") as bag:
            for number in range(1, 9):
                stamp = rospy.Time(number)
                image = Image(height=6, width=8, encoding="mono8", step=8, data=bytes(48))
                image.header.stamp = stamp
                bag.write("/cam0/image_raw", image, stamp)
                for topic in self.script.VIO_TOPICS if vio else ():
                    bag.write("/vins_estimator/" + topic, Odometry(), stamp)

    def run_script(self, *words, bag="flight.bag"):
        """Exit code, and what was said."""
        said = io.StringIO()
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            code = self.script.main([
                self.path(bag), "--groundtruth", self.path("truth.txt"), "--camera", self.path("camera.yaml"), "--out",
                self.path("out"), "--deja-view", self.path("deja_view"), *words])
        return code, said.getvalue()

    def calls(self):
        with open(self.path("calls"), encoding="utf-8") as file:
            return [json.loads(line) for line in file]

    def test_runs_every_step_once(self):
        code, said = self.run_script("--quick")
        self.assertEqual(code, 0, said)
        commands = [" ".join(words[:2]) if words[0] in ("nerf", "views") else words[0] for words in self.calls()]
        self.assertEqual(commands, ["nerf compare-poses", "nerf train", "views check", "views render", "evaluate",
                                    "report"])
        train = self.calls()[1]
        self.assertEqual(train[train.index("--budget-s") + 1], "20")
        self.assertEqual(train[train.index("--poses") + 1], self.path("out", "truth.txt"))
        self.assertEqual(len(os.listdir(self.path("out", "images"))), 2)  # every fourth of eight
        evaluate = self.calls()[4]
        self.assertIn("orb_virtual_paper", evaluate)
        self.assertIn(f"virtual_paper=--virtual-bag {self.path('out', 'views.bag')}", evaluate)
        # Once more: only the report is made anew.
        code, said = self.run_script("--quick")
        self.assertEqual(code, 0, said)
        self.assertEqual([words[0] for words in self.calls()[6:]], ["report"])

    def test_the_report_has_the_tables(self):
        self.assertEqual(self.run_script()[0], 0)
        report = self.calls()[-1]
        tables = dict(report[i + 1].split("=", 1) for i, word in enumerate(report) if word == "--table")
        for number in range(2, 9):
            self.assertEqual(sum(caption.startswith(f"Table {number}:") for caption in tables), 1, number)
        with open(tables["Where the paper's tables and figures are"], encoding="utf-8") as file:
            listed = " ".join(row[0] for row in json.load(file))
        for number in range(6, 21):
            self.assertRegex(listed, rf"\b{number}\b")
        rows = {caption.split(":")[0]: self.script.read_json(file) for caption, file in tables.items()}
        self.assertEqual(rows["Table 2"][1], ["truth", "27.12", "0.7500"])
        self.assertEqual(rows["Table 3"][2], ["with virtual views", 100, "99", "0.9900", "0.500"])
        self.assertEqual(rows["Table 5"][1][1:], ["0.1000", "–", "0.1000", "0.1000"])
        self.assertEqual(rows["Table 7"][1], ["BRIEF", "2.00", "2.50", "25.0"])
        self.assertEqual(rows["Table 8"][2], ["ORB", "80.0", "80.0", "0.0"])
        self.assertEqual(rows["Figure 6"][1], ["nerf direct", 8, "900.0", "500.0", "400.0", "0.800"])
        ran = [report[i + 1] for i, word in enumerate(report) if word == "--ran"]
        self.assertEqual(len(ran), 5)

    def test_a_failure_names_the_step_and_is_made_good(self):
        self.write("broken_views_render", "")
        code, said = self.run_script("--quick")
        self.assertEqual(code, 1)
        self.assertIn("Rendering virtual views failed with 7", said)
        self.assertIn("no luck today", said)
        os.remove(self.path("broken_views_render"))
        before = len(self.calls())
        self.assertEqual(self.run_script("--quick")[0], 0)
        self.assertEqual([words[0] for words in self.calls()[before:]], ["views", "evaluate", "report"])

    def test_an_odometry_that_drifts_is_left_out(self):
        self.write("drift", "")
        code, said = self.run_script("--quick")
        self.assertEqual(code, 0, said)
        self.assertIn("does without 'vio'", said)
        report = self.calls()[-1]
        table = next(report[i + 1].split("=", 1)[1] for i, word in enumerate(report)
                     if word == "--table" and "=" in report[i + 1] and report[i + 1].startswith("Table 2"))
        self.assertIn(["vio", "does not fit the truth", "–"], self.script.read_json(table))
        self.assertEqual(sum("compare-poses" in word for word in report), 1, "what failed is not among the commands")
        # The poses of the field must fit.
        os.remove(self.path("out", "poses.json"))
        self.write("odometry", "1 0 0 0 0 0 0 1\n")
        self.assertEqual(self.run_script("--poses", self.path("odometry"))[0], 1)

    def test_a_field_without_views_is_told(self):
        self.write("poor", "")
        code, said = self.run_script("--quick")
        self.assertEqual(code, 1)
        self.assertIn("holds no virtual view, since the field is too poor", said)

    def test_further_sources_of_poses(self):
        self.write("maplab.txt", "1 0 0 0 0 0 0 1\n")
        code, said = self.run_script("--poses", self.path("maplab.txt"), "--source", "vicon=v.txt")
        self.assertEqual(code, 0, said)
        compare, train = self.calls()[:2]
        sources = [compare[i + 1] for i, word in enumerate(compare) if word == "--source"]
        self.assertEqual(sources, [f"truth={self.path('out', 'truth.txt')}",
                                   f"vio={self.path('flight.bag')}:/vins_estimator/odometry",
                                   f"given={self.path('maplab.txt')}", "vicon=v.txt"])
        self.assertEqual(train[train.index("--poses") + 1], self.path("maplab.txt"))
        self.assertEqual(self.run_script("--source", "nameless")[0], 1)

    def test_reads_eurocs_truth(self):
        self.write("data.csv", "#timestamp, p_x\n1403636580838555648,1.5,2,3,1,0,0.25,0,9,9\n")
        self.script.to_tum(self.path("data.csv"), self.path("tum.txt"))
        with open(self.path("tum.txt"), encoding="utf-8") as file:
            self.assertEqual(file.read(), "1403636580.838555648 1.5 2.0 3.0 0.0 0.25 0.0 1.0\n")
        self.write("data.csv", "#timestamp\n1,2\n")
        with self.assertRaisesRegex(self.script.UserError, "data.csv:2: expected stamp"):
            self.script.to_tum(self.path("data.csv"), self.path("tum.txt"))

    def test_bad_input_is_told(self):
        self.assertIn("no such file", self.run_script(bag="nothing.bag")[1])
        self.write("text.bag", "no bag")
        self.assertIn("can't be read as a bag", self.run_script(bag="text.bag")[1])
        self.write("camera.yaml", CAMERA.replace("/cam0", "/cam1"))
        code, said = self.run_script()
        self.assertEqual(code, 1)
        self.assertIn("no topic '/cam1/image_raw'", said)
        with contextlib.redirect_stderr(io.StringIO()):
            for words in (("--poses", "/nowhere"), ("--train", "1"), ("--no-such",)):
                with self.assertRaises(SystemExit):
                    self.run_script(*words)
        self.assertIn("expected a path without blanks", self.run_script("--out", self.path("a b"))[1])

    def test_vins_mono_is_missed_only_where_it_is_needed(self):
        self.write_bag("images.bag", vio=False)
        code, said = self.run_script("--build", self.path("nothing"), bag="images.bag")
        self.assertEqual(code, 1)
        self.assertIn("Recording VINS-Mono failed", said)
        self.assertFalse(os.path.exists(self.path("calls")))


if __name__ == "__main__":
    unittest.main()

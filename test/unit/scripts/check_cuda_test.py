#!/usr/bin/python3
"""Checks the measuring part of scripts/check_cuda: on the CPU, with the build in the folder that the first argument
names; and what it tells without a card or when something fails, with a program in deja_view's place."""

import importlib.machinery
import importlib.util
import json
import os
import stat
import subprocess
import sys
import tempfile
import unittest

import cv2
import numpy as np

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..")
SCRIPT = os.path.join(ROOT, "scripts", "support", "check_cuda.py")
BUILD = sys.argv.pop(1)
NO_CARD = 3


def load_script():
    loader = importlib.machinery.SourceFileLoader("check_cuda", SCRIPT)
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("check_cuda", loader))
    loader.exec_module(module)
    return module


script = load_script()

# Knows of no card, or of the one whose trainings fail.
FAKE = """#!/usr/bin/python3
import json, os, sys
here = os.path.dirname(os.path.abspath(__file__))
words = sys.argv[1:]
if words[:2] == ["nerf", "info"]:
    cards = ["cuda:0 Imaginary"] if os.path.exists(os.path.join(here, "card")) else []
    with open(words[words.index("--json") + 1], "w", encoding="utf-8") as file:
        json.dump({"devices": {"cards": cards, "problem": "" if cards else "no driver"}}, file)
elif words[:2] == ["nerf", "train"]:
    sys.exit(75)
"""

RESULTS = """<?xml version="1.0"?>
<testsuites tests="2" failures="1"><testsuite name="Scatter">
<testcase name="Adds" classname="Scatter" /><testcase name="Sorts" classname="Scatter"><failure message="no"/></testcase>
</testsuite></testsuites>
"""

COMMAND = "nvcc --generate-code=arch=compute_75,code=[sm_75] --generate-code=arch=compute_90,code=[compute_90,sm_90] -O3"


class CheckCudaTest(unittest.TestCase):
    def setUp(self):
        directory = tempfile.TemporaryDirectory()
        self.addCleanup(directory.cleanup)
        self.path = directory.name

    def write(self, name, text):
        path = os.path.join(self.path, name)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        return path

    def check(self, code, *arguments, build=None):
        """Returns the JSON."""
        out = os.path.join(self.path, "out.json")
        result = subprocess.run(
            ["/usr/bin/python3", "-B", SCRIPT, "--build", build or self.path, "--out", out, *arguments],
            capture_output=True, text=True, check=False)
        self.assertEqual(result.returncode, code, result.stderr)
        with open(out, encoding="utf-8") as file:
            found = json.load(file)
        self.assertEqual(json.loads(result.stdout), found)
        return found


class FakeToolTest(CheckCudaTest):
    def setUp(self):
        super().setUp()
        os.chmod(self.write("bin/deja_view", FAKE), stat.S_IRWXU)
        self.write("compile_commands.json", json.dumps([
            {"file": "a.cpp", "command": "g++ -O3"}, {"file": "b.cu", "command": COMMAND}]))
        self.write("results/scatter_test.xml", RESULTS)

    def test_without_a_card_it_tells_what_was_built_and_tested(self):
        found = self.check(NO_CARD, "--test-results", os.path.join(self.path, "results"))
        self.assertEqual(found["compiled_for"], ["compute_90", "sm_75", "sm_90"])
        self.assertEqual(found["test_programs"], {"scatter_test": {"run": 2, "failed": ["Scatter.Sorts"]}})
        self.assertEqual(found["devices"]["problem"], "no driver")
        self.assertNotIn("curve", found)

    def test_failed_tests_are_a_failure_even_without_a_card(self):
        self.assertEqual(self.check(1, "--tests", "failed")["tests"], "failed")

    def test_what_does_not_work_is_told(self):
        self.write("bin/card", "")
        found = self.check(1, "--images", "images", "--camera", "camera.yaml", "--poses", "poses.txt")
        self.assertEqual(found["problem"], "training 93 steps on cuda:0 failed with exit code 75")
        self.assertEqual(found["devices"]["cards"], ["cuda:0 Imaginary"])

    def test_images_without_poses_are_refused(self):
        result = subprocess.run(["/usr/bin/python3", "-B", SCRIPT, "--build", self.path, "--images", "images"],
                                capture_output=True, text=True, check=False)
        self.assertEqual(result.returncode, 2)
        self.assertIn("expected all of them", result.stderr)


class ComparisonTest(CheckCudaTest):
    def write_pictures(self, folder, image, depth):
        os.mkdir(os.path.join(self.path, folder))
        paths = [os.path.join(self.path, folder, name) for name in ("000000.depth.png", "000000.png")]
        cv2.imwrite(paths[0], np.array(depth, np.uint16))
        cv2.imwrite(paths[1], np.array(image, np.uint8))
        return paths

    def test_same_are_pixels_within_a_grey_level_and_half_a_percent_of_depth(self):
        expected = self.write_pictures("a", [[10, 20, 30, 0]], [[10000, 10000, 100, 0]])
        found = self.write_pictures("b", [[11, 18, 30, 255]], [[10050, 10051, 101, 2]])
        self.assertEqual(script.compare_pictures(expected, found), {
            "image": {"values": 4, "same_share": 0.5}, "depth": {"values": 4, "same_share": 0.5}})

    def test_missing_views_are_not_alike(self):
        expected = self.write_pictures("a", [[10]], [[1000]])
        for found in (expected[:1], []):
            with self.assertRaises(script.CheckError):
                script.compare_pictures(expected, found)
        with self.assertRaises(script.CheckError):
            script.compare_pictures([], [])

    def test_time_to_a_level_lies_between_two_trainings(self):
        points = [{"train_s": 1.0, "psnr_db": 20.0}, {"train_s": 3.0, "psnr_db": 24.0}]
        self.assertEqual(script.seconds_to(points, 19), 1.0)
        self.assertEqual(script.seconds_to(points, 23), 2.5)
        self.assertIsNone(script.seconds_to(points, 25))
        self.assertIsNone(script.seconds_to([], 25))


class CpuTest(CheckCudaTest):
    """Every step of the measuring, with the CPU in the card's place."""

    TINY = ["--device", "cpu", "--preset", "small", "--duration", "4", "--scale", "0.25", "--steps", "3"]

    def expect_measured(self, found):
        self.assertEqual([point["steps"] for point in found["curve"]], [1, 3])
        for point in found["curve"]:
            self.assertGreater(point["psnr_db"], 5)
            self.assertGreater(point["samples_per_s"], 0)
            self.assertGreater(point["rays_per_s"], 0)
            self.assertGreater(point["train_s"], 0)
        self.assertEqual(set(found["seconds_to_db"]), {"25", "27", "28"})
        self.assertGreater(found["render_ms_median_at_0.5"], 0)
        self.assertGreater(found["render_ms_median_at_1"], 0)
        self.assertEqual(found["psnr_gap_db"], 0)  # the CPU's training is repeatable
        for kind in ("image", "depth"):
            self.assertGreater(found["agreement"][kind]["values"], 0)
            self.assertEqual(found["agreement"][kind]["same_share"], 1)

    def test_a_simulated_flight(self):
        self.expect_measured(self.check(0, *self.TINY, build=BUILD))

    def test_given_images(self):
        flight = os.path.join(self.path, "flight")
        subprocess.run([os.path.join(BUILD, "bin", "deja_view"), "simulate", "--preset", "small", "--duration", "4",
                        "--images", "png", "--quiet", "--out", flight], capture_output=True, check=True)
        self.expect_measured(self.check(
            0, *self.TINY, "--images", os.path.join(flight, "images"), "--camera", os.path.join(flight, "camera.yaml"),
            "--poses", os.path.join(flight, "groundtruth.txt"), build=BUILD))


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/python3
"""bundle_test.py TOOL FLIGHT: what `deja_view bundle` makes of a flight and of posed images. FLIGHT is the directory of a
simulated flight."""

import json
import os
import subprocess
import sys
import tempfile
import unittest

TOOL, FLIGHT = sys.argv[1:3]
CAMERA, TRUTH = os.path.join(FLIGHT, "camera.yaml"), os.path.join(FLIGHT, "groundtruth.txt")


class BundleTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def path(self, *names):
        return os.path.join(self.folder, *names)

    def bundle(self, out, *arguments):
        result = subprocess.run([TOOL, "bundle", "--quiet", "--out", self.path(out), *arguments],
                                capture_output=True, text=True, check=False)
        self.assertEqual(result.returncode, 0, result.stderr)
        return json.loads(result.stdout)

    def flight(self, out, *arguments):
        return self.bundle(out, "--bag", os.path.join(FLIGHT, "flight.bag"), "--camera", CAMERA, *arguments)

    def rmse(self, out):
        subprocess.run([TOOL, "ape", TRUTH, self.path(out, "poses.txt"), "--json", self.path("ape.json")],
                       capture_output=True, check=True)
        with open(self.path("ape.json"), encoding="utf-8") as file:
            return json.load(file)["rmse"]

    def test_takes_the_drift_out_of_a_flight(self):
        figures = self.flight("adjusted")
        self.assertEqual(figures["weak_images"], 0)
        self.assertFalse(figures["interrupted"])
        self.assertLess(self.rmse("adjusted"), 0.03)
        self.flight("again", "--set", "bundle.threads=1")
        for name in ("poses.txt", "colmap/images.txt", "colmap/points3D.txt"):
            with open(self.path("adjusted", name), "rb") as one, open(self.path("again", name), "rb") as other:
                self.assertEqual(one.read(), other.read(), name)

    def test_refines_beside_other_options(self):
        figures = self.flight("refined", "--refine", "intrinsics", "--set", "bundle.rounds=1")
        self.assertEqual(len(figures["rounds"]), 1)
        self.assertNotEqual(figures["cameras"][0]["projection"], figures["cameras_before"][0]["projection"])
        self.assertEqual(figures["cameras"][0]["distortion"], figures["cameras_before"][0]["distortion"])

    def test_names_images_as_their_files_are(self):
        self.flight("flight", "--write-images", "--set", "bundle.rounds=1")
        images = self.path("flight", "colmap", "images")
        self.bundle("posed", "--images", images, "--poses", TRUTH, "--camera", CAMERA, "--set", "bundle.rounds=1")
        for model in ("flight", "posed"):
            with open(self.path(model, "colmap", "images.txt"), encoding="utf-8") as file:
                lines = [line for line in file.read().splitlines() if not line.startswith("#")]
            self.assertEqual(sorted(line.split()[-1] for line in lines[::2]), sorted(os.listdir(images)))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])

#!/usr/bin/python3
"""soak_test.py BUILD FLIGHT: what scripts/soak says of a node that flies the simulated flight in the directory FLIGHT there
and back."""

import json
import os
import subprocess
import sys
import tempfile
import unittest

BUILD, FLIGHT = sys.argv[1:3]
SCRIPT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts", "soak")


class SoakTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def path(self, name):
        return os.path.join(self.folder, name)

    def soak(self, *arguments):
        command = [SCRIPT, "--build", BUILD, "--bag", os.path.join(FLIGHT, "flight.bag"), "--interval", "0.5"]
        command += ["--camera", os.path.join(FLIGHT, "camera.yaml"), *arguments]
        return subprocess.run(command, capture_output=True, text=True, check=False)

    def test_flies_there_and_back(self):
        report, out = self.path("soak.json"), self.path("out")
        result = self.soak("--hours", "0.04", "--json", report, "--out", out)
        self.assertEqual(result.returncode, 0, result.stderr)
        with open(report, encoding="ascii") as file:
            figures = json.load(file)
        self.assertEqual((figures["keyframes"], figures["processed"]), (288, 288))
        self.assertEqual(set(figures["dropped"].values()), {0})
        self.assertGreater(figures["loops"], 100)  # on the way back all is known
        self.assertGreater(len(figures["samples"]), 10)
        self.assertGreater(figures["cpu_ms_last_quarter"], 0)
        with open(os.path.join(out, "trajectory.txt"), encoding="ascii") as file:
            poses = [[float(number) for number in line.split()] for line in file if not line.startswith("#")]
        self.assertEqual(len(poses), 288)
        self.assertAlmostEqual(poses[-1][0] - poses[0][0], 287 * 0.5, places=6)

    def test_tells_what_is_too_much_or_missing(self):
        result = self.soak("--hours", "0.005", "--max-mb", "1", "--max-bytes", "0")
        self.assertEqual(result.returncode, 1, result.stdout)
        self.assertRegex(result.stderr, r"soak: \d+\.\d MB, expected at most 1\.0")

        broken = self.path("broken.yaml")
        with open(broken, "w", encoding="ascii") as file:
            file.write("consistency: {no_such_key: 1}\n")
        result = self.soak("--hours", "0.005", "--options", broken)
        self.assertEqual(result.returncode, 1, result.stdout)
        self.assertRegex(result.stderr, "soak: the node does not listen(.|\n)*no_such_key")

        result = self.soak("--image-topic", "/none")
        self.assertEqual(result.returncode, 1, result.stdout)
        self.assertRegex(result.stderr, "soak: .*flight.bag: .*missing: .*/none")

        result = self.soak("--build", self.folder)
        self.assertEqual(result.returncode, 1, result.stdout)
        self.assertRegex(result.stderr, "soak: .*loop_fusion_node: no such program")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])

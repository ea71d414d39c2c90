#!/usr/bin/python3
"""explain_test.py TOOL FLIGHT: what `deja_view explain` says of pairs of the simulated flight in the directory FLIGHT."""

import csv
import json
import os
import subprocess
import sys
import tempfile
import unittest

TOOL, FLIGHT = sys.argv[1:3]
FILES = ["--bag", os.path.join(FLIGHT, "flight.bag"), "--camera", os.path.join(FLIGHT, "camera.yaml"), "--quiet"]


class ExplainTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def run_tool(self, command, *arguments):
        return subprocess.run([TOOL, command, *FILES, *arguments], capture_output=True, text=True, check=False)

    def loops(self):
        out = os.path.join(self.folder, "run")
        self.assertEqual(self.run_tool("replay", "--out", out).returncode, 0)
        with open(os.path.join(out, "loops.csv"), encoding="utf-8") as file:
            return list(csv.DictReader(file))

    def test_says_what_the_flight_decided_and_shows_it(self):
        loop = next(row for row in self.loops() if row["reason"] == "accepted")
        file, out = os.path.join(self.folder, "why.json"), os.path.join(self.folder, "why")
        stamps = loop["stamp_current_ns"], loop["stamp_old_ns"]
        result = self.run_tool("explain", "--pair", *stamps, "--out", out, "--json", file)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("accepted", result.stdout.splitlines()[0])
        with open(file, encoding="utf-8") as lines:
            figures = json.load(lines)
        self.assertEqual(figures["reason"], "accepted")
        self.assertEqual(figures["real"]["inliers"], int(loop["inliers"]))
        self.assertTrue(all(gate["passes"] for gate in figures["real"]["gates"]))
        with open(os.path.join(out, "explanation.html"), encoding="utf-8") as file:
            page = file.read()
        self.assertEqual(page.count("data:image/jpeg;base64,"), 4, "both images, with inliers and with first matches")
        self.assertIn(f"{loop['inliers']} inliers", page)

    def test_a_gate_that_fails_is_named(self):
        loop = next(row for row in self.loops() if row["reason"] == "accepted")
        stamps = loop["stamp_current_ns"], loop["stamp_old_ns"]
        result = self.run_tool("explain", "--pair", *stamps, "--out", self.folder, "--set", "verification.max_yaw_deg=0.001")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("too_much_yaw", result.stdout.splitlines()[0])
        self.assertIn("FAILS  verification.max_yaw_deg", result.stdout)

    def test_stamps_that_name_no_keyframes_are_an_error(self):
        for stamps, said in ((("1.5", "1.2"), "no two keyframes"), (("now", "1"), "--pair now: expected a stamp")):
            result = self.run_tool("explain", "--pair", *stamps, "--out", self.folder)
            self.assertNotEqual(result.returncode, 0)
            self.assertIn(said, result.stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)

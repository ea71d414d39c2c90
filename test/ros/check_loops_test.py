#!/usr/bin/python3
"""check_loops_test.py TOOL: scripts/check_loops finds no wrong loop in a small world, goes on after a kill where it was,
and fails when the gates let wrong loops through; with exact views of the places, and with those of a field."""

import json
import os
import shutil
import stat
import subprocess
import sys
import tempfile
import unittest

TOOL = sys.argv[1]
SCRIPT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts", "check_loops")

# Writes down each call; while the file "kill" is beside it, the first replay that should save a map leaves an empty
# folder and takes check_loops with it.
WRAPPER = """#!/usr/bin/python3
import os, signal, sys
here = os.path.dirname(os.path.abspath(__file__))
with open(os.path.join(here, "calls"), "a", encoding="utf-8") as file:
    file.write(" ".join(sys.argv[1:]) + "\\n")
kill = os.path.join(here, "kill")
if "--save-map" in sys.argv and os.path.exists(kill):
    os.remove(kill)
    os.makedirs(sys.argv[sys.argv.index("--save-map") + 1])
    os.kill(os.getppid(), signal.SIGKILL)
    sys.exit(1)
os.execv({tool!r}, [{tool!r}] + sys.argv[1:])
"""

# Pictures of other places match, and nothing asks whether that is chance or fits the odometry.
LOOSE = [
    "consistency.min_support=0", "consistency.min_support_join=0", "consistency.max_support_ratio=1000",
    "consistency.max_sigmas=1000", "consistency.plausible_over_depth=100",
    "consistency.plausible_soon_over_depth=100", "consistency.max_innovation_ratio=1000",
    "verification.max_distance=200",
    "verification.max_ratio=1", "verification.max_log10_false_alarms=-0.001", "verification.min_inlier_ratio=0.01",
    "verification.max_sigma_m=10", "verification.max_sigma_over_depth=1", "verification.max_gravity_deg=90",
    "verification.max_yaw_deg=180", "verification.max_distance_over_depth=100",
    "verification.pose.inlier_threshold_px=40", "verification.pose.ransac_threshold_px=40",
]


class CheckLoopsTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        with open(self.path("deja_view"), "w", encoding="utf-8") as file:
            file.write(WRAPPER.format(tool=os.path.abspath(TOOL)))
        os.chmod(self.path("deja_view"), stat.S_IRWXU)

    def path(self, *names):
        return os.path.join(self.folder, *names)

    def check(self, out, modes, *more):
        """Returns exit code, what was printed, and the calls of the program."""
        if os.path.exists(self.path("calls")):
            os.remove(self.path("calls"))
        command = [SCRIPT, "--deja-view", self.path("deja_view"), "--out", self.path(out), "--presets", "small",
                   "--seeds", "1", "--modes", modes, "--duration", "24", "--jobs", "1", "--keep", *more]
        result = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
        calls = []
        if os.path.exists(self.path("calls")):
            with open(self.path("calls"), encoding="utf-8") as file:
                calls = [line.split()[0] for line in file]
        return result.returncode, result.stdout, calls

    def test_finds_wrong_loops_and_goes_on_after_a_kill(self):
        with open(self.path("kill"), "w", encoding="ascii"):
            pass
        code, text, calls = self.check("out", "other,alone")
        self.assertEqual((code, calls), (-9, ["simulate", "simulate", "replay"]), text)

        report = self.path("report.json")
        code, text, calls = self.check("out", "other,alone", "--json", report)
        self.assertEqual(code, 0, text)
        self.assertEqual(calls, ["replay", "replay", "replay"])  # the flights were there; the map was not
        self.assertRegex(text, r"2 flights, \d+ loops, 0 wrong")
        with open(report, encoding="ascii") as file:
            figures = json.load(file)
        self.assertEqual((figures["flights"], figures["wrong"]), (2, 0))
        loops = {row["mode"]: row["flights"]["1"]["loops"] for row in figures["rows"]}
        worst = {row["mode"]: row["flights"]["1"].get("worst_m") for row in figures["rows"]}
        self.assertTrue(0 < worst["alone"] < 0.5, worst)
        self.assertIsNone(worst["other"])
        self.assertGreater(loops["alone"], 10)
        self.assertEqual(loops["other"], 0)

        code, text, calls = self.check("out", "other,alone")
        self.assertEqual((code, calls), (0, []), text)  # nothing is left to do

        for flight in ("first", "other"):
            shutil.copytree(self.path("out", "small_1", flight), self.path("loose", "small_1", flight))
        code, text, calls = self.check("loose", "other", "--json", report, *(f"--set={option}" for option in LOOSE))
        self.assertEqual((code, calls), (1, ["replay", "replay"]), text)
        with open(report, encoding="ascii") as file:
            self.assertGreater(json.load(file)["wrong"], 0)

    def test_flies_with_views_of_the_places(self):
        report = self.path("report.json")
        views = ("--views", "wide,field", "--field-steps", "300", "--json", report)
        code, text, calls = self.check("views", "localise", *views)
        self.assertEqual(code, 0, text)
        # Two flights with exact views, then the two without, of which a field each learns and renders.
        of_views = ["simulate"] * 2 + ["replay"] * 2 + ["simulate"] * 2 + ["map", "replay"] * 2
        self.assertEqual(calls, of_views)
        with open(report, encoding="ascii") as file:
            rows = {row["views"]: row["flights"]["1"] for row in json.load(file)["rows"]}
        self.assertGreater(rows["wide"]["of_views"], 0)
        self.assertGreater(rows["field"]["of_views"], 0)
        self.assertEqual((rows["wide"]["wrong"], rows["field"]["wrong"]), (0, 0))

        code, text, calls = self.check("views", "localise", *views)
        self.assertEqual((code, calls), (0, []), text)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])

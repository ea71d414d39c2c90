#!/usr/bin/python3
"""files_test.py TOOL FLIGHT: every file that the tool writes is read again by the command that it is for; a file without
a reader fails. FLIGHT holds a simulated flight with images."""

import fnmatch
import json
import os
import subprocess
import sys
import tempfile
import unittest

TOOL, FLIGHT = sys.argv[1:3]
BAG, CAMERA = os.path.join(FLIGHT, "flight.bag"), os.path.join(FLIGHT, "camera.yaml")
TRUTH, IMAGES = os.path.join(FLIGHT, "groundtruth.txt"), os.path.join(FLIGHT, "images")
FLIGHT_INPUT = ["--bag", BAG, "--camera", CAMERA, "--quiet"]
SMALL_FIELD = ["--holdout", "0", "--scale", "0.125", "--steps", "20", "--no-sparse-points", "--quiet",
               "--set", "field.geometry.log2_table_size=12", "--set", "field.appearance.log2_table_size=12",
               "--set", "target_samples=4096"]
FEW_VIEWS = ["--set", "sampling.views=1", "--set", "sources.every_m=5", "--set", "sources.every_deg=180"]


class FilesTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.read = []

    def path(self, *parts):
        return os.path.join(self.folder, *parts)

    def run_tool(self, *command):
        done = subprocess.run([TOOL, *command], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, " ".join(command) + "\n" + done.stderr)

    def reads(self, pattern, *command):
        """The command reads what fits the pattern."""
        self.assertTrue(fnmatch.filter(self.files(), pattern), pattern)
        self.run_tool(*command)
        self.read.append(pattern)

    def files(self):
        return [os.path.relpath(os.path.join(base, name), self.folder)
                for base, _, names in os.walk(self.folder) for name in names]

    def check_that_all_are_read(self):
        for name in self.files():
            if name.endswith(".json"):
                with open(self.path(name), encoding="utf-8") as file:
                    json.load(file)
            elif not name.endswith(".html"):
                self.assertTrue(any(fnmatch.fnmatch(name, pattern) for pattern in self.read), name + " has no reader")

    def test_flight_of_the_simulator(self):
        flight = self.path("flight")
        more = ["--ranges", "--virtual-views", "wide", "--virtual-content", "image", "--json", self.path("flight.json")]
        self.run_tool("simulate", "--preset", "small", "--duration", "3", "--bag", "--images", "png", "--quiet", "--out",
                      flight, *more)
        camera, truth = os.path.join(flight, "camera.yaml"), os.path.join(flight, "groundtruth.txt")
        bag = os.path.join(flight, "flight.bag")
        self.reads("flight/flight.bag", "check", "--bag", bag)
        self.reads("flight/*.txt", "ape", truth, os.path.join(flight, "vio.txt"))
        self.reads("flight/simulation.yaml", "simulate", "--config", os.path.join(flight, "simulation.yaml"), "--quiet",
                   "--images", "none", "--out", self.path("again"))
        self.read.append("again/*")
        self.reads("flight/images/*", "nerf", "train", "--images", os.path.join(flight, "images"), "--camera", camera,
                   "--poses", truth, *SMALL_FIELD, "--out", self.path("field.dvn"))
        self.reads("flight/ranges/*", "views", "render", "--images", os.path.join(flight, "images"), "--camera", camera,
                   "--poses", truth, "--renderer", "warp", "--depth-maps", os.path.join(flight, "ranges"),
                   "--depth-along", "ray", "--quiet", "--out", self.path("warped.bag"), *FEW_VIEWS)
        self.read.append("flight/camera.yaml")  # by all of these
        self.reads("*.bag", "check", "--bag", self.path("warped.bag"))
        self.read.append("field.dvn")  # by the test below
        self.check_that_all_are_read()

    def test_results_of_a_replay(self):
        run = self.path("run")
        self.run_tool("replay", *FLIGHT_INPUT, "--groundtruth", TRUTH, "--out", run, "--save-map", self.path("map"),
                      "--json", self.path("replay.json"))
        trajectory = os.path.join(run, "trajectory.txt")
        self.reads("map/map.dvm", "replay", *FLIGHT_INPUT, "--load-map", self.path("map"))
        self.reads("run/trajectory.txt", "nerf", "train", "--bag", BAG, "--camera", CAMERA, "--poses", trajectory,
                   "--skip-missing", *SMALL_FIELD, "--out", self.path("field.dvn"))
        self.reads("run/*.txt", "ape", TRUTH, os.path.join(run, "vio.txt"))
        self.reads("run/places.txt", "views", "render", *FLIGHT_INPUT, "--poses", TRUTH, "--model",
                   os.path.join(FLIGHT, "models", "room.dvn"), "--places", os.path.join(run, "places.txt"), "--out", self.path("views.bag"),
                   *FEW_VIEWS, "--set", "min_correlation=-1")
        self.reads("views.bag", "replay", "--virtual-bag", self.path("views.bag"), *FLIGHT_INPUT)
        self.reads("run/*.csv", "report", "--run", run, "--groundtruth", TRUTH, "--camera", CAMERA, "--bag", BAG,
                   "--html", self.path("report.html"), "--sweep", run)
        self.reads("field.dvn", "nerf", "info", self.path("field.dvn"))
        self.run_tool("evaluate", *FLIGHT_INPUT, "--groundtruth", TRUTH, "--out", self.path("variants"), "--only",
                      "no_virtual")
        self.reads("variants/*", "report", "--evaluation", self.path("variants"), "--groundtruth", TRUTH, "--camera",
                   CAMERA, "--out", self.path("pictures"))
        self.read.append("pictures/*.svg")  # for people
        self.check_that_all_are_read()

    def test_poses_that_were_adjusted(self):
        train = ["nerf", "train", *SMALL_FIELD, "--out", self.path("field.dvn")]
        self.run_tool("bundle", *FLIGHT_INPUT, "--no-loops", "--write-images", "--out", self.path("bundle"))
        self.reads("bundle/colmap/*", *train, "--colmap", self.path("bundle", "colmap"))
        self.reads("bundle/poses.txt", "nerf", "align", "--model", self.path("field.dvn"), "--poses",
                   self.path("bundle", "colmap"), "--camera", CAMERA, "--align-to", self.path("bundle", "poses.txt"),
                   "--out", self.path("field.dvn"), "--json", self.path("align.json"))
        self.reads("field.dvn", "nerf", "info", self.path("field.dvn"))
        self.check_that_all_are_read()

    def test_vocabularies(self):
        first = self.path("first.bin")
        self.run_tool("vocabulary", "train", "--images", IMAGES, "--k", "4", "--levels", "3", "--out", first)
        for name, written in (("first.bin", "second.dvv"), ("second.dvv", "third.bin")):
            self.reads(name, "vocabulary", "convert", self.path(name), self.path(written))
        self.reads("third.bin", "replay", *FLIGHT_INPUT, "--vocabulary", self.path("third.bin"))
        words = self.path("words.txt")
        self.run_tool("vocabulary", "train", "--descriptor", "orb", "--images", IMAGES, "--k", "4", "--levels", "3", "--out",
                      words)
        self.reads("words.txt", "replay", *FLIGHT_INPUT, "--set", "features.kind=orb", "--vocabulary", words)
        self.check_that_all_are_read()


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])

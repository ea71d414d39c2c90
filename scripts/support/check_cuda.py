#!/usr/bin/env python3
"""The measuring part of scripts/check_cuda: trains and renders on a card and on the CPU, and prints one JSON."""
import argparse
import glob
import json
import os
import re
import subprocess
import sys
import tempfile
import xml.etree.ElementTree

import cv2
import numpy as np

NO_CARD = 3
LEVELS_DB = (25, 27, 28)
SHARES = (32, 16, 8, 4, 2, 1)  # of the steps: trainings that are so many times shorter
CPU = "cpu"


class CheckError(Exception):
    """What did not work."""


def call(arguments, what):
    """Runs the tool; its messages go to our error stream."""
    print("== %s" % what, file=sys.stderr, flush=True)
    result = subprocess.run(arguments, stdout=subprocess.DEVNULL, check=False)
    if result.returncode != 0:
        raise CheckError("%s failed with exit code %d" % (what, result.returncode))


def read_json(path):
    with open(path, encoding="utf-8") as file:
        return json.load(file)


class Check:
    """Trainings and views; `work` is a folder for what they leave."""

    def __init__(self, options, tool, work):
        self.options = options
        self.tool = tool
        self.work = work
        images, self.camera, self.poses = options.images, options.camera, options.poses
        if not images:
            flight = self.path("flight")
            call([tool, "simulate", "--preset", options.preset, "--seed", "1", "--duration", str(options.duration),
                  "--images", "png", "--quiet", "--out", flight], "simulating %g s of a flight" % options.duration)
            images = os.path.join(flight, "images")
            self.camera, self.poses = os.path.join(flight, "camera.yaml"), os.path.join(flight, "groundtruth.txt")
        self.input = ["--images", images, "--camera", self.camera, "--poses", self.poses, "--holdout", "20", "--quiet"]

    def path(self, name):
        return os.path.join(self.work, name)

    def train(self, device, steps, name):
        """Trains the model `name`; a CPU's training and a card's see the same rays."""
        call([self.tool, "nerf", "train", *self.input, "--steps", str(steps), "--checkpoint-s", "0", "--scale",
              str(self.options.scale), "--device", device, "--out", self.path(name + ".dvn"), "--json",
              self.path(name + ".json")], "training %d steps on %s" % (steps, device))
        seen = read_json(self.path(name + ".json"))
        seen["train_s"] = seen["train_wall_s"] - seen["setup_s"]
        return seen

    def evaluate(self, device, name, share):
        """Looks at held-out images, at a share of the size that was trained on."""
        out = self.path("eval.json")
        call([self.tool, "nerf", "eval", *self.input, "--views", "40", "--scale", str(share * self.options.scale),
              "--device", device, "--model", self.path(name + ".dvn"), "--json", out],
             "looking at held-out images at %g of their size on %s" % (share, device))
        return read_json(out)

    def curve(self, device, name):
        """Seconds of training and what they give, for longer and longer trainings."""
        points = []
        for steps in sorted({max(1, self.options.steps // share) for share in SHARES}):
            trained = self.train(device, steps, name)
            point = {"steps": steps, "psnr_db": self.evaluate(device, name, 1.0)["psnr_db"]}
            for key in ("train_s", "samples_per_s", "rays_per_s", "peak_device_mb"):
                point[key] = trained[key]
            points.append(point)
        return points

    def render(self, device, name):
        """Names of the pictures of a few views and their depths."""
        out = self.path("views-" + device.replace(":", ""))
        call([self.tool, "nerf", "render", "--model", self.path(name + ".dvn"), "--camera", self.camera, "--trajectory",
              self.poses, "--fps", "0.2", "--scale", str(self.options.scale), "--depth", "--quiet", "--device", device,
              "--out", out], "rendering on %s" % device)
        return sorted(glob.glob(os.path.join(out, "*.png")))

    def agreement(self, name):
        """How many pixels of both devices' views are the same."""
        # The CPU's go elsewhere, for a check of the CPU against itself.
        theirs = self.render(CPU, name)
        os.rename(self.path("views-cpu"), self.path("expected"))
        theirs = [path.replace("views-cpu", "expected") for path in theirs]
        return compare_pictures(theirs, self.render(self.options.device, name))


def compare_pictures(expected, found):
    """The share of pixels that are within 1/255 of white, and within 0.5 % of depth."""
    names = [[os.path.basename(path) for path in paths] for paths in (expected, found)]
    if names[0] != names[1] or not expected:
        raise CheckError("the devices rendered different views: %s and %s" % tuple(names))
    same, total = {"image": 0, "depth": 0}, {"image": 0, "depth": 0}
    for paths in zip(expected, found):
        a, b = (cv2.imread(path, cv2.IMREAD_UNCHANGED).astype(float) for path in paths)
        if a.shape != b.shape:
            raise CheckError("%s and %s are of different sizes" % paths)
        kind = "depth" if paths[0].endswith(".depth.png") else "image"
        # Depth is in whole millimetres, so that 0.5 % of less than 0.3 m can't be told.
        bound = np.maximum(1.5, 0.005 * a) if kind == "depth" else 1
        same[kind] += int(np.count_nonzero(np.abs(a - b) <= bound))
        total[kind] += a.size
    return {kind: {"values": total[kind], "same_share": same[kind] / max(1, total[kind])} for kind in same}


def seconds_to(points, level_db):
    """Between the two trainings on either side of the level; null where none reaches it."""
    before = None
    for point in points:
        if point["psnr_db"] >= level_db:
            if before is None:
                return point["train_s"]
            share = (level_db - before["psnr_db"]) / (point["psnr_db"] - before["psnr_db"])
            return before["train_s"] + share * (point["train_s"] - before["train_s"])
        before = point
    return None


def find_library(build):
    """For which kinds of cards the library was compiled, as nvcc was told; none in a build without CUDA."""
    with open(os.path.join(build, "compile_commands.json"), encoding="utf-8") as file:
        commands = [entry["command"] for entry in json.load(file) if entry["file"].endswith(".cu")]
    kinds = set()
    for code in re.findall(r",code=\[?([\w,]+)", " ".join(commands)):
        kinds.update(code.split(","))
    return sorted(kinds)


def find_tests(folder):
    """What the test programs left there: how many ran, and which of them failed."""
    tests = {}
    for path in sorted(glob.glob(os.path.join(folder, "*.xml"))):
        root = xml.etree.ElementTree.parse(path).getroot()
        failed = ["%s.%s" % (case.get("classname"), case.get("name")) for case in root.iter("testcase")
                  if case.find("failure") is not None]
        name = os.path.splitext(os.path.basename(path))[0]
        tests[name] = {"run": int(root.get("tests")), "failed": failed}
    return tests


def measure(options, tool, work, result):
    """Fills in what was seen as it comes."""
    check = Check(options, tool, work)
    result["device"] = options.device
    result["curve"] = check.curve(options.device, "card")
    result["seconds_to_db"] = {str(level): seconds_to(result["curve"], level) for level in LEVELS_DB}
    for share in (0.5, 1.0):
        result["render_ms_median_at_%g" % share] = check.evaluate(options.device, "card", share)["render_ms_median"]
    result["agreement"] = check.agreement("card")
    cpu = check.train(CPU, options.steps, "cpu")
    result["cpu"] = {key: cpu[key] for key in ("train_s", "samples_per_s", "rays_per_s")}
    result["cpu"]["psnr_db"] = check.evaluate(CPU, "cpu", 1.0)["psnr_db"]
    result["psnr_gap_db"] = result["curve"][-1]["psnr_db"] - result["cpu"]["psnr_db"]


def read_options():
    parser = argparse.ArgumentParser(description=__doc__)
    for name in ("images", "camera", "poses", "out", "test-results"):
        parser.add_argument("--" + name, default="")
    parser.add_argument("--build", required=True)
    parser.add_argument("--device", default="cuda:0")
    parser.add_argument("--tests", default="passed", choices=("passed", "failed"))
    parser.add_argument("--steps", type=int, default=3000)
    parser.add_argument("--scale", type=float, default=1)
    parser.add_argument("--preset", default="hall")
    parser.add_argument("--duration", type=float, default=60)
    options = parser.parse_args()
    given = [bool(value) for value in (options.images, options.camera, options.poses)]
    if any(given) and not all(given):
        parser.error("--images, --camera and --poses: expected all of them, or none")
    if options.steps < 1:
        parser.error("--steps %d: expected at least 1" % options.steps)
    return options


def main():
    options = read_options()
    tool = os.path.join(options.build, "bin", "deja_view")
    result = {"compiled_for": find_library(options.build), "tests": options.tests}
    if options.test_results:
        result["test_programs"] = find_tests(options.test_results)
    code = 0 if options.tests == "passed" else 1
    with tempfile.TemporaryDirectory() as work:
        try:
            call([tool, "nerf", "info", "--json", os.path.join(work, "info.json")], "looking for cards")
            result["devices"] = read_json(os.path.join(work, "info.json"))["devices"]
            if result["devices"]["cards"] or options.device == CPU:
                measure(options, tool, work, result)
            else:
                code = code or NO_CARD
        except CheckError as error:
            result["problem"] = str(error)
            code = 1
    text = json.dumps(result, indent=2)
    print(text)
    if options.out:
        with open(options.out + ".part", "w", encoding="utf-8") as file:
            file.write(text + "\n")
        os.replace(options.out + ".part", options.out)
    return code


if __name__ == "__main__":
    sys.exit(main())

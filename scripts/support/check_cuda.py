#!/usr/bin/env python3
"""The measuring part of scripts/check_cuda: trains and renders on a card and on the CPU, and prints one JSON."""
import argparse
import glob
import json
import os
import subprocess
import sys
import tempfile

import cv2
import numpy as np

NO_CARD = 3
LEVELS_DB = (25, 27, 28)


def call(arguments, what):
    """Runs the tool; its messages go to our error stream."""
    print("== %s" % what, file=sys.stderr, flush=True)
    result = subprocess.run(arguments, stdout=subprocess.DEVNULL, check=False)
    if result.returncode != 0:
        sys.exit("check_cuda: %s failed with exit code %d" % (what, result.returncode))


def figures(path):
    with open(path, encoding="utf-8") as file:
        return json.load(file)


class Check:
    def __init__(self, options, work):
        self.options = options
        self.work = work
        if options.images:
            self.input = ["--images", options.images, "--camera", options.camera, "--poses", options.poses]
            self.camera, self.poses = options.camera, options.poses
        else:
            flight = os.path.join(work, "flight")
            call([options.tool, "simulate", "--preset", "hall", "--seed", "1", "--duration", "60", "--images", "png",
                  "--quiet", "--out", flight], "simulating a hall")
            self.camera, self.poses = os.path.join(flight, "camera.yaml"), os.path.join(flight, "groundtruth.txt")
            self.input = ["--images", os.path.join(flight, "images"), "--camera", self.camera, "--poses", self.poses]

    def path(self, name):
        return os.path.join(self.work, name)

    def train(self, device, steps, name):
        call([self.options.tool, "nerf", "train", *self.input, "--holdout", "20", "--steps", str(steps), "--quiet",
              "--checkpoint-s", "0", "--device", device, "--out", self.path(name + ".dvn"),
              "--json", self.path(name + ".json")], "training %d steps on %s" % (steps, device))
        return figures(self.path(name + ".json"))

    def evaluate(self, device, name, scale):
        out = self.path("%s-%s-eval.json" % (name, device.replace(":", "")))
        call([self.options.tool, "nerf", "eval", *self.input, "--holdout", "20", "--views", "40", "--quiet",
              "--scale", str(scale), "--device", device, "--model", self.path(name + ".dvn"), "--json", out],
             "looking at held-out images at %g of their size on %s" % (scale, device))
        return figures(out)

    def curve(self, device, name):
        """Seconds of training and what they give, for longer and longer trainings."""
        points = []
        for share in (32, 16, 8, 4, 2, 1):
            steps = max(1, self.options.steps // share)
            trained = self.train(device, steps, name)
            seen = self.evaluate(device, name, 1.0)
            points.append({"steps": steps, "train_s": trained["train_wall_s"] - trained["setup_s"],
                           "psnr_db": seen["psnr_db"], "samples_per_s": trained["samples_per_s"],
                           "rays_per_s": trained["rays_per_s"], "peak_device_mb": trained["peak_device_mb"]})
        return points

    def agreement(self, name):
        """How many pixels of both devices' views are the same: 1/255 of white, 0.5 % of depth."""
        pictures = {}
        for device in ("cpu", self.options.device):
            out = self.path("views-" + device.replace(":", ""))
            call([self.options.tool, "nerf", "render", "--model", self.path(name + ".dvn"), "--camera", self.camera,
                  "--trajectory", self.poses, "--fps", "0.2", "--depth", "--quiet", "--device", device, "--out", out],
                 "rendering on %s" % device)
            pictures[device] = sorted(glob.glob(os.path.join(out, "*.png")))
        same, total = 0, 0
        for ours, theirs in zip(*pictures.values()):
            a, b = (cv2.imread(path, cv2.IMREAD_UNCHANGED).astype(float) for path in (ours, theirs))
            is_depth = ours.endswith(".depth.png")
            # Depth is in whole millimetres.
            bound = np.maximum(1.5, 0.005 * a) if is_depth else 1
            same += int(np.count_nonzero(np.abs(a - b) <= bound))
            total += a.size
        return {"pixels": total, "same_share": same / max(1, total)}


def seconds_to(points, level_db):
    """Between the two trainings on either side of the level; null where none reaches it."""
    before = {"train_s": 0.0, "psnr_db": 0.0}
    for point in points:
        if point["psnr_db"] >= level_db:
            if before["train_s"] == 0:
                return point["train_s"]
            share = (level_db - before["psnr_db"]) / (point["psnr_db"] - before["psnr_db"])
            return before["train_s"] + share * (point["train_s"] - before["train_s"])
        before = point
    return None


def find_card(options, work):
    """What `nerf info` says; of the smallest model that there is."""
    call([options.tool, "simulate", "--preset", "small", "--seed", "1", "--duration", "5", "--images", "png", "--quiet",
          "--out", os.path.join(work, "small")], "simulating a small hall")
    small = os.path.join(work, "small")
    model = os.path.join(work, "small.dvn")
    call([options.tool, "nerf", "train", "--images", os.path.join(small, "images"), "--camera",
          os.path.join(small, "camera.yaml"), "--poses", os.path.join(small, "groundtruth.txt"), "--scale", "0.25",
          "--every", "5", "--steps", "2", "--device", "cpu", "--quiet", "--out", model], "making a model to look at")
    out = os.path.join(work, "info.json")
    call([options.tool, "nerf", "info", model, "--json", out], "looking for cards")
    return figures(out)["devices"]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    for name in ("tool", "tests", "device", "images", "camera", "poses", "out"):
        parser.add_argument("--" + name, default="")
    parser.add_argument("--steps", type=int, default=3000)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as work:
        result = {"tests": options.tests}
        result["devices"] = find_card(options, work)
        has_card = bool(result["devices"]["cards"]) or options.device == "cpu"
        if has_card:
            check = Check(options, work)
            points = check.curve(options.device, "card")
            cpu = check.train("cpu", options.steps, "cpu")
            result["device"] = options.device
            result["curve"] = points
            result["seconds_to_db"] = {str(level): seconds_to(points, level) for level in LEVELS_DB}
            result["cpu"] = {"train_s": cpu["train_wall_s"] - cpu["setup_s"], "samples_per_s": cpu["samples_per_s"],
                             "psnr_db": check.evaluate("cpu", "cpu", 1.0)["psnr_db"]}
            result["psnr_gap_db"] = points[-1]["psnr_db"] - result["cpu"]["psnr_db"]
            result["agreement"] = check.agreement("card")
            for scale in (0.5, 1.0):
                seen = check.evaluate(options.device, "card", scale)
                result["render_ms_median_at_%g" % scale] = seen["render_ms_median"]
    text = json.dumps(result, indent=2)
    print(text)
    if options.out:
        with open(options.out + ".part", "w", encoding="utf-8") as file:
            file.write(text + "\n")
        os.replace(options.out + ".part", options.out)
    if options.tests != "passed":
        return 1
    return 0 if has_card else NO_CARD


if __name__ == "__main__":
    sys.exit(main())

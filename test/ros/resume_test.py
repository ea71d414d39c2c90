#!/usr/bin/python3
"""resume_test.py TOOL FLIGHT PRESET: what is killed goes on where it was, leaves nothing behind, and gives the same;
two processes don't write one output. FLIGHT is the directory of a simulated flight with images and models/room.dvn."""

import json
import os
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

TOOL, FLIGHT, PRESET = sys.argv[1:4]
BAG = os.path.join(FLIGHT, "flight.bag")
RENDER = ["views", "render", "--bag", BAG, "--camera", os.path.join(FLIGHT, "camera.yaml"), "--poses",
          os.path.join(FLIGHT, "groundtruth.txt"), "--align-to", "off", "--model",
          os.path.join(FLIGHT, "models", "room.dvn"), "--preset", PRESET, "--sources", "images", "--threads", "1",
          "--quiet"]
TRAIN = ["nerf", "train", "--images", os.path.join(FLIGHT, "images"), "--camera",
         os.path.join(FLIGHT, "camera.yaml"), "--poses", os.path.join(FLIGHT, "groundtruth.txt"), "--holdout", "0",
         "--scale", "0.25", "--no-sparse-points", "--set", "field.geometry.log2_table_size=12", "--set",
         "field.appearance.log2_table_size=12", "--set", "target_samples=8192", "--quiet"]


def read(path):
    with open(path, "rb") as file:
        return file.read()


def wait_for(condition, timeout_s=120):
    end = time.monotonic() + timeout_s
    while not condition():
        if time.monotonic() > end:
            raise AssertionError("waited in vain")
        time.sleep(0.002)


class ResumeTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def path(self, name):
        return os.path.join(self.folder, name)

    def run_tool(self, *arguments, code=0):
        result = subprocess.run([TOOL, *arguments], capture_output=True, text=True, check=False)
        self.assertEqual(result.returncode, code, result.stderr)
        return result.stderr

    def start(self, *arguments):
        run = subprocess.Popen([TOOL, *arguments], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(run.wait)
        self.addCleanup(run.kill)
        return run

    def kill(self, run):
        run.send_signal(signal.SIGKILL)
        self.assertEqual(run.wait(), -signal.SIGKILL)

    def finished(self, out):
        """Images whose views are done."""
        work = out + ".work"
        return [n for n in os.listdir(work) if n.endswith(".views")] if os.path.isdir(work) else []

    def test_render(self):
        whole, out = self.path("whole.bag"), self.path("out.bag")
        self.run_tool(*RENDER, "--out", whole)
        command = [*RENDER, "--out", out, "--json", self.path("out.json")]
        for count in (2, 4):
            run = self.start(*command)
            wait_for(lambda: len(self.finished(out)) >= count)
            self.kill(run)
        done = len(self.finished(out))
        self.run_tool(*command)
        self.assertEqual(read(out), read(whole))
        with open(self.path("out.json"), encoding="utf-8") as file:
            report = json.load(file)
        self.assertEqual(report["resumed"], done)
        self.assertGreater(report["sources"], done)
        self.assertEqual(sorted(os.listdir(self.folder)), ["out.bag", "out.json", "whole.bag"])

    def test_merge(self):
        parts = [self.path(f"part{i}.bag") for i in range(2)]
        for i, part in enumerate(parts):
            self.run_tool(*RENDER, "--shard", f"{i}/2", "--out", part)
        whole, out = self.path("whole.bag"), self.path("out.bag")
        self.run_tool("views", "merge", "--bag", BAG, *parts, "--out", whole)
        before = sorted(os.listdir(self.folder))
        # Ended by the system in the midst of writing.
        limit = os.path.getsize(whole) // 2
        killed = subprocess.run([TOOL, "views", "merge", "--bag", BAG, *parts, "--out", out], capture_output=True,
                                check=False,
                                preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)))
        self.assertEqual(killed.returncode, -signal.SIGXFSZ)
        self.assertFalse(os.path.exists(out))
        self.assertNotEqual(sorted(os.listdir(self.folder)), before)
        self.run_tool("views", "merge", "--bag", BAG, *parts, "--out", out)
        self.assertEqual(read(out), read(whole))
        self.assertEqual(sorted(os.listdir(self.folder)), sorted(before + ["out.bag"]))

    def test_two_processes_on_one_output(self):
        out = self.path("out.bag")
        first = self.start(*RENDER, "--out", out)
        wait_for(lambda: self.finished(out))
        error = self.run_tool(*RENDER, "--out", out, code=1)
        self.assertIn(out + ": another process writes here", error)
        self.assertIn(str(first.pid), error)
        self.assertIsNone(first.poll())
        self.assertEqual(first.wait(), 0)
        self.run_tool(*RENDER, "--out", self.path("alone.bag"))
        self.assertEqual(read(out), read(self.path("alone.bag")))

    def test_train(self):
        model = self.path("room.dvn")
        run = self.start(*TRAIN, "--steps", "100000", "--checkpoint-s", "0.1", "--out", model)
        wait_for(lambda: os.path.exists(model))
        time.sleep(0.5)
        self.kill(run)
        size = os.path.getsize(model)
        ends = []
        for name in ("one", "two"):
            copy = self.path(name + ".dvn")
            shutil.copy(model, copy)
            figures = self.path(name + ".json")
            self.run_tool(*TRAIN, "--resume", copy, "--steps", "40", "--out", copy, "--json", figures)
            with open(figures, encoding="utf-8") as file:
                report = json.load(file)
            self.assertFalse(report["interrupted"])
            self.assertGreater(report["psnr_db"], 12)
            ends.append(read(copy))
        self.assertEqual(ends[0], ends[1])
        self.assertEqual(len(ends[0]), size)
        # It is complete now.
        error = self.run_tool(*TRAIN, "--resume", copy, "--steps", "40", "--out", copy, code=1)
        self.assertIn("nothing is left to resume", error)
        self.run_tool(*TRAIN, "--steps", "5", "--out", model)
        self.assertEqual(sorted(os.listdir(self.folder)), ["one.dvn", "one.json", "room.dvn", "two.dvn", "two.json"])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])

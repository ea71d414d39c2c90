#!/usr/bin/python3
"""Checks what scripts/render_shard and scripts/render_sub_map run for each process, and that a process that was killed
can simply be run again: with a program in deja_view's place that writes down its arguments."""

import os
import stat
import subprocess
import tempfile
import unittest

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..")

# Writes --out in halves; "killed" between them while the file "kill_<command>" is beside it.
FAKE = """#!/usr/bin/python3
import os, sys
here = os.path.dirname(os.path.abspath(__file__))
with open(os.path.join(here, "calls"), "a", encoding="utf-8") as file:
    file.write(" ".join(sys.argv[1:]) + "\\n")
out = sys.argv[sys.argv.index("--out") + 1]
with open(out, "w", encoding="utf-8") as file:
    file.write("half")
if os.path.exists(os.path.join(here, "kill_" + sys.argv[1])):
    if sys.argv[1] == "views":
        os.remove(out)  # bags get their names when they are whole
    os.kill(os.getpid(), 9)
"""


class ShareTest(unittest.TestCase):
    def setUp(self):
        directory = tempfile.TemporaryDirectory()
        self.addCleanup(directory.cleanup)
        self.path = directory.name
        program = os.path.join(self.path, "deja_view")
        with open(program, "w", encoding="utf-8") as file:
            file.write(FAKE)
        os.chmod(program, stat.S_IRWXU)
        os.mkdir(os.path.join(self.path, "parts"))

    def run_script(self, name, arguments, environment):
        clean = {k: v for k, v in os.environ.items() if not k.startswith(("OMPI_", "PMI_", "SLURM_"))}
        clean["PATH"] = self.path + ":" + clean["PATH"]
        clean.update(environment)
        script = os.path.join(ROOT, "scripts", name)
        return subprocess.run(
            [script, "parts", *arguments], cwd=self.path, env=clean, capture_output=True, text=True, check=False
        )

    def calls(self):
        try:
            with open(os.path.join(self.path, "calls"), encoding="utf-8") as file:
                return file.read().splitlines()
        except FileNotFoundError:
            return []

    def mark(self, name):
        with open(os.path.join(self.path, name), "w", encoding="utf-8"):
            pass

    def unmark(self, name):
        os.remove(os.path.join(self.path, name))

    def test_shares_of_mpi_and_slurm(self):
        mpi = {"OMPI_COMM_WORLD_RANK": "1", "OMPI_COMM_WORLD_SIZE": "3"}
        self.assertEqual(self.run_script("render_shard", ["--bag", "a.bag"], mpi).returncode, 0)
        slurm = {"SLURM_ARRAY_TASK_ID": "7", "SLURM_ARRAY_TASK_MIN": "5", "SLURM_ARRAY_TASK_COUNT": "4"}
        self.assertEqual(self.run_script("render_shard", ["--bag", "a.bag"], slurm).returncode, 0)
        self.assertEqual(
            self.calls(),
            [
                "views render --bag a.bag --quiet --shard 1/3 --out parts/part-1-of-3.bag",
                "views render --bag a.bag --quiet --shard 2/4 --out parts/part-2-of-4.bag",
            ],
        )

    SUB_MAP = ["--images", "an image", "--", "--bag", "a.bag"]
    TRAIN = "nerf train --images an image --quiet --shard 1/2 --out parts/sub-map-1-of-2.dvn.unfinished"
    RENDER = (
        "views render --bag a.bag --quiet --model parts/sub-map-1-of-2.dvn --out parts/part-1-of-2.bag"
    )
    PROCESS = {"OMPI_COMM_WORLD_RANK": "1", "OMPI_COMM_WORLD_SIZE": "2"}

    def test_trains_and_renders_a_sub_map_once(self):
        for _ in range(2):
            self.assertEqual(self.run_script("render_sub_map", self.SUB_MAP, self.PROCESS).returncode, 0)
            self.assertEqual(self.calls(), [self.TRAIN, self.RENDER])
        self.assertEqual(sorted(os.listdir(self.path + "/parts")), ["part-1-of-2.bag", "sub-map-1-of-2.dvn"])

    def test_a_killed_training_begins_anew(self):
        self.mark("kill_nerf")
        self.assertNotEqual(self.run_script("render_sub_map", self.SUB_MAP, self.PROCESS).returncode, 0)
        self.assertEqual(self.calls(), [self.TRAIN])
        self.assertFalse(os.path.exists(self.path + "/parts/sub-map-1-of-2.dvn"))
        self.unmark("kill_nerf")
        self.assertEqual(self.run_script("render_sub_map", self.SUB_MAP, self.PROCESS).returncode, 0)
        self.assertEqual(self.calls(), [self.TRAIN, self.TRAIN, self.RENDER])

    def test_a_killed_rendering_keeps_its_field(self):
        self.mark("kill_views")
        self.assertNotEqual(self.run_script("render_sub_map", self.SUB_MAP, self.PROCESS).returncode, 0)
        self.unmark("kill_views")
        self.assertEqual(self.run_script("render_sub_map", self.SUB_MAP, self.PROCESS).returncode, 0)
        self.assertEqual(self.calls(), [self.TRAIN, self.RENDER, self.RENDER])

    def test_says_what_it_expected(self):
        missing = self.run_script("render_sub_map", ["--images", "an image"], self.PROCESS)
        self.assertNotEqual(missing.returncode, 0)
        self.assertIn("expected --", missing.stderr)
        alone = self.run_script("render_sub_map", self.SUB_MAP, {})
        self.assertNotEqual(alone.returncode, 0)
        self.assertIn("one process only", alone.stderr)
        self.assertEqual(self.calls(), [])


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/python3
"""Save, kill, load, go on: a second flight is recognised in the map of the first. And what the node says when it can't
start or hears nothing."""

import csv
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest

import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from nav_msgs.msg import Path
from roslib.packages import find_node
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import CompressedImage

from deja_view.srv import NamedMap
from flight import Flight, NodeOutputs, Recorder, wait_until

SPEED = 2.0


class PersistenceTest(unittest.TestCase):
    def setUp(self):
        self.directory = tempfile.mkdtemp(prefix="deja_view_maps")
        self.process = None

    def tearDown(self):
        if self.process is not None and self.process.poll() is None:
            self.process.kill()
            self.process.wait()
        shutil.rmtree(self.directory)

    def start(self, flight, load="", output="", more=()):
        self.process = subprocess.Popen(
            [
                # As roslaunch finds it; rosrun passes over a build directory within the package.
                find_node("deja_view", "loop_fusion_node")[0],
                "__name:=loop_fusion",
                "_config_file:=" + os.path.join(flight, "camera.yaml"),
                "_vocabulary_file:=" + rospy.get_param("~vocabulary"),
                "_map_directory:=" + os.path.join(self.directory, "maps"),
                "_load_map_at_start:=" + load,
                "_output_directory:=" + output,
                *more,
            ]
        )

    def kill(self):
        """As a power cut would."""
        self.process.kill()
        self.process.wait()

    def call(self, service, name):
        rospy.wait_for_service("/loop_fusion/" + service, 20.0)
        return rospy.ServiceProxy("/loop_fusion/" + service, NamedMap)(name)

    def call_by_hand(self, service, name):
        """As rosservice does, which finds the service's type by its name."""
        done = subprocess.run(
            ["rosservice", "call", "/loop_fusion/" + service, name], capture_output=True, text=True, timeout=60, check=False
        )
        return done.stdout + done.stderr

    def refusal(self, node, *arguments):
        """What a node that can't start says on standard error."""
        done = subprocess.run(
            [find_node("deja_view", node)[0], "__name:=refused", *arguments],
            stderr=subprocess.PIPE,
            timeout=60,
            check=False,
        )
        self.assertEqual(done.returncode, 1)
        return done.stderr.decode()

    def test_startup_errors_are_told(self):
        camera = "_config_file:=" + os.path.join(rospy.get_param("~flight"), "camera.yaml")
        vocabulary = "_vocabulary_file:=" + rospy.get_param("~vocabulary")
        for told, node, arguments in (
            ("config_file", "loop_fusion_node", []),
            ("/nowhere.yaml", "loop_fusion_node", ["_config_file:=/nowhere.yaml", vocabulary]),
            ("/nowhere.dvv", "loop_fusion_node", [camera, "_vocabulary_file:=/nowhere.dvv"]),
            ("nomap", "loop_fusion_node", [camera, vocabulary, "_load_map_at_start:=nomap"]),
            ("/dev/null/out: files can't be written there", "loop_fusion_node",
             [camera, vocabulary, "_output_directory:=/dev/null/out"]),
            ("/nowhere.yaml", "nerf_render_node", ["_config_file:=/nowhere.yaml"]),
            ("nomodel", "nerf_render_node",
             [camera, "_model_directory:=" + self.directory, "_model:=nomodel"]),
        ):
            rospy.delete_param("/refused") if rospy.has_param("/refused") else None
            self.assertIn(told, self.refusal(node, *arguments))

    def test_topics_that_are_silent_are_told(self):
        said = Recorder({"/rosout": Log, "/diagnostics": DiagnosticArray})
        compressed = rospy.Publisher("/compressed", CompressedImage, queue_size=1)
        topics = ["_topics/image:=/compressed", "_topics/odometry:=/nobody"]
        self.start(rospy.get_param("~flight"), more=topics)

        def is_told(text):
            return any(m.name == "/loop_fusion" and m.level == Log.WARN and text in m.msg for m in said["/rosout"])

        for text in (
            "no message on /nobody for 3 s: nobody publishes it",
            "no message on /compressed for 3 s: it is published as sensor_msgs/CompressedImage, "
            "expected sensor_msgs/Image",
        ):
            wait_until(lambda text=text: is_told(text), 20.0, text)

        def is_diagnosed():
            statuses = [s for m in said["/diagnostics"] for s in m.status if s.name.startswith("loop_fusion")]
            return any(s.level == DiagnosticStatus.WARN and "no messages on /nobody" in s.message for s in statuses)

        wait_until(is_diagnosed, 10.0, "the diagnostics")
        compressed.unregister()

    def test_save_kill_load_go_on(self):
        first, second = rospy.get_param("~flight"), rospy.get_param("~second_flight")
        flight = Flight(first)
        outputs = NodeOutputs()
        self.start(first)
        flight.wait_for_node()
        flight.play(SPEED)
        outputs.wait_for_keyframe(flight.keyframe_stamps()[-1])
        saved = self.call("save_map", "hall")
        self.assertTrue(saved.success, saved.message)
        self.assertIn("success: True", self.call_by_hand("save_map", "hall"))
        for name in ("", "..", "../hall", "/tmp/hall", "a/b", ".hall"):
            self.assertFalse(self.call("save_map", name).success, name)
        self.assertFalse(self.call("load_map", "nowhere").success)
        for name, make, told in (("folder", os.makedirs, "is a directory"), ("pipe", os.mkfifo, "is a pipe")):
            os.makedirs(os.path.join(self.directory, "maps", name), exist_ok=True)
            make(os.path.join(self.directory, "maps", name, "map.dvm"))
            refused = self.call("load_map", name)
            self.assertFalse(refused.success, name)
            self.assertIn(told, refused.message)
            shutil.rmtree(os.path.join(self.directory, "maps", name))
        refused = self.call("load_map", "hall")
        self.assertFalse(refused.success)
        self.assertIn("load a map before the first one", refused.message)
        self.assertEqual(os.listdir(os.path.join(self.directory, "maps")), ["hall"])
        self.kill()
        keyframes = len(flight.keyframe_stamps())
        for publisher in flight.publishers.values():
            publisher.unregister()

        flight = Flight(second)
        outputs = NodeOutputs({"/pose_graph/base_path": Path})
        results = os.path.join(self.directory, "results")
        self.start(second, load="hall", output=results)
        flight.wait_for_node()
        flight.play(SPEED)
        outputs.wait_for_keyframe(flight.keyframe_stamps()[-1])
        across = [l for l in outputs.accepted() if l.index_old < keyframes <= l.index_current]
        self.assertGreater(len(across), 5)
        wait_until(lambda: outputs["/pose_graph/base_path"], 5.0, "the loaded map's path")
        self.assertEqual(len(outputs["/pose_graph/base_path"][-1].poses), keyframes)
        self.assertLess(flight.ape(outputs[NodeOutputs.PATH][-1]), 0.1)

        self.process.send_signal(signal.SIGINT)
        self.assertEqual(self.process.wait(30), 0)
        with open(os.path.join(results, "trajectory.txt"), encoding="utf-8") as file:
            lines = [line for line in file if not line.startswith("#")]
        self.assertEqual(len(lines), len(flight.keyframe_stamps()))
        # A join tells of many loops at once, and each reaches the topic.
        with open(os.path.join(results, "loops.csv"), encoding="utf-8") as file:
            rows = [row for row in csv.DictReader(file) if row["reason"] != "withdrawn"]
        told = [loop for loop in outputs[NodeOutputs.LOOPS] if loop.reason != "withdrawn"]
        self.assertEqual(len(told), len(rows))


if __name__ == "__main__":
    rospy.init_node("persistence_test")
    rostest.rosrun("deja_view", "persistence_test", PersistenceTest, sys.argv)

#!/usr/bin/python3
"""record_vins_test.py DEVEL_SPACE CAMERA: scripts/reproduce_paper starts VINS-Mono over a bag of images and records what
it publishes. In VINS-Mono's place are packages of the same names whose nodes answer each image."""

import importlib.machinery
import importlib.util
import os
import stat
import sys
import tempfile
import types
import unittest

import rosbag
import rospy
from sensor_msgs.msg import Image

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
IMAGES = 80

PACKAGE = """<package format="2"><name>{name}</name><version>0.0.1</version><description>-</description>
<maintainer email="a@b.invalid">a</maintainer><license>BSD</license></package>
"""
TRACKER = """#!/usr/bin/python3
import rospy
rospy.init_node("feature_tracker")
rospy.spin()
"""
ESTIMATOR = """#!/usr/bin/python3
import rospy
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Image, PointCloud
rospy.init_node("vins_estimator")
topics = {name: rospy.Publisher("/vins_estimator/" + name, PointCloud if name == "keyframe_point" else Odometry,
                                queue_size=10)
          for name in ("keyframe_pose", "keyframe_point", "extrinsic", "odometry")}
def answer(image):
    for publisher in topics.values():
        message = publisher.data_class()
        message.header.stamp = image.header.stamp
        publisher.publish(message)
rospy.Subscriber("/cam0/image_raw", Image, answer)
rospy.spin()
"""


def load_script():
    loader = importlib.machinery.SourceFileLoader("reproduce_paper", os.path.join(ROOT, "scripts", "reproduce_paper"))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("reproduce_paper", loader))
    loader.exec_module(module)
    return module


class RecordVins(unittest.TestCase):
    devel = ""
    camera = ""

    def setUp(self):
        self.script = load_script()
        directory = tempfile.TemporaryDirectory()
        self.addCleanup(directory.cleanup)
        self.path = lambda *names: os.path.join(directory.name, *names)
        self.write("build/devel/setup.bash", f"source {self.devel}/setup.bash\n"
                   f"export ROS_PACKAGE_PATH={self.path('vins')}:$ROS_PACKAGE_PATH ROS_HOME={self.path('ros')}\n")
        with rosbag.Bag(self.path("images.bag"), "w") as bag:
            for number in range(IMAGES):
                stamp = rospy.Time(100 + number // 10, number % 10 * 100000000)
                image = Image(height=48, width=75, encoding="mono8", step=75, data=bytes(48 * 75))
                image.header.stamp = stamp
                bag.write("/cam0/image_raw", image, stamp)
        self.options = types.SimpleNamespace(out=self.path("out"), build=self.path("build"), camera=self.camera,
                                             bag=self.path("images.bag"), image_topic="/cam0/image_raw")
        os.makedirs(self.path("out"))

    def write(self, name, text):
        os.makedirs(os.path.dirname(self.path(name)), exist_ok=True)
        with open(self.path(name), "w", encoding="utf-8") as file:
            file.write(text)

    def add_node(self, name, code):
        self.write(f"vins/{name}/package.xml", PACKAGE.format(name=name))
        self.write(f"vins/{name}/{name}", code)
        node = self.path("vins", name, name)
        os.chmod(node, os.stat(node).st_mode | stat.S_IXUSR)

    def test_records_what_vins_mono_says(self):
        self.add_node("feature_tracker", TRACKER)
        self.add_node("vins_estimator", ESTIMATOR)
        recorded = self.script.record_vins(self.script.Steps(self.options), self.options)
        self.assertEqual(self.script.missing_vio_topics(self.script.bag_topics(recorded)), [])
        with rosbag.Bag(recorded) as bag:
            # Those from before the nodes were up are missing.
            self.assertGreater(bag.get_message_count("/cam0/image_raw"), IMAGES // 4)
            poses = [message.header.stamp for _, message, _ in bag.read_messages("/vins_estimator/keyframe_pose")]
        self.assertGreater(len(poses), IMAGES // 4)
        self.assertEqual(poses[-1], rospy.Time(107, 900000000))
        self.assertEqual(set(os.listdir(self.path("out"))), {"logs", "vins.bag"})

    def test_missing_vins_mono_is_told(self):
        with self.assertRaisesRegex(self.script.UserError, "is not in this workspace"):
            self.script.record_vins(self.script.Steps(self.options), self.options)


if __name__ == "__main__":
    RecordVins.devel, RecordVins.camera = sys.argv[1:3]
    unittest.main(argv=sys.argv[:1])

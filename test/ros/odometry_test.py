#!/usr/bin/python3
"""Beside an odometry that gives nothing but poses: keyframes and their points are made of the images."""

import sys
import unittest

import rospy
import rostest
from geometry_msgs.msg import PoseStamped, TransformStamped, Vector3
from nav_msgs.msg import Odometry
from tf2_msgs.msg import TFMessage

from flight import IMAGE, ODOMETRY, TYPES, Flight, NodeOutputs, wait_until

SPEED = 1.0
CORRECTED = "/loop_fusion/odometry_corrected"


class OdometryTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.is_tf = rospy.get_param("~poses") == "tf"
        kinds = {IMAGE: TYPES[IMAGE], ODOMETRY: PoseStamped, "/tf": TFMessage}
        cls.flight = Flight(rospy.get_param("~flight"), kinds)
        cls.flight.publishers.pop(ODOMETRY if cls.is_tf else "/tf").unregister()
        cls.outputs = NodeOutputs({CORRECTED: Odometry})
        cls.flight.wait_for_node()
        cls.poses = 0
        cls.flight.play(SPEED, cls.edit)
        last = [m.header.stamp for _, topic, m in cls.flight.messages if topic == ODOMETRY][-1]
        # A keyframe waits for the images after it.
        cls.outputs.wait_for_keyframe(last - rospy.Duration(1.0))

    @classmethod
    def edit(cls, topic, message):
        """Poses as another type than VINS-Mono's; one of them broken."""
        if topic == IMAGE:
            return [(topic, message)]
        cls.poses += 1
        pose = PoseStamped(header=message.header, pose=message.pose.pose)
        if cls.poses == 50:
            pose.pose.orientation.w = float("nan")
        return [("/tf", cls.transform(pose)) if cls.is_tf else (topic, pose)]

    @staticmethod
    def transform(pose):
        link = TransformStamped(header=pose.header, child_frame_id="base_link")
        link.header.frame_id = "odom"
        position = pose.pose.position
        link.transform.translation = Vector3(position.x, position.y, position.z)
        link.transform.rotation = pose.pose.orientation
        return TFMessage([link])

    def test_loops_are_found_and_right(self):
        accepted = self.outputs.accepted()
        self.assertGreater(len(accepted), 20)
        for loop in accepted:
            self.assertLess(self.flight.loop_error(loop), 0.4)

    def test_drift_goes_away(self):
        before = self.flight.ape(self.outputs[NodeOutputs.NO_LOOP_PATH][-1])
        after = self.flight.ape(self.outputs[NodeOutputs.PATH][-1])
        self.assertLess(after, 0.6 * before)

    def test_every_pose_comes_out_corrected(self):
        expected = self.poses - 1
        wait_until(lambda: len(self.outputs[CORRECTED]) == expected, 10.0, f"{expected} corrected poses")
        self.assertEqual(self.outputs[CORRECTED][-1].child_frame_id, "body")


if __name__ == "__main__":
    rospy.init_node("odometry_test")
    rostest.rosrun("deja_view", "odometry_test", OdometryTest, sys.argv)

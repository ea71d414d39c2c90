#!/usr/bin/python3
"""Malformed messages leave the node alive and the result right."""

import copy
import sys
import unittest

import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray

from flight import EXTRINSIC, IMAGE, POINTS, POSE, Flight, NodeOutputs, wait_until

SPEED = 1.0  # of time: the image of 67 MB holds up the others' topic, on a busy machine for more than a second


class Saboteur:
    """Breaks one message in about thirty, each in another way, and remembers what must come of it."""

    def __init__(self):
        self.count = {IMAGE: 0, POINTS: 0, POSE: 0, EXTRINSIC: 0}
        self.lost = set()  # stamps of keyframes that can't be used
        self.done = set()
        self.jumps = 0  # of the calibration

    def __call__(self, topic, message):
        if topic not in self.count:
            return [(topic, message)]
        self.count[topic] += 1
        if topic == EXTRINSIC:
            return self.with_jump(topic, message)
        damage = {
            (POINTS, 20): self.too_few_channels,
            (POINTS, 50): self.too_few_values,
            (POINTS, 80): self.nan_point,
            (POSE, 30): self.nan_pose,
            (POSE, 60): self.stamp_back,
            (POSE, 90): self.stamp_ahead,
            (IMAGE, 35): self.wrong_size,
            (IMAGE, 65): self.unknown_encoding,
            (IMAGE, 95): self.cut_off,
            (IMAGE, 125): self.missing,
            (IMAGE, 155): self.huge,
        }.get((topic, self.count[topic]))
        if damage is None:
            return [(topic, message)]
        self.done.add(damage.__name__)
        return damage(topic, copy.deepcopy(message))

    def too_few_channels(self, topic, message):
        del message.channels[3:]
        return [(topic, message)]

    def too_few_values(self, topic, message):
        message.channels[7].values = message.channels[7].values[:3]
        return [(topic, message)]

    def nan_point(self, topic, message):
        message.points[5].x = float("nan")
        return [(topic, message)]

    def nan_pose(self, topic, message):
        self.lost.add(message.header.stamp)
        message.pose.pose.position.y = float("nan")
        return [(topic, message)]

    def stamp_back(self, topic, message):
        stray = copy.deepcopy(message)
        stray.header.stamp -= rospy.Duration(7.0)
        return [(topic, stray), (topic, message)]

    def stamp_ahead(self, topic, message):
        stray = copy.deepcopy(message)
        stray.header.stamp += rospy.Duration(500.0)
        return [(topic, stray), (topic, message)]

    def wrong_size(self, topic, message):
        self.lost.add(message.header.stamp)
        message.width, message.height, message.step = 64, 48, 64
        message.data = bytes(64 * 48)
        return [(topic, message)]

    def huge(self, topic, message):
        self.lost.add(message.header.stamp)
        message.width = message.height = message.step = 8192
        message.data = bytes(8192 * 8192)
        return [(topic, message)]

    def with_jump(self, topic, message):
        absurd = copy.deepcopy(message)
        absurd.pose.pose.position.x += self.count[topic]
        absurd.pose.pose.orientation = message.pose.pose.orientation.__class__(0, 0, 0, 1)
        self.jumps += 1
        return [(topic, message), (topic, absurd)]

    def unknown_encoding(self, topic, message):
        self.lost.add(message.header.stamp)
        message.encoding = "bayer_fancy12"
        return [(topic, message)]

    def cut_off(self, topic, message):
        self.lost.add(message.header.stamp)
        message.data = message.data[:1000]
        return [(topic, message)]

    def missing(self, topic, message):
        self.lost.add(message.header.stamp)
        return []


class MalformedTest(unittest.TestCase):
    def test_the_node_survives_and_is_right(self):
        flight = Flight(rospy.get_param("~flight"))
        outputs = NodeOutputs({"/diagnostics": DiagnosticArray})
        flight.wait_for_node()
        saboteur = Saboteur()
        flight.play(SPEED, saboteur)
        self.assertEqual(len(saboteur.done), 11)

        stamps = flight.keyframe_stamps()
        outputs.wait_for_keyframe(stamps[-1])
        path = outputs[NodeOutputs.PATH][-1]
        self.assertEqual(
            [p.header.stamp for p in path.poses], [s for s in stamps if s not in saboteur.lost]
        )
        self.assertGreater(len(outputs.accepted()), 10)
        corrected = flight.ape(path)
        received = flight.ape(outputs[NodeOutputs.NO_LOOP_PATH][-1])
        print(f"mean error: received {received:.4f} m, corrected {corrected:.4f} m")
        self.assertLess(corrected, 0.6 * received)

        def values():
            statuses = [s for m in outputs["/diagnostics"] for s in m.status]
            return {v.key: v.value for v in statuses[-1].values} if statuses else {}

        wait_until(lambda: values().get("keyframes") == str(len(path.poses)), 10.0, "diagnostics")
        # Two point clouds, the pose, the encoding, the cut image, the small one and the huge one.
        self.assertEqual(values()["bad messages"], "7")
        self.assertEqual(values()["keyframes refused"], "0")
        self.assertGreater(saboteur.jumps, 0)
        self.assertEqual(values()["dropped: extrinsic_jump"], str(saboteur.jumps))
        self.assertEqual(values()["dropped: stray_stamp"], "2")


if __name__ == "__main__":
    rospy.init_node("malformed_test")
    rostest.rosrun("deja_view", "malformed_test", MalformedTest, sys.argv)

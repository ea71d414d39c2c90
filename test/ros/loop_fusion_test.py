#!/usr/bin/python3
"""loop_fusion_node over a simulated flight: loops are found, the error falls, every output is well-formed."""

import math
import sys
import unittest

import numpy as np
import rospy
import rostest
import tf2_msgs.msg
from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import Odometry, Path
from sensor_msgs.msg import Image, PointCloud
from visualization_msgs.msg import Marker, MarkerArray

from flight import IMAGE, ODOMETRY, POINTS, Flight, NodeOutputs, wait_until

SPEED = 2.0
VINS_OUTPUTS = {
    "/pose_graph/match_points": PointCloud,
    "/pose_graph/base_path": Path,
    "/pose_graph/path_1": Path,
    "/pose_graph/pose_graph": MarkerArray,
    "/pose_graph/match_image": Image,
    "/pose_graph/camera_pose_visual": MarkerArray,
    "/pose_graph/key_odometrys": Marker,
}
OWN_OUTPUTS = {
    "/loop_fusion/odometry_corrected": Odometry,
    "/diagnostics": DiagnosticArray,
    "/tf": tf2_msgs.msg.TFMessage,
}


def numbers(message):
    """All numbers in a message."""
    if isinstance(message, (int, float)):
        yield message
    elif isinstance(message, (list, tuple)):
        for item in message:
            yield from numbers(item)
    elif hasattr(message, "__slots__"):
        for slot in message.__slots__:
            yield from numbers(getattr(message, slot))


class LoopFusionTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.flight = Flight(rospy.get_param("~flight"))
        cls.outputs = NodeOutputs({**VINS_OUTPUTS, **OWN_OUTPUTS})
        cls.flight.wait_for_node()
        cls.flight.play(SPEED)
        cls.outputs.wait_for_keyframe(cls.flight.keyframe_stamps()[-1])

    def test_loops_are_found_and_right(self):
        accepted = self.outputs.accepted()
        self.assertGreater(len(accepted), 10)
        for loop in accepted:
            self.assertLess(loop.index_old, loop.index_current)
            self.assertEqual(loop.reason, "accepted")
            self.assertEqual(loop.header.stamp, loop.stamp_current)
            self.assertGreater(loop.inliers, 0)
            covariance = np.array(loop.relative_pose.covariance).reshape(6, 6)
            np.testing.assert_allclose(covariance, covariance.T, atol=1e-9)
            self.assertGreater(np.linalg.eigvalsh(covariance).min(), 0)
            true = [self.truth(s) for s in (loop.stamp_old, loop.stamp_current)]
            position = loop.relative_pose.pose.position
            found = math.hypot(position.x, position.y, position.z)
            self.assertLess(abs(found - np.linalg.norm(true[1] - true[0])), 0.3)

    def truth(self, stamp):
        flight = self.flight
        return np.array(
            [np.interp(stamp.to_sec(), flight.truth_stamps, flight.truth[:, a]) for a in range(3)]
        )

    def test_error_falls(self):
        corrected = self.flight.ape(self.outputs[NodeOutputs.PATH][-1])
        received = self.flight.ape(self.outputs[NodeOutputs.NO_LOOP_PATH][-1])
        print(f"mean error: received {received:.4f} m, corrected {corrected:.4f} m")
        self.assertLess(corrected, 0.6 * received)

    def test_every_output_has_messages_of_finite_numbers(self):
        silent_without_a_map = {"/pose_graph/base_path"}
        for topic, messages in self.outputs.messages.items():
            self.assertTrue(messages, topic)
            if topic not in ("/diagnostics", "/pose_graph/match_image"):
                for message in (messages[0], messages[-1]):
                    self.assertTrue(all(math.isfinite(n) for n in numbers(message)), topic)
            if topic in silent_without_a_map:
                self.assertEqual(len(messages[-1].poses), 0)

    def test_paths_have_all_keyframes(self):
        stamps = self.flight.keyframe_stamps()
        for topic in (NodeOutputs.PATH, NodeOutputs.NO_LOOP_PATH, "/pose_graph/path_1"):
            path = self.outputs[topic][-1]
            self.assertEqual(path.header.frame_id, "world")
            self.assertEqual([p.header.stamp for p in path.poses], stamps, topic)
        self.assertEqual(len(self.outputs["/pose_graph/key_odometrys"][-1].points), len(stamps))

    def test_match_points_are_tracked_points_of_their_keyframe(self):
        ids = {
            m.header.stamp: {c.values[4] for c in m.channels}
            for _, topic, m in self.flight.messages
            if topic == POINTS
        }
        for message in self.outputs["/pose_graph/match_points"]:
            self.assertEqual(len(message.channels), 1)
            values = message.channels[0].values
            self.assertEqual(len(values), 8)
            self.assertAlmostEqual(np.linalg.norm(values[3:7]), 1.0, places=3)
            points, behind = message.points[:-1], message.points[-1]
            self.assertGreater(len(points), 10)
            self.assertLessEqual({p.z for p in points}, ids[message.header.stamp])
            self.assertEqual([p.z for p in message.points], sorted(p.z for p in message.points))
            self.assertGreater(behind.z, max(i for known in ids.values() for i in known))
            self.assertTrue(all(abs(p.x) < 2 and abs(p.y) < 2 for p in points))

    def test_corrected_odometry_comes_at_the_vios_rate(self):
        sent = [m.header.stamp for _, topic, m in self.flight.messages if topic == ODOMETRY]
        corrected = self.outputs["/loop_fusion/odometry_corrected"]
        wait_until(lambda: len(corrected) == len(sent), 5.0, "all odometry messages")
        self.assertEqual([m.header.stamp for m in corrected], sent)
        self.assertEqual(corrected[0].header.frame_id, "world")

    def test_tf_has_the_drift(self):
        transforms = [t for m in self.outputs["/tf"] for t in m.transforms]
        self.assertEqual(
            {(t.header.frame_id, t.child_frame_id) for t in transforms},
            {("world", "vio"), ("world", "body_corrected")},
        )
        drift = self.outputs[NodeOutputs.DRIFT][-1].transform
        self.assertGreater(abs(drift.translation.x) + abs(drift.translation.y), 1e-4)
        self.assertAlmostEqual(drift.rotation.x, 0.0, places=9)
        self.assertAlmostEqual(drift.rotation.y, 0.0, places=9)

    def test_match_image_shows_two_keyframes(self):
        image = self.outputs["/pose_graph/match_image"][-1]
        source = next(m for _, topic, m in self.flight.messages if topic == IMAGE)
        self.assertEqual((image.encoding, image.width, image.height), ("bgr8", source.width, source.height // 2))
        self.assertEqual(len(image.data), 3 * image.width * image.height)

    def test_pose_graph_markers_are_the_loops(self):
        lines = self.outputs["/pose_graph/pose_graph"][-1].markers[0]
        self.assertEqual(lines.type, Marker.LINE_LIST)
        self.assertGreater(len(lines.points), 20)
        self.assertEqual(len(lines.points) % 2, 0)

    def test_diagnostics_count_everything(self):
        def values():
            statuses = [s for m in self.outputs["/diagnostics"] for s in m.status]
            return {v.key: v.value for v in statuses[-1].values} if statuses else {}

        keyframes = len(self.flight.keyframe_stamps())
        wait_until(lambda: values().get("keyframes") == str(keyframes), 10.0, "the diagnostics")
        self.assertEqual(values()["candidates: accepted"], str(len(self.outputs.accepted())))
        self.assertEqual(values()["queue, dropped"], "0")
        self.assertEqual(values()["bad messages"], "0")


if __name__ == "__main__":
    rospy.init_node("loop_fusion_test")
    rostest.rosrun("deja_view", "loop_fusion_test", LoopFusionTest, sys.argv)

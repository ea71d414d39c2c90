#!/usr/bin/python3
"""A flight is played to the rendering node: its virtual frames belong to real images and look like them."""

import os
import sys
import unittest

import cv2
import numpy as np
import rospy
import rostest

from deja_view.msg import VirtualFrame
from deja_view.srv import NamedMap
from flight import IMAGE, ODOMETRY, Flight, Recorder, wait_until

POSE, POINT = "/vins_estimator/keyframe_pose", "/vins_estimator/keyframe_point"

FRAME = "/virtual_cam0/frame"
VIEWS = 2


class TruePoses:
    """The odometry as it would be without drift, in the frame of the model."""

    def __init__(self, directory):
        truth = np.loadtxt(os.path.join(directory, "groundtruth.txt"))
        self.stamps, self.poses = truth[:, 0], truth[:, 1:]

    def edit(self, topic, message):
        if topic == ODOMETRY:
            i = np.argmin(np.abs(self.stamps - message.header.stamp.to_sec()))
            p, o = message.pose.pose.position, message.pose.pose.orientation
            p.x, p.y, p.z, o.x, o.y, o.z, o.w = self.poses[i]
        return [(topic, message)]


def decode(frame):
    return cv2.imdecode(np.frombuffer(bytes(frame.image), np.uint8), cv2.IMREAD_UNCHANGED)


def median_range(flight):
    """Of the VIO's points from the body that sees them [m]."""
    poses = {m.header.stamp: m.pose.pose.position for _, topic, m in flight.messages if topic == POSE}
    ranges = []
    for _, topic, m in flight.messages:
        if topic == POINT and m.header.stamp in poses:
            p = poses[m.header.stamp]
            ranges += [np.linalg.norm([q.x - p.x, q.y - p.y, q.z - p.z]) for q in m.points]
    return np.median(ranges)


def correlation(a, b):
    a, b = (cv2.GaussianBlur(image.astype(np.float64), (0, 0), 6).ravel() for image in (a, b))
    return np.corrcoef(a, b)[0, 1]


class NerfRenderTest(unittest.TestCase):
    def load(self, name):
        rospy.wait_for_service("/nerf_render/load_model", 20.0)
        return rospy.ServiceProxy("/nerf_render/load_model", NamedMap)(name)

    def test_views_of_a_flight(self):
        flight = Flight(rospy.get_param("~flight"))
        images = {
            m.header.stamp: np.frombuffer(m.data, np.uint8).reshape(m.height, m.width)
            for _, topic, m in flight.messages
            if topic == IMAGE
        }
        frames = Recorder({FRAME: VirtualFrame})[FRAME]
        for name in ("", "../models/room", "/etc/passwd", "nowhere"):
            self.assertFalse(self.load(name).success, name)
        answer = self.load("colmap")
        self.assertFalse(answer.success)
        self.assertIn("without a scale", answer.message)
        answer = self.load(rospy.get_param("~model"))
        self.assertTrue(answer.success, answer.message)

        wait_until(
            lambda: all(flight.publishers[t].get_num_connections() > 0 for t in (IMAGE, ODOMETRY)),
            30.0,
            "the node to subscribe",
        )
        flight.play(2.0, TruePoses(rospy.get_param("~flight")).edit)
        wait_until(lambda: len(frames) >= 4 * VIEWS, 120.0, "virtual frames")
        rospy.sleep(1.0)

        metres = median_range(flight)
        correlations, depths = [], []
        for frame in list(frames):
            self.assertIn(frame.header.stamp, images)
            self.assertEqual(frame.view_count, VIEWS)
            self.assertLess(frame.view_index, VIEWS)
            p = frame.T_C_V.position
            self.assertTrue(0.05 <= np.linalg.norm([p.x, p.y, p.z]) <= 0.1)
            self.assertEqual(frame.descriptor, "brief")
            self.assertEqual(len(frame.descriptors), 32 * len(frame.u))
            self.assertEqual(len(frame.depth), len(frame.u))
            depths += [depth for depth in frame.depth if depth > 0]
            view = decode(frame)
            self.assertEqual(view.shape, (frame.height, frame.width))
            correlations.append(correlation(view, images[frame.header.stamp]))
        # Ten centimetres beside it a camera sees nearly the same.
        self.assertGreater(np.median(correlations), 0.5)
        # In metres, as the VIO's points.
        self.assertTrue(0.7 < np.median(depths) / metres < 1.4, (np.median(depths), metres))
        self.assertEqual(len({frame.settings_hash for frame in frames}), 1)


if __name__ == "__main__":
    rospy.init_node("nerf_render_test")
    rostest.rosrun("deja_view", "nerf_render_test", NerfRenderTest, sys.argv)

"""Plays simulated flights to the node and judges what it publishes."""

import os
import time

import numpy as np
import rosbag
import rospy
from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import Odometry, Path
from sensor_msgs.msg import Image, PointCloud

from deja_view.msg import LoopConstraint, VirtualFrame

IMAGE = "/cam0/image_raw"
POSE = "/vins_estimator/keyframe_pose"
POINTS = "/vins_estimator/keyframe_point"
EXTRINSIC = "/vins_estimator/extrinsic"
ODOMETRY = "/vins_estimator/odometry"
VIRTUAL = "/virtual_cam0/frame"
TYPES = {
    IMAGE: Image,
    POSE: Odometry,
    POINTS: PointCloud,
    EXTRINSIC: Odometry,
    ODOMETRY: Odometry,
    VIRTUAL: VirtualFrame,
}


class Flight:
    """The messages of a simulated flight, and the truth about it."""

    def __init__(self, directory, kinds=None):
        """`kinds`: message types by topic, of all that is played; everything the node hears by default."""
        kinds = kinds or TYPES
        with rosbag.Bag(os.path.join(directory, "flight.bag")) as bag:
            self.messages = [
                (time.to_sec(), topic, message)
                for topic, message, time in bag.read_messages(topics=list(kinds))
            ]
        truth = np.loadtxt(os.path.join(directory, "groundtruth.txt"))
        self.truth_stamps, self.truth = truth[:, 0], truth[:, 1:4]
        self.publishers = {
            topic: rospy.Publisher(topic, kind, queue_size=1000) for topic, kind in kinds.items()
        }

    def keyframe_stamps(self):
        return [m.header.stamp for _, topic, m in self.messages if topic == POSE]

    def wait_for_node(self, timeout_s=30.0):
        wait_until(
            lambda: all(p.get_num_connections() > 0 for p in self.publishers.values()),
            timeout_s,
            "the node to subscribe",
        )

    def play(self, speed, edit=None):
        """Publishes all messages at `speed` times real time; `edit(topic, message)` may return others."""
        start = time.monotonic()
        first = self.messages[0][0]
        for recorded, topic, message in self.messages:
            wait = (recorded - first) / speed - (time.monotonic() - start)
            if wait > 0:
                time.sleep(wait)
            for other_topic, other in edit(topic, message) if edit else [(topic, message)]:
                self.publishers[other_topic].publish(other)

    def true_position(self, stamp):
        return np.array([np.interp(stamp.to_sec(), self.truth_stamps, self.truth[:, axis]) for axis in range(3)])

    def loop_error(self, loop):
        """How much the distance that a LoopConstraint finds is off the true one [m]."""
        p = loop.relative_pose.pose.position
        true = self.true_position(loop.stamp_current) - self.true_position(loop.stamp_old)
        return abs(np.linalg.norm([p.x, p.y, p.z]) - np.linalg.norm(true))

    def ape(self, path):
        """Mean absolute position error [m] of a nav_msgs/Path after alignment in position and yaw."""
        stamps = np.array([p.header.stamp.to_sec() for p in path.poses])
        estimate = np.array(
            [[p.pose.position.x, p.pose.position.y, p.pose.position.z] for p in path.poses]
        )
        truth = np.stack(
            [np.interp(stamps, self.truth_stamps, self.truth[:, axis]) for axis in range(3)], axis=1
        )
        a, b = estimate - estimate.mean(axis=0), truth - truth.mean(axis=0)
        yaw = np.arctan2(
            np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), np.sum(a[:, 0] * b[:, 0] + a[:, 1] * b[:, 1])
        )
        c, s = np.cos(yaw), np.sin(yaw)
        aligned = a @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]).T
        return np.mean(np.linalg.norm(aligned - b, axis=1))


class Recorder:
    """Keeps what is published on topics."""

    def __init__(self, topics):
        self.messages = {topic: [] for topic in topics}
        self.subscribers = [
            rospy.Subscriber(topic, kind, self.messages[topic].append, queue_size=1000)
            for topic, kind in topics.items()
        ]

    def __getitem__(self, topic):
        return self.messages[topic]


class NodeOutputs(Recorder):
    """What tells how the node is doing: loops, drift and paths."""

    LOOPS = "/loop_fusion/loop_constraint"
    DRIFT = "/loop_fusion/drift"
    PATH = "/pose_graph/pose_graph_path"
    NO_LOOP_PATH = "/pose_graph/no_loop_path"

    def __init__(self, more=None):
        topics = {
            self.LOOPS: LoopConstraint,
            self.DRIFT: TransformStamped,
            self.PATH: Path,
            self.NO_LOOP_PATH: Path,
        }
        topics.update(more or {})
        super().__init__(topics)

    def accepted(self):
        return [m for m in self[self.LOOPS] if m.accepted]

    def wait_for_keyframe(self, stamp, timeout_s=30.0):
        """Until the node has processed this keyframe, and its paths say so."""
        for topic in (self.DRIFT, self.PATH, self.NO_LOOP_PATH):
            wait_until(
                lambda: self[topic] and self[topic][-1].header.stamp >= stamp,
                timeout_s,
                f"{topic} of {stamp.to_sec()}",
            )


def wait_until(condition, timeout_s, what):
    deadline = time.monotonic() + timeout_s
    while not condition():
        if time.monotonic() > deadline or rospy.is_shutdown():
            raise AssertionError(f"waited {timeout_s} s in vain for {what}")
        time.sleep(0.02)

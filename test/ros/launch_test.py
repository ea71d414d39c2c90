#!/usr/bin/python3
"""The launch files hand every argument on to the node, whichever of them includes it, and RViz shows the flight
large. No master is needed.

Usage: launch_test.py LAUNCH_DIRECTORY"""

import os
import struct
import sys
import unittest

import roslaunch.config
import roslaunch.xmlloader
import yaml

LAUNCH = sys.argv.pop(1) if len(sys.argv) > 1 else "launch"

# Argument of the launch files, and parameter of the node.
ARGUMENTS = {
    "config_path": "config_file",
    "host": "host",
    "gravity": "gravity",
    "options_file": "options_file",
    "vocabulary_file": "vocabulary_file",
    "map_directory": "map_directory",
    "load_map": "load_map_at_start",
    "save_map": "save_map_at_end",
    "output_directory": "output_directory",
    "image_topic": "topics/image",
    "keyframe_pose_topic": "topics/keyframe_pose",
    "keyframe_point_topic": "topics/keyframe_point",
    "extrinsic_topic": "topics/extrinsic",
    "odometry_topic": "topics/odometry",
    "imu_propagate_topic": "topics/imu_propagate",
    "relo_relative_pose_topic": "topics/relo_relative_pose",
    "virtual_topic": "topics/virtual_frame",
}


def load(name, **arguments):
    config = roslaunch.config.ROSLaunchConfig()
    roslaunch.xmlloader.XmlLoader().load(
        os.path.join(LAUNCH, name),
        config,
        argv=[f"{key}:={value}" for key, value in arguments.items()],
        verbose=False,
    )
    return config


def parameters(config):
    prefix = "/loop_fusion/"
    return {p.key[len(prefix):]: p.value for p in config.params.values() if p.key.startswith(prefix)}


class LaunchTest(unittest.TestCase):
    def test_every_argument_reaches_the_node(self):
        given = {argument: "/" + argument for argument in ARGUMENTS}
        for name, more in (
            ("loop_fusion.launch", {}),
            ("replay.launch", {"bag": "flight.bag"}),
            ("vins_mono.launch", {"start_vins": "false"}),
            ("vins_fusion.launch", {}),
            ("openvins.launch", {}),
            ("odometry.launch", {}),
            ("orb_slam3.launch", {}),
            ("euroc.launch", {"bag": "flight.bag"}),
            ("euroc.launch", {"bag": "flight.bag", "vins": "true"}),
        ):
            found = parameters(load(name, compressed_images="true", **given, **more))
            self.assertEqual({a: found[p] for a, p in ARGUMENTS.items()}, given, name)
            self.assertIs(found["compressed_images"], True, name)

    def test_without_arguments_the_topics_are_the_hosts(self):
        found = parameters(load("vins_mono.launch", config_path="camera.yaml"))
        self.assertEqual(found["host"], "vins_mono")
        self.assertEqual(found["topics/keyframe_pose"], "")
        self.assertEqual(found["topics/image"], "")
        self.assertTrue(found["options_file"].endswith("loop_fusion.yaml"))

    def test_each_host_has_a_launch_file(self):
        for host in ("vins_mono", "vins_fusion", "openvins", "odometry"):
            arguments = {"start_vins": "false"} if host == "vins_mono" else {}
            found = parameters(load(host + ".launch", config_path="camera.yaml", **arguments))
            self.assertEqual(found["host"], host)

    def test_orb_slam3_is_an_odometry(self):
        found = parameters(load("orb_slam3.launch", config_path="settings.yaml"))
        self.assertEqual(found["host"], "odometry")
        self.assertEqual(found["topics/odometry"], "/orb_slam3/body_odom")
        self.assertEqual(found["gravity"], "given")

    def test_poses_of_tf_are_played_from_tf(self):
        config = load("replay.launch", bag="b.bag", config_path="c.yaml", host="odometry", odometry_topic="tf:odom,base")
        player = next(n for n in config.nodes if n.name == "player")
        played = player.args.split("--topics ")[1].split()
        self.assertEqual(played, ["/cam0/image_raw", "/tf", "/tf_static", "/virtual_cam0/frame"])
        self.assertEqual(parameters(config)["topics/odometry"], "tf:odom,base")

    def test_a_replay_plays_all_that_the_node_hears(self):
        config = load("replay.launch", bag="flight.bag", config_path="camera.yaml")
        player = next(n for n in config.nodes if n.name == "player")
        heard = [v for k, v in parameters(config).items() if k.startswith("topics/")]
        self.assertEqual(len(heard), 8)
        for topic in heard:
            self.assertIn(topic, player.args.split())

    def test_beside_an_odometry_only_its_poses_are_played(self):
        config = load("replay.launch", bag="flight.bag", config_path="camera.yaml", host="odometry")
        player = next(n for n in config.nodes if n.name == "player")
        played = player.args.split("--topics ")[1].split()
        self.assertEqual(played, ["/cam0/image_raw", "/vins_estimator/odometry", "/virtual_cam0/frame"])

    def test_rviz_opens_with_most_of_its_window_for_the_flight(self):
        with open(os.path.join(LAUNCH, "..", "config", "deja_view.rviz"), encoding="utf-8") as file:
            config = yaml.safe_load(file)
        window = config["Window Geometry"]
        state = bytes.fromhex(str(window["QMainWindow State"]))
        # Of QMainWindow::saveState: the size of what lies between the panels comes before the four corners.
        corners = struct.pack(">4i", 4, 4, 8, 8)
        width, height = struct.unpack_from(">2i", state, state.rindex(corners) - 8)
        self.assertGreater(width, 0.7 * window["Width"])
        self.assertGreater(height, 0.7 * window["Height"])
        images = [d["Name"] for d in config["Visualization Manager"]["Displays"] if d["Class"] == "rviz/Image"]
        for panel in [p["Name"] for p in config["Panels"]] + images:
            self.assertIn(panel.encode("utf-16-be"), state, panel)


if __name__ == "__main__":
    unittest.main()

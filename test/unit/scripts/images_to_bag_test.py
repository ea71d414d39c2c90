#!/usr/bin/python3
"""Films a textured wall whose geometry is known and checks what scripts/images_to_bag makes of the images."""

import contextlib
import importlib.machinery
import importlib.util
import io
import json
import math
import os
import sys
import tempfile
import unittest

import cv2
import numpy as np
import rosbag

TOOL = sys.argv.pop(1) if len(sys.argv) > 1 else None  # deja_view
ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "..")


def load_script(path):
    loader = importlib.machinery.SourceFileLoader("images_to_bag", path)
    loader.path = path
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("images_to_bag", loader))
    loader.exec_module(module)
    return module


script = load_script(os.path.join(ROOT, "scripts", "images_to_bag"))
import posed_frames as frames  # noqa: E402, from where the script found it

SIZE = (320, 240)
K = np.array([[250.0, 0, 160], [0, 250.0, 120], [0, 0, 1]])
WALL_M = 3.0  # the wall is the plane x = 3 m of a world with z up
FRAMES = 24
RATE = 20.0
T_B_C = np.array([[0.0, 0, 1, 0.1], [-1, 0, 0, 0.02], [0, -1, 0, -0.03], [0, 0, 0, 1]])

CAMERA = """%YAML:1.0
model_type: PINHOLE
image_topic: "/cam0/image_raw"
image_width: 320
image_height: 240
distortion_parameters: {k1: 0.0, k2: 0.0, p1: 0.0, p2: 0.0}
projection_parameters: {fx: 250.0, fy: 250.0, cx: 160.0, cy: 120.0}
extrinsicRotation: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [0, 0, 1, -1, 0, 0, 0, -1, 0]
extrinsicTranslation: !!opencv-matrix
   rows: 3
   cols: 1
   dt: d
   data: [0.1, 0.02, -0.03]
"""


def body_pose(i):
    """Sideways along the wall, and turning."""
    along = i / (FRAMES - 1) - 0.5
    T = np.eye(4)
    T[:3, :3] = frames.yaw_rotation(math.radians(40) * along)
    T[:3, 3] = 0.1 * along, 1.2 * along, 0.05 * math.sin(6 * along)
    return T


def texture():
    random = np.random.default_rng(5)
    coarse = random.integers(40, 215, (60, 80), dtype=np.uint8)
    return cv2.resize(coarse, (1600, 1200), interpolation=cv2.INTER_CUBIC)  # 200 px per metre


def film(T_W_C, wall):
    """Texture (u, v) lies at (WALL_M, 4 - u / 200, 3 - v / 200)."""
    T_C_W = np.linalg.inv(T_W_C)
    plane = np.array([[0, 0, WALL_M], [-1 / 200, 0, 4], [0, -1 / 200, 3], [0, 0, 1]])
    return cv2.warpPerspective(wall, K @ (T_C_W @ plane)[:3], SIZE, flags=cv2.INTER_LINEAR)


class ImagesToBagTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.images = self.path("images")
        os.mkdir(self.images)
        self.write("camera.yaml", CAMERA)
        self.bag = self.path("out.bag")

    def path(self, name):
        return os.path.join(self.folder, name)

    def write(self, name, text):
        with open(self.path(name), "w", encoding="ascii") as file:
            file.write(text)

    def film_all(self, seven_scenes_turn=None):
        """Images named by frame number with matrix poses in a turned world, or by stamp with a TUM file of bodies."""
        wall, lines = texture(), []
        for i in range(FRAMES):
            T_W_C = body_pose(i) @ T_B_C
            stamp = 5 * 10**15 + i * 10**8 // 2
            name = f"frame-{i:06d}.color" if seven_scenes_turn is not None else f"{stamp}"
            cv2.imwrite(os.path.join(self.images, name + ".png"), film(T_W_C, wall))
            if seven_scenes_turn is not None:
                np.savetxt(os.path.join(self.images, f"frame-{i:06d}.pose.txt"), seven_scenes_turn @ T_W_C)
            T = body_pose(i)
            numbers = " ".join(f"{v:.9f}" for v in [*T[:3, 3], *frames.to_quaternion(T[:3, :3])])
            lines.append(f"{stamp // 10**9}.{stamp % 10**9:09d} {numbers}\n")
        self.write("poses.txt", "".join(lines))

    def run_script(self, *arguments, poses=("--poses", "poses.txt")):
        """Exit status and what was printed to the standard streams."""
        poses = [self.path(p) if p.endswith(".txt") else p for p in poses]
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            status = script.main(
                ["--images", self.images, "--camera", self.path("camera.yaml"), "--out", self.bag]
                + ["--rate", str(RATE), *(["--deja-view", TOOL] if TOOL else []), *poses, *arguments]
            )
        return status, out.getvalue(), err.getvalue()

    def messages(self):
        found = {}
        with rosbag.Bag(self.bag) as bag:
            for topic, message, _ in bag.read_messages():
                found.setdefault(topic, []).append(message)
        return found

    def keyframes(self):
        """(T_W_B, world points, pixels) by keyframe."""
        found = self.messages()
        poses, clouds = found["/vins_estimator/keyframe_pose"], found["/vins_estimator/keyframe_point"]
        self.assertEqual([m.header.stamp for m in poses], [m.header.stamp for m in clouds])
        result = []
        for pose, cloud in zip(poses, clouds):
            p, q = pose.pose.pose.position, pose.pose.pose.orientation
            points = np.array([[v.x, v.y, v.z] for v in cloud.points]).reshape(-1, 3)
            pixels = np.array([c.values[2:4] for c in cloud.channels]).reshape(-1, 2)
            result.append((frames.to_pose([p.x, p.y, p.z], [q.x, q.y, q.z, q.w]), points, pixels))
        return result

    def reprojection_error(self, T_W_B, points, pixels):
        T_C_W = np.linalg.inv(T_W_B @ T_B_C)
        local = points @ T_C_W[:3, :3].T + T_C_W[:3, 3]
        projected = local @ K.T
        return np.linalg.norm(projected[:, :2] / projected[:, 2:] - pixels, axis=1)

    def test_points_lie_on_the_wall_and_under_their_pixels(self):
        self.film_all()
        status, out, err = self.run_script("--json", "-")
        self.assertEqual((status, err), (0, ""))
        keyframes = self.keyframes()
        counts = json.loads(out)
        self.assertEqual(counts["images"], FRAMES)
        self.assertEqual(counts["keyframes"], len(keyframes))
        self.assertGreaterEqual(len(keyframes), 6)
        for T_W_B, points, pixels in keyframes[2:]:
            self.assertGreater(len(points), 20)
            self.assertLess(np.median(np.abs(points[:, 0] - WALL_M)), 0.05)
            self.assertLess(np.median(self.reprojection_error(T_W_B, points, pixels)), 0.5)

    def test_messages_are_those_of_vins_mono(self):
        self.film_all()
        self.assertEqual(self.run_script()[0], 0)
        found = self.messages()
        images = found["/cam0/image_raw"]
        self.assertEqual(len(images), FRAMES)
        self.assertEqual((images[0].encoding, images[0].width, images[0].height), ("mono8", *SIZE))
        stamps = {m.header.stamp for m in images}
        self.assertEqual(len(found["/vins_estimator/odometry"]), FRAMES)
        self.assertTrue(all(m.header.stamp in stamps for m in found["/vins_estimator/keyframe_pose"]))
        t = found["/vins_estimator/extrinsic"][0].pose.pose.position
        np.testing.assert_allclose([t.x, t.y, t.z], T_B_C[:3, 3], atol=1e-9)
        cloud = found["/vins_estimator/keyframe_point"][-1]
        x_n, y_n, u, v, track = cloud.channels[0].values
        np.testing.assert_allclose([u, v], [250 * x_n + 160, 250 * y_n + 120], atol=1e-3)
        self.assertEqual(track, int(track))

    def test_up_is_estimated_for_seven_scenes(self):
        turn = np.eye(4)
        turn[:3, :3] = cv2.Rodrigues(np.array([0.7, -0.4, 1.9]))[0]
        self.film_all(seven_scenes_turn=turn)
        status, _, err = self.run_script("--groundtruth", self.path("truth.tum"), poses=["--seven-scenes"])
        self.assertEqual((status, err), (0, ""))
        for row in np.loadtxt(self.path("truth.tum")):
            up = frames.to_pose(row[1:4], row[4:])[2, :3]  # the world's z seen from the body
            np.testing.assert_allclose(up, [0, 0, 1], atol=1e-6)

    def test_up_of_a_camera_that_does_not_turn_must_be_given(self):
        with self.assertRaisesRegex(frames.UserError, "--up"):
            frames.estimate_up([np.eye(3)] * 5)

    def test_drift_is_seeded_and_keeps_points_by_their_keyframe(self):
        self.film_all()
        positions = []
        for seed in ("1", "1", "2"):
            self.assertEqual(self.run_script("--drift", "0.01", "--drift-yaw-deg", "0.3", "--seed", seed)[0], 0)
            keyframes = self.keyframes()
            positions.append(np.array([T[:3, 3] for T, _, _ in keyframes]))
            T_W_B, points, pixels = keyframes[-1]  # the drift of a second is in the points
            self.assertLess(np.median(self.reprojection_error(T_W_B, points, pixels)), 1.5)
            np.testing.assert_allclose(T_W_B[2, :3], [0, 0, 1], atol=1e-9)  # yaw only: z stays up
        np.testing.assert_array_equal(positions[0], positions[1])
        self.assertGreater(np.abs(positions[0] - positions[2]).max(), 0.005)

    def film_sparse_stereo(self):
        """Two images 1.15 s apart, and what a second camera 0.2 m to the right sees; arguments for it."""
        self.film_all()
        right = self.path("right")
        os.mkdir(right)
        T_B_C2 = T_B_C.copy()
        T_B_C2[1, 3] -= 0.2
        for i, name in enumerate(sorted(os.listdir(self.images))):
            if i in (0, FRAMES - 1):
                cv2.imwrite(os.path.join(right, name), film(body_pose(i) @ T_B_C2, texture()))
            else:
                os.remove(os.path.join(self.images, name))
        self.write("right.yaml", CAMERA.replace("[0.1, 0.02, -0.03]", "[0.1, -0.18, -0.03]"))
        return "--stereo", right, self.path("right.yaml")

    def test_a_second_camera_gives_points_to_images_far_apart(self):
        stereo = self.film_sparse_stereo()
        self.assertEqual(self.run_script(*stereo)[0], 0)
        for T_W_B, points, pixels in self.keyframes():
            self.assertGreater(len(points), 20)
            self.assertLess(np.median(np.abs(points[:, 0] - WALL_M)), 0.05)
            self.assertLess(np.median(self.reprojection_error(T_W_B, points, pixels)), 0.5)

    def test_keyframes_without_points_are_told(self):
        self.film_sparse_stereo()
        status, out, err = self.run_script("--json", "-")
        self.assertEqual((status, json.loads(out)["keyframes_without_points"]), (0, 2))
        self.assertIn("warning: 2 of 2 keyframes have no points", err)

    def test_options_of_the_front_end_are_passed_on(self):
        self.film_all()
        self.assertEqual(self.run_script("--keyframe-every", "6", "--set", "front_end.tracker.max_corners=30")[0], 0)
        keyframes = self.keyframes()
        self.assertEqual(len(keyframes), FRAMES // 6)
        self.assertLessEqual(max(len(points) for _, points, _ in keyframes), 30)
        status, _, err = self.run_script("--set", "front_end.corners=30")
        self.assertEqual(status, 1)
        self.assertIn("front_end.corners", err)

    def test_a_tool_that_is_not_there_is_an_error(self):
        self.film_all()
        status, _, err = self.run_script("--deja-view", self.path("no_tool"))
        self.assertEqual(status, 1)
        self.assertIn("no_tool: No such file", err)

    def test_missing_poses_are_an_error_or_left_out(self):
        self.film_all()
        with open(self.path("poses.txt"), encoding="ascii") as file:
            lines = file.readlines()
        self.write("poses.txt", "".join(lines[3:]))
        status, _, err = self.run_script()
        self.assertEqual(status, 1)
        self.assertIn("5000000000000000.png: no pose (so of 3 of 24 images)", err)
        self.assertEqual(os.listdir(self.folder).count("out.bag"), 0)
        status, out, _ = self.run_script("--skip-unposed", "--json", "-")
        self.assertEqual((status, json.loads(out)["without_pose"]), (0, 3))

    def test_image_of_another_size_is_an_error_and_leaves_nothing(self):
        self.film_all()
        cv2.imwrite(os.path.join(self.images, "5000000500000000.png"), np.zeros((10, 12), np.uint8))
        status, _, err = self.run_script()
        self.assertEqual(status, 1)
        self.assertIn("5000000500000000.png: 12 x 10 px: expected 320 x 240", err)
        self.assertEqual(sorted(os.listdir(self.folder)), ["camera.yaml", "images", "poses.txt"])

    def test_bad_camera_files_are_errors(self):
        self.film_all()
        for text, expected in (
            (CAMERA.replace("PINHOLE", "MEI"), "mirror_parameters"),
            (CAMERA.replace("fx: 250.0", "fx: wide"), "projection_parameters.fx"),
            (CAMERA.replace("image_width: 320\n", ""), "image_width: expected a number"),
        ):
            self.write("camera.yaml", text)
            status, _, err = self.run_script()
            self.assertEqual(status, 1)
            self.assertIn(expected, err)

    def test_stamps_of_names(self):
        self.assertEqual(frames.image_stamp("1403715273262142976.jpg", 30), 1403715273262142976)
        self.assertEqual(frames.image_stamp("1305031102.175304.png", 30), 1305031102175304000)
        self.assertEqual(frames.image_stamp("frame-000015.color.jpg", 30), frames.FIRST_STAMP_NS + 500000000)
        self.assertIsNone(frames.image_stamp("cover.png", 30))

    def test_interpolation_turns_evenly(self):
        T_b = frames.to_pose([2, 0, 0], [0, 0, math.sin(0.5), math.cos(0.5)])
        T = frames.interpolate(np.eye(4), T_b, 0.25)
        np.testing.assert_allclose(T[:3, 3], [0.5, 0, 0])
        np.testing.assert_allclose(T[:3, :3], frames.yaw_rotation(0.25), atol=1e-12)


if __name__ == "__main__":
    unittest.main()

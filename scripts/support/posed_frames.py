"""Posed images of a folder: cameras, poses and the direction of gravity, for images_to_bag."""
import math
import os
import re
from collections import namedtuple

import cv2
import numpy as np

IMAGE_SUFFIXES = (".jpg", ".jpeg", ".png", ".pgm", ".bmp", ".tif", ".tiff")
FIRST_STAMP_NS = 10**12  # of images named by number: ROS takes a stamp of 0 for none

Camera = namedtuple("Camera", "path size T_B_C")  # size: (width, height)
Frame = namedtuple("Frame", "stamp path T_W_B")  # stamp in ns


class UserError(Exception):
    """What the user gave does not fit; says what was expected."""


# Rigid motions: 4 x 4 matrices, p_W = T_W_B p_B.


def inverse(T):
    result = np.eye(4)
    result[:3, :3] = T[:3, :3].T
    result[:3, 3] = -T[:3, :3].T @ T[:3, 3]
    return result


def to_pose(position, quaternion):
    """From a position and a quaternion (x, y, z, w)."""
    x, y, z, w = np.asarray(quaternion) / np.linalg.norm(quaternion)
    T = np.eye(4)
    T[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    T[:3, 3] = position
    return T


def to_quaternion(R):
    """(x, y, z, w) of a rotation matrix: the eigenvector of Bar-Itzhack's matrix (J. Guid. Control 23, 2000)."""
    K = np.zeros((4, 4))
    K[:3, :3] = R + R.T - np.trace(R) * np.eye(3)
    K[3, :3] = K[:3, 3] = [R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]
    K[3, 3] = np.trace(R)
    return np.linalg.eigh(K)[1][:, 3]


def nearest_rotation(matrix):
    u, _, vt = np.linalg.svd(matrix)
    return u @ np.diag([1, 1, np.linalg.det(u @ vt)]) @ vt


def interpolate(T_a, T_b, fraction):
    turn, _ = cv2.Rodrigues(T_a[:3, :3].T @ T_b[:3, :3])
    T = np.eye(4)
    T[:3, :3] = T_a[:3, :3] @ cv2.Rodrigues(turn * fraction)[0]
    T[:3, 3] = (1 - fraction) * T_a[:3, 3] + fraction * T_b[:3, 3]
    return T


def yaw_rotation(angle):
    return cv2.Rodrigues(np.array([0.0, 0.0, angle]))[0]


# Inputs.


def read_camera(path):
    """What the script needs of a camera in VINS-Mono's layout; without extrinsics the camera is the body."""
    if not os.path.isfile(path):
        raise UserError(f"{path}: no such camera file")
    try:
        file = cv2.FileStorage(path, cv2.FILE_STORAGE_READ)
    except (cv2.error, SystemError) as error:
        raise UserError(f"{path}: expected YAML that starts with %YAML:1.0") from error

    def number(key):
        node = file.getNode(key)
        if node.empty() or not (node.isReal() or node.isInt()):
            raise UserError(f"{path}: {key}: expected a number")
        return node.real()

    T_B_C = np.eye(4)
    rotation, translation = (file.getNode(f"extrinsic{k}").mat() for k in ("Rotation", "Translation"))
    if rotation is not None and translation is not None:
        if rotation.shape != (3, 3) or translation.size != 3:
            raise UserError(f"{path}: extrinsicRotation, extrinsicTranslation: expected 3 x 3 and 3 x 1")
        T_B_C[:3, :3], T_B_C[:3, 3] = nearest_rotation(rotation), translation.ravel()
    size = int(number("image_width")), int(number("image_height"))
    return Camera(path, size, T_B_C)


def read_grey(path, camera):
    image = cv2.imread(path, cv2.IMREAD_GRAYSCALE)
    if image is None:
        raise UserError(f"{path}: can't be decoded")
    if image.shape[::-1] != camera.size:
        raise UserError(
            f"{path}: {image.shape[1]} x {image.shape[0]} px: expected {camera.size[0]} x {camera.size[1]}"
            f" as in {camera.path}"
        )
    return image


def image_stamp(name, rate):
    """Stamp [ns] that the name of an image says; None when it says none."""
    stem = os.path.splitext(name)[0]
    if re.fullmatch(r"\d{16,19}", stem):
        return int(stem)
    if re.fullmatch(r"\d+\.\d+", stem):
        seconds, fraction = stem.split(".")
        return int(seconds) * 10**9 + int(fraction[:9].ljust(9, "0"))
    number = re.search(r"\d+", stem)
    return FIRST_STAMP_NS + round(int(number.group()) * 1e9 / rate) if number else None


def list_images(directory, rate):
    """(stamp in ns, path) of all images, by stamp. Depth maps (*.depth.*) are none."""
    if not os.path.isdir(directory):
        raise UserError(f"{directory}: no such folder of images")
    images = []
    for name in os.listdir(directory):
        if not name.lower().endswith(IMAGE_SUFFIXES) or ".depth." in name:
            continue
        stamp = image_stamp(name, rate)
        if stamp is None:
            raise UserError(f"{directory}/{name}: expected a stamp or a number in the name")
        images.append((stamp, os.path.join(directory, name)))
    images.sort()
    for a, b in zip(images, images[1:]):
        if a[0] == b[0]:
            raise UserError(f"{a[1]} and {b[1]} have the same stamp")
    if len(images) < 2:
        raise UserError(f"{directory}: {len(images)} images: expected at least 2")
    return images


def beside(image_path, ending):
    """seq/frame-000012.color.png -> seq/frame-000012<ending>"""
    folder, name = os.path.split(image_path)
    return os.path.join(folder, name.split(".")[0] + ending)


def read_matrix_pose(path):
    if not os.path.isfile(path):
        return None
    try:
        T = np.loadtxt(path)
    except ValueError as error:
        raise UserError(f"{path}: {error}: expected 4 rows of 4 numbers") from error
    if T.shape != (4, 4) or not np.isfinite(T).all() or abs(np.linalg.det(T[:3, :3]) - 1) > 0.05:
        raise UserError(f"{path}: expected a finite 4 x 4 camera-to-world pose")
    T[:3, :3] = nearest_rotation(T[:3, :3])
    return T


class TumPoses:
    """Poses of a TUM file (timestamp tx ty tz qx qy qz qw), interpolated."""

    def __init__(self, path, max_gap_s):
        try:
            rows = np.loadtxt(path, ndmin=2, dtype=str)
            values = rows[:, 1:].astype(float)
        except (OSError, ValueError) as error:
            raise UserError(f"{path}: {error}: expected lines of timestamp tx ty tz qx qy qz qw") from error
        if rows.shape[1] != 8 or len(rows) < 2 or not np.isfinite(values).all():
            raise UserError(f"{path}: expected at least 2 lines of timestamp tx ty tz qx qy qz qw")
        if (np.abs(np.linalg.norm(values[:, 3:], axis=1) - 1) > 0.01).any():
            raise UserError(f"{path}: expected quaternions of norm 1")
        stamps = []
        for text in rows[:, 0]:
            seconds, _, fraction = text.partition(".")
            stamps.append(int(seconds) * 10**9 + int(fraction[:9].ljust(9, "0")))
        self.stamps, self.max_gap_s = np.array(stamps), max_gap_s
        if (np.diff(self.stamps) <= 0).any():
            raise UserError(f"{path}: expected timestamps that rise")
        self.poses = [to_pose(v[:3], v[3:]) for v in values]

    def at(self, stamp):
        """None outside of the poses, and in gaps."""
        after = int(np.searchsorted(self.stamps, stamp))
        if after < len(self.stamps) and self.stamps[after] == stamp:
            return self.poses[after]
        if after == 0 or after == len(self.stamps):
            return None
        gap = self.stamps[after] - self.stamps[after - 1]
        if gap > self.max_gap_s * 1e9:
            return None
        fraction = (stamp - self.stamps[after - 1]) / gap
        return interpolate(self.poses[after - 1], self.poses[after], fraction)


def estimate_up(rotations_W_C):
    """The direction to which the cameras' x axes are most nearly perpendicular, on the side of their -y."""
    x_axes = np.array([R[:, 0] for R in rotations_W_C])
    values, vectors = np.linalg.eigh(x_axes.T @ x_axes / len(x_axes))
    if values[1] < max(0.01, 3 * values[0]):
        raise UserError("the cameras turn too little to tell which way is up: give --up")
    up = vectors[:, 0]
    return up if sum(-R[:, 1] @ up for R in rotations_W_C) > 0 else -up


def rotation_to_z(up):
    """The smallest rotation that turns `up` to +z."""
    norm = np.linalg.norm(up)
    if not norm > 1e-9:
        raise UserError("--up 0 0 0: expected a direction")
    up = np.asarray(up) / norm
    axis = np.cross(up, [0, 0, 1])
    sine = np.linalg.norm(axis)
    if sine < 1e-9:
        return np.eye(3) if up[2] > 0 else np.diag([1.0, -1.0, -1.0])
    return cv2.Rodrigues(axis / sine * math.atan2(sine, up[2]))[0]


def load_frames(options, camera):
    """Frames with their body poses in a world with z up, how many images had no pose, and where up was."""
    images = list_images(options.images, options.rate)
    T_C_B = inverse(camera.T_B_C)
    if options.seven_scenes:
        poses = [read_matrix_pose(beside(path, ".pose.txt")) for _, path in images]
    else:
        tum = TumPoses(options.poses, options.max_pose_gap)
        poses = [tum.at(stamp) for stamp, _ in images]
    posed = [(stamp, path, T) for (stamp, path), T in zip(images, poses) if T is not None]
    without = len(images) - len(posed)
    if without and not options.skip_unposed:
        first = next(path for (_, path), T in zip(images, poses) if T is None)
        raise UserError(f"{first}: no pose (so of {without} of {len(images)} images); --skip-unposed leaves them out")
    if len(posed) < 2:
        raise UserError(f"{len(posed)} images with a pose: expected at least 2")
    if options.seven_scenes or options.poses_of == "camera":
        posed = [(stamp, path, T @ T_C_B) for stamp, path, T in posed]
    up = options.up
    if up is None:
        rotations = [T[:3, :3] @ camera.T_B_C[:3, :3] for _, _, T in posed]
        up = estimate_up(rotations) if options.seven_scenes else [0.0, 0.0, 1.0]
    turn = np.eye(4)
    turn[:3, :3] = rotation_to_z(up)
    return [Frame(stamp, path, turn @ T) for stamp, path, T in posed], without, up

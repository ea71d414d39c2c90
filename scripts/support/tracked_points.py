"""Points of posed images: corners followed by optical flow and triangulated, for images_to_bag."""
import math
import os
from collections import namedtuple

import cv2
import numpy as np

from posed_frames import UserError, beside

SEQUENCE_GAP_S = 1.0  # tracks don't live through longer pauses
MAX_DEPTH_M = 60.0
MIN_DEPTH_M = 0.1
FLOW = dict(winSize=(21, 21), maxLevel=3)

Observation = namedtuple("Observation", "ids pixels")  # of the tracks in one frame


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


# Tracks.


def flow(image, other, pixels):
    """Where pixels of an image are in another one, and which of them were found there and back again."""
    there, found, _ = cv2.calcOpticalFlowPyrLK(image, other, pixels, None, **FLOW)
    back, found_back, _ = cv2.calcOpticalFlowPyrLK(other, image, there, None, **FLOW)
    good = (found.ravel() == 1) & (found_back.ravel() == 1)
    good &= np.linalg.norm(back - pixels, axis=1) < 0.5
    good &= (there > 1).all(axis=1) & (there < np.array(other.shape[::-1]) - 2).all(axis=1)
    return there, good


class Tracker:
    """Follows corners from image to image; every track keeps its id."""

    def __init__(self, max_points, min_distance):
        self.max_points, self.min_distance = max_points, min_distance
        self.image, self.next_id = None, 0
        self.ids, self.pixels = np.zeros(0, int), np.zeros((0, 2), np.float32)

    def restart(self):
        self.ids, self.pixels = self.ids[:0], self.pixels[:0]

    def add(self, image):
        if len(self.ids):
            self.follow(image)
        self.refill(image)
        self.image = image
        return Observation(self.ids, self.pixels)

    def follow(self, image):
        there, good = flow(self.image, image, self.pixels)
        self.ids, self.pixels = self.ids[good], there[good]

    def refill(self, image):
        mask = np.full(image.shape, 255, np.uint8)
        kept = []
        for i, (x, y) in enumerate(self.pixels):  # oldest first
            if mask[int(y), int(x)]:
                kept.append(i)
                cv2.circle(mask, (int(x), int(y)), self.min_distance, 0, -1)
        self.ids, self.pixels = self.ids[kept], self.pixels[kept]
        missing = self.max_points - len(kept)
        corners = cv2.goodFeaturesToTrack(image, missing, 0.01, self.min_distance, mask=mask) if missing > 0 else None
        if corners is not None:
            self.ids = np.concatenate([self.ids, np.arange(self.next_id, self.next_id + len(corners))])
            self.pixels = np.concatenate([self.pixels, corners.reshape(-1, 2)])
            self.next_id += len(corners)


def moved_pixels(a, b):
    """Median distance [px] that common tracks moved between two frames; infinite when few are common."""
    _, in_a, in_b = np.intersect1d(a.ids, b.ids, return_indices=True)
    if len(in_a) < 20:
        return math.inf
    return float(np.median(np.linalg.norm(a.pixels[in_a] - b.pixels[in_b], axis=1)))


def track(frames, camera, options):
    """Observations of every frame, and the indices of the keyframes."""
    tracker = Tracker(options.max_points, options.min_distance)
    observations, keyframes = [], []
    for i, frame in enumerate(frames):
        pause = i > 0 and frame.stamp - frames[i - 1].stamp > SEQUENCE_GAP_S * 1e9
        if pause:
            tracker.restart()
        observations.append(tracker.add(read_grey(frame.path, camera)))
        if not keyframes or pause:
            keyframes.append(i)
        elif i - keyframes[-1] >= options.keyframe_every:
            if moved_pixels(observations[keyframes[-1]], observations[i]) >= options.min_motion:
                keyframes.append(i)
    return observations, keyframes


def normalised(pixels, camera):
    """Undistorted coordinates on the plane z = 1, n x 2."""
    if len(pixels) == 0:
        return np.zeros((0, 2))
    points = np.asarray(pixels, np.float64).reshape(-1, 1, 2)
    return cv2.undistortPoints(points, camera.K, camera.distortion).reshape(-1, 2)


def triangulate(track_count, tracks, poses_W_C, rays, focal, options):
    """World points of tracks from their rays: least squares of the distances to the rays, weighted by 1 / depth.

    tracks[i] in [0, track_count) is the track of ray i, rays[i] its (x, y) at z = 1, poses_W_C[i] its camera. Returns
    n x 3 points and which of them can be believed: in front of all cameras, seen from directions that differ by
    options.min_parallax_deg, and options.max_error px (RMS) from their pixels.
    """
    R, centres = poses_W_C[:, :3, :3], poses_W_C[:, :3, 3]
    directions = np.einsum("nij,nj->ni", R, np.column_stack([rays, np.ones(len(rays))]))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    across = np.eye(3) - directions[:, :, None] * directions[:, None, :]
    weights = np.ones(len(rays))
    for _ in range(3):
        A, b = np.zeros((track_count, 3, 3)), np.zeros((track_count, 3))
        np.add.at(A, tracks, weights[:, None, None] * across)
        np.add.at(b, tracks, weights[:, None] * np.einsum("nij,nj->ni", across, centres))
        A += 1e-12 * np.eye(3)  # a track of one ray has no solution, and too little parallax below
        points = np.linalg.solve(A, b[:, :, None])[:, :, 0]
        depths = np.linalg.norm(points[tracks] - centres, axis=1)
        weights = 1 / np.maximum(depths, MIN_DEPTH_M) ** 2
    local = np.einsum("nji,nj->ni", R, points[tracks] - centres)
    good = np.ones(track_count, bool)
    np.logical_and.at(good, tracks, (local[:, 2] > MIN_DEPTH_M) & (local[:, 2] < MAX_DEPTH_M))
    errors = (local[:, :2] / np.maximum(local[:, 2:], MIN_DEPTH_M) - rays) * focal
    total = np.bincount(tracks, (errors**2).sum(axis=1), track_count)
    good &= total < options.max_error**2 * np.bincount(tracks, minlength=track_count)
    first = np.zeros((track_count, 3))
    first[tracks[::-1]] = directions[::-1]  # the first ray of each track is written last
    cosine = np.ones(track_count)
    np.minimum.at(cosine, tracks, np.einsum("ni,ni->n", first[tracks], directions))
    return points, good & (cosine < math.cos(math.radians(options.min_parallax_deg)))


def stereo_rays(frame, pixels, camera, stereo):
    """Indices of the pixels that the second camera sees, too, their rays in it, and its pose."""
    path = os.path.join(stereo.images, os.path.basename(frame.path))
    there, good = flow(read_grey(frame.path, camera), read_grey(path, stereo.camera), pixels)
    return np.flatnonzero(good), normalised(there[good], stereo.camera), frame.T_W_B @ stereo.camera.T_B_C


def keyframe_points(frames, observations, rays, keyframe, camera, stereo, options):
    """(ids, pixels, rays, world points) of one keyframe, from its tracks in the frames around it."""
    now = observations[keyframe]
    seconds = np.array([(f.stamp - frames[keyframe].stamp) * 1e-9 for f in frames])
    around = np.flatnonzero((seconds >= -options.window) & (seconds <= options.window / 4))
    tracks, poses, all_rays = [], [], []
    for i in around:
        common, here, there = np.intersect1d(now.ids, observations[i].ids, return_indices=True)
        tracks.append(here)
        all_rays.append(rays[i][there])
        poses.append(np.repeat((frames[i].T_W_B @ camera.T_B_C)[None], len(common), axis=0))
    if stereo and len(now.ids):
        common, seen, pose = stereo_rays(frames[keyframe], now.pixels, camera, stereo)
        tracks.append(common)
        all_rays.append(seen)
        poses.append(np.repeat(pose[None], len(common), axis=0))
    tracks, all_rays, poses = (np.concatenate(v) for v in (tracks, all_rays, poses))
    points, good = triangulate(len(now.ids), tracks, poses, all_rays, camera.K[0, 0], options)
    depth_path = beside(frames[keyframe].path, ".depth.png")
    if options.depth and os.path.isfile(depth_path):
        T_W_C = frames[keyframe].T_W_B @ camera.T_B_C
        points, good = lift(depth_path, now.pixels, rays[keyframe], T_W_C, camera)
    return now.ids[good], now.pixels[good], rays[keyframe][good], points[good]


def lift(depth_path, pixels, rays, T_W_C, camera):
    """World points of pixels by a depth map (16 bit, millimetres, 0 and 65535 unknown, registered to the image)."""
    depth = cv2.imread(depth_path, cv2.IMREAD_UNCHANGED)
    if depth is None or depth.dtype != np.uint16 or depth.shape[::-1] != camera.size:
        raise UserError(f"{depth_path}: expected a 16 bit depth map of {camera.size[0]} x {camera.size[1]} px")
    x, y = np.rint(pixels).astype(int).T
    z = depth[y, x] * 1e-3
    local = np.column_stack([rays * z[:, None], z])
    return local @ T_W_C[:3, :3].T + T_W_C[:3, 3], (z > MIN_DEPTH_M) & (depth[y, x] != 65535)

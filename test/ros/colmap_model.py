#!/usr/bin/python3
"""colmap_model.py FLIGHT OUT SCALE: what COLMAP would make of a simulated flight's images: a model in text form whose
world is turned, moved and in units of SCALE metres."""

import os
import sys

import cv2
import numpy as np

R_N_W = cv2.Rodrigues(np.array([0.9, -1.3, 0.4]))[0]
T_N_W = np.array([7, -3, 2])  # [m]


def rotation(q):
    """Matrix of a quaternion (x, y, z, w)."""
    x, y, z, w = q / np.linalg.norm(q)
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def quaternion(R):
    """(x, y, z, w) of a matrix."""
    vector = cv2.Rodrigues(R)[0].ravel()
    angle = np.linalg.norm(vector)
    axis = vector / angle if angle > 0 else vector
    return np.append(np.sin(angle / 2) * axis, np.cos(angle / 2))


def stamp_ns(text):
    seconds, _, fraction = text.partition(".")
    return int(seconds) * 10**9 + int(fraction.ljust(9, "0")[:9])


def read_truth(flight):
    """Stamps [ns], positions and quaternions (x, y, z, w) of the body."""
    rows = []
    with open(os.path.join(flight, "groundtruth.txt"), encoding="utf-8") as file:
        for line in file:
            cells = line.split()
            if cells and not line.startswith("#"):
                rows.append((stamp_ns(cells[0]), np.array(cells[1:4], float), np.array(cells[4:8], float)))
    return rows


def write_model(flight, folder, stamps, scale):
    """A model of the images at the given stamps [ns]."""
    camera = cv2.FileStorage(os.path.join(flight, "camera.yaml"), cv2.FILE_STORAGE_READ)
    R_B_C, t_B_C = camera.getNode("extrinsicRotation").mat(), camera.getNode("extrinsicTranslation").mat().ravel()
    size = [int(camera.getNode(key).real()) for key in ("image_width", "image_height")]
    fx, fy, cx, cy = (camera.getNode("projection_parameters").getNode(k).real() for k in ("fx", "fy", "cx", "cy"))
    distortion = [camera.getNode("distortion_parameters").getNode(k).real() for k in ("k1", "k2", "p1", "p2")]
    truth = read_truth(flight)
    images = []
    for number, stamp in enumerate(stamps):
        _, p, q = min(truth, key=lambda row, stamp=stamp: abs(row[0] - stamp))
        R_N_C = R_N_W @ rotation(q) @ R_B_C
        t_N_C = (R_N_W @ (p + rotation(q) @ t_B_C) + T_N_W) / scale
        x, y, z, w = quaternion(R_N_C.T)
        t = -R_N_C.T @ t_N_C
        images += ["%d %s 1 %d.png" % (number + 1, " ".join("%.9f" % v for v in (w, x, y, z, *t)), stamp), ""]
    os.makedirs(folder, exist_ok=True)
    # COLMAP's pixels begin half a pixel earlier.
    numbers = " ".join("%.9g" % v for v in (fx, fy, cx + 0.5, cy + 0.5, *distortion))
    for name, lines in (("cameras.txt", ["1 OPENCV %d %d %s" % (*size, numbers)]), ("points3D.txt", []),
                        ("images.txt", images)):
        with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
            file.writelines(line + "\n" for line in lines)
    return folder


if __name__ == "__main__":
    names = sorted(os.listdir(os.path.join(sys.argv[1], "images")))
    write_model(sys.argv[1], sys.argv[2], [int(os.path.splitext(name)[0]) for name in names], float(sys.argv[3]))

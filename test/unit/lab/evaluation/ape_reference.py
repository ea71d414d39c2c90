#!/usr/bin/python3
"""ape_reference.py [TOOL]: the absolute position error by numpy alone, to compare ours with.

Poses are paired as evo pairs them (each of the shorter trajectory with the nearest of the longer one, at most 10 ms
away), aligned by Umeyama's least squares (PAMI 1991: the rotation from the singular value decomposition of the
covariance), by yaw and position alone (a search over the angle), or not at all; statistics are numpy's. Without TOOL it
prints what ape_test.cpp expects; with it, `TOOL ape` must give the same numbers to 1e-6 for trajectories of TUM files.
"""

import json
import os
import subprocess
import sys
import tempfile

try:
    import numpy as np
except ImportError:
    print("skipped: no numpy")
    sys.exit(77)

TRUTH = np.array([[0, 0, 0], [1, 0.2, 0], [2, 0.1, 0.5], [3, 1, 1], [2.5, 2, 1.5]])
ESTIMATE = np.array([[5, 1, 0.1], [5.1, 2.1, 0], [4.9, 3, 0.6], [4.1, 4.2, 0.9], [3, 3.5, 1.7]])


def rotate_z(angle):
    return np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])


def align(truth, estimate, kind):
    if kind == "none":
        return estimate
    a, b = truth - truth.mean(0), estimate - estimate.mean(0)
    if kind == "se3":
        u, _, vt = np.linalg.svd(a.T @ b)
        rotation = u @ np.diag([1, 1, np.sign(np.linalg.det(u) * np.linalg.det(vt))]) @ vt
    else:
        # The cost is a sinusoid of the angle: three samples give its phase.
        cost = [np.sum((a - b @ rotate_z(angle).T) ** 2) for angle in (0, np.pi / 2, np.pi)]
        middle = (cost[0] + cost[2]) / 2
        rotation = rotate_z(np.arctan2(middle - cost[1], middle - cost[0]))
    return b @ rotation.T + truth.mean(0)


def statistics(truth, estimate, kind):
    errors = np.linalg.norm(truth - align(truth, estimate, kind), axis=1)
    return {"max": errors.max(), "mean": errors.mean(), "median": np.median(errors), "min": errors.min(),
            "rmse": np.sqrt(np.mean(errors ** 2))}


def pair(truth, estimate):
    """Rows `stamp x y z ...` of both that belong together."""
    swap = len(estimate) <= len(truth)
    shorter, longer = (estimate, truth) if swap else (truth, estimate)
    nearest = np.array([np.argmin(np.abs(longer[:, 0] - stamp)) for stamp in shorter[:, 0]])
    close = np.abs(longer[nearest, 0] - shorter[:, 0]) <= 0.01
    chosen = shorter[close], longer[nearest[close]]
    return (chosen[1], chosen[0]) if swap else chosen


def write_flight(directory, seed):
    """A wavy flight at 200 Hz, and a drifting, tilted estimate of it at about 7 Hz, some of it outside the truth."""
    random = np.random.default_rng(seed)
    stamps = 1600000000 + np.arange(0, 60, 0.005)
    t = np.arange(len(stamps)) * 0.005
    truth = np.stack([3 * np.cos(0.3 * t), 4 * np.sin(0.2 * t), 1 + 0.5 * np.sin(t)], 1)
    picks = np.sort(random.choice(len(stamps), 400, replace=False))
    drift = np.cumsum(random.normal(0, 0.005, (len(picks), 3)), 0)
    angle = 0.8 * seed
    tilt = np.array([[1, 0, 0], [0, np.cos(0.05), -np.sin(0.05)], [0, np.sin(0.05), np.cos(0.05)]])
    estimate = (truth[picks] + drift) @ (rotate_z(angle) @ tilt).T + np.array([5, -3, 1])
    files = [os.path.join(directory, name) for name in ("truth.txt", "estimate.txt")]
    rows = (np.column_stack([stamps, truth]), np.column_stack([stamps[picks] + random.uniform(-0.002, 0.002, 400), estimate]))
    rows[1][-5:, 0] += 1000
    for file, table in zip(files, rows):
        np.savetxt(file, np.column_stack([table, np.zeros((len(table), 3)), np.ones(len(table))]),
                   fmt=["%.6f"] + ["%.9f"] * 7)
    return files


def compare(tool, truth_file, estimate_file):
    """The largest difference between the tool's numbers and numpy's, of all alignments."""
    truth, estimate = pair(np.loadtxt(truth_file), np.loadtxt(estimate_file))
    largest = 0
    for kind in ("se3", "yaw", "none"):
        with tempfile.NamedTemporaryFile() as out:
            subprocess.run([tool, "ape", truth_file, estimate_file, "--align", kind, "--json", out.name],
                           check=True, stdout=subprocess.DEVNULL)
            ours = json.load(open(out.name))
        assert ours["poses"] == len(truth), (ours["poses"], len(truth))
        for key, value in statistics(truth[:, 1:4], estimate[:, 1:4], kind).items():
            largest = max(largest, abs(ours[key] - value))
            print(f"{kind:>5} {key:>6} {value:.9f} {ours[key]:.9f}")
    return largest


def main(arguments):
    if not arguments:
        for kind in ("se3", "yaw", "none"):
            print(kind, {key: round(float(value), 12) for key, value in statistics(TRUTH, ESTIMATE, kind).items()})
        return
    if len(arguments) == 3:  # two files of one's own
        print(f"largest difference {compare(*arguments):.1e} m")
        return
    for seed in (1, 2):
        with tempfile.TemporaryDirectory() as directory:
            difference = compare(arguments[0], *write_flight(directory, seed))
            assert difference < 1e-6, difference


if __name__ == "__main__":
    main(sys.argv[1:])

#!/usr/bin/python3
"""browser_test.py TOOL BROWSER: the HTML report renders in a headless browser, in light, dark and on a phone,
without a word on the console and without scrolling sideways."""

import json
import math
import os
import re
import subprocess
import sys
import tempfile

SKIPPED = 77
COLUMNS = "stamp_current_ns,stamp_old_ns,tx,ty,tz,qx,qy,qz,qw,score,inliers,virtual,accepted,reason"


def write_run(directory, drift, loops):
    """Two rounds of a circle, with `loops` right loops from the second to the first."""
    os.makedirs(directory)
    start = 1600000000

    def pose(i, offset):
        angle = 2 * math.pi * i / 40
        x, y = 3 * math.cos(angle) + offset, 3 * math.sin(angle)
        return f"{start + i}.0 {x:.6f} {y:.6f} 1.0 0 0 {math.sin(angle / 2):.6f} {math.cos(angle / 2):.6f}\n"

    for name, rate in (("trajectory.txt", drift / 10), ("vio.txt", drift)):
        with open(os.path.join(directory, name), "w") as file:
            file.writelines(pose(i, rate * i) for i in range(80))
    with open(os.path.join(directory, "loops.csv"), "w") as file:
        file.write(COLUMNS + "\n")
        for i in range(loops):
            file.write(f"{start + 40 + i}000000000,{start + i}000000000,0,0,0,0,0,0,1,0.5,40,{i % 2},1,accepted\n")
    with open(os.path.join(directory, "sweep.csv"), "w") as file:
        file.write("r,found,correct,precision,recall\n0.9,1,1,1.0,0.1\n0.5,8,6,0.75,0.6\n")
    with open(os.path.join(directory, "matches.csv"), "w") as file:
        file.write("stamp_current_ns,stamp_old_ns,virtual,view,u_old,v_old,u_current,v_current\n")
        for view in (-1, -1, 2):
            file.write(f"{start + 41}000000000,{start + 1}000000000,1,{view},100,{200 + view},150,220\n")
    return [pose(i, 0) for i in range(80)]


def write_evaluation(directory):
    truth = write_run(os.path.join(directory, "no_virtual"), 0.01, 5)
    write_run(os.path.join(directory, "virtual"), 0.01, 12)
    write_run(os.path.join(directory, "weights_text"), 0.01, 7)
    variants = [
        {"name": name, "command": f"deja_view replay --out {name}", "recall": recall, "cpu_s": 1.5}
        for name, recall in (("no_virtual", 0.5), ("virtual", 0.75), ("weights_text", 0.5))
    ]
    with open(os.path.join(directory, "evaluation.json"), "w") as file:
        json.dump({"variants": variants}, file)
    truth_file = os.path.join(directory, "truth.txt")
    with open(truth_file, "w") as file:
        file.writelines(truth)
    return truth_file


def render(browser, page, profile, *options):
    """The page's DOM as the browser sees it, and what it said."""
    result = subprocess.run(
        [browser, "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={profile}",
         "--enable-logging=stderr", "--log-level=0", "--dump-dom", *options, f"file://{page}"],
        capture_output=True, text=True, timeout=90,
    )
    assert result.returncode == 0, result.stderr
    return result.stdout, result.stderr


def main(tool, browser):
    if not browser or browser.endswith("-NOTFOUND"):
        print("skipped: no chromium in PATH (scripts/install_dependencies --dev brings it)")
        return SKIPPED
    with tempfile.TemporaryDirectory() as directory:
        evaluation = os.path.join(directory, "evaluation")
        truth = write_evaluation(evaluation)
        page = os.path.join(directory, "report.html")
        table = os.path.join(directory, "table.json")
        with open(table, "w") as file:
            json.dump([["poses", "PSNR"], ["colmap", 27.5]], file)
        subprocess.run([tool, "report", "--evaluation", evaluation, "--groundtruth", truth, "--html", page,
                        "--table", f"Table 2={table}", "--ran", "roslaunch a b:='c d'"],
                       check=True, stdout=subprocess.DEVNULL)
        # A probe that the report itself has not: how wide the page becomes.
        probed = os.path.join(directory, "probed.html")
        with open(page) as source, open(probed, "w") as target:
            target.write(source.read().replace(
                "</body>", "<script>document.title = 'width ' + document.documentElement.scrollWidth;</script></body>"))
        profile = os.path.join(directory, "profile")
        for options in ((), ("--force-dark-mode", "--enable-features=WebContentsForceDark")):
            dom, said = render(browser, page, profile, *options)
            assert "CONSOLE" not in said, said
            # Three runs' trajectories and loops, errors, their statistics, counts, detections; the matches of two
            # runs; two figures of the sweep.
            assert dom.count('<svg class="figure"') == 14, dom.count("<svg")
            assert dom.count("<table>") == 3
            for text in ("Matched images", "virtual view 2 of the place, 1 inlier", "Keyframes with a loop",
                         "The threshold r", "27.5", "roslaunch a b:='c d'"):
                assert text in dom, text
            assert "NaN" not in dom and "undefined" not in dom
        dom, _ = render(browser, probed, profile, "--window-size=500,900")
        width = int(re.search(r"width (\d+)", dom).group(1))
        assert width <= 500, f"the page is {width} px wide in a window of 500"
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2] if len(sys.argv) > 2 else ""))

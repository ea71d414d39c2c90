#!/usr/bin/python3
"""browser_test.py TOOL BROWSER: the HTML report renders in a headless browser, in light, dark and on a phone,
without a word on the console, without scrolling sideways, and with text that stands out from the page."""

import html
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
    with open(os.path.join(directory, "detections.csv"), "w") as file:
        file.write("stamp_current_ns,stamp_old_ns,score,correct,revisit\n")
        for i, (score, correct) in enumerate(((0.9, 1), (0.5, 0))):
            file.write(f"{start + 40 + i}000000000,{start + i}000000000,{score},{correct},1\n")
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


# What the report has not: a probe that tells the page's width, its colour, and the least contrast of its texts (WCAG
# 2.1) with where it is. Text in figures has its colour as fill.
PROBE = """<script>
function rgb(text) { return text.match(/[0-9.]+/g).map(Number); }
function luminance(c) {
  const [r, g, b] = c.map(v => v / 255).map(v => v <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
}
const page = rgb(getComputedStyle(document.body).backgroundColor);
let least = 99, where = '', seen = 0;
for (const element of document.querySelectorAll('h1,h2,h3,p,li,th,td,code,figcaption,text')) {
  if (!element.textContent.trim() || !element.getClientRects().length) continue;
  const style = getComputedStyle(element);
  const text = rgb(element.tagName === 'text' ? style.fill : style.color);
  const [a, b] = [luminance(text.slice(0, 3)), luminance(page.slice(0, 3))].sort().reverse();
  const contrast = (a + 0.05) / (b + 0.05);
  ++seen;
  if (contrast < least) { least = contrast; where = element.tagName + ' ' + element.getAttribute('class'); }
}
parent.postMessage(JSON.stringify({width: document.documentElement.scrollWidth, window: innerWidth, page, least, where,
                                   seen}), '*');
</script></body>"""

# A browser's window has a least width, wider than a phone; a frame has none.
FRAME = """<!DOCTYPE html><html><head><style>:root{{color-scheme:light dark}}</style><title></title></head><body>
<script>addEventListener('message', event => {{ document.title = event.data; }});</script>
<iframe src="{page}" width="{width}" height="900" style="border:0"></iframe></body></html>"""


def render(browser, page, profile, *options):
    """The page's DOM as the browser sees it, and what it said."""
    result = subprocess.run(
        [browser, "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", f"--user-data-dir={profile}",
         "--enable-logging=stderr", "--log-level=0", "--dump-dom", *options, f"file://{page}"],
        capture_output=True, text=True, timeout=90,
    )
    assert result.returncode == 0, result.stderr
    return result.stdout, result.stderr


def check_look(browser, page, profile, is_dark, width):
    """Shows the page, which has the probe, in the reader's colours and a window of that width."""
    frame = os.path.join(os.path.dirname(page), "frame.html")
    with open(frame, "w") as file:
        file.write(FRAME.format(page=os.path.basename(page), width=width))
    dom, said = render(browser, frame, profile, f"--blink-settings=preferredColorScheme={0 if is_dark else 1}",
                       "--window-size=1400,1000", "--virtual-time-budget=5000")
    assert "CONSOLE" not in said, said
    found = json.loads(html.unescape(re.search("<title>(.*?)</title>", dom).group(1)))
    assert (max(found["page"][:3]) < 60) == is_dark, f"the page's colour is {found['page']}"
    assert found["window"] == width, f"the window is {found['window']} px wide instead of {width}"
    assert found["width"] <= width, f"the page is {found['width']} px wide in a window of {width}"
    assert found["seen"] > 50, found
    assert found["least"] > 4.5, f"contrast {found['least']:.2f} of {found['where']}"


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
        profile = os.path.join(directory, "profile")
        dom, said = render(browser, page, profile)
        assert "CONSOLE" not in said, said
        # Three runs' trajectories and loops, errors, their statistics, counts, detections; the matches of two runs;
        # the scores of one sweep and two figures of it.
        assert dom.count('<svg class="figure"') == 15, dom.count("<svg")
        assert dom.count("<table>") == 4
        for text in ("Matched images", "virtual view 2 of the place, 1 inlier", "Keyframes with a loop",
                     "Scores: weights_text; r = 0.900 for precision 1", "27.5", "roslaunch a b:='c d'"):
            assert text in dom, text
        assert "NaN" not in dom and "undefined" not in dom
        probed = os.path.join(directory, "probed.html")
        with open(page) as source, open(probed, "w") as target:
            target.write(source.read().replace("</body>", PROBE))
        for is_dark in (False, True):
            for width in (1200, 390):
                check_look(browser, probed, profile, is_dark, width)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2] if len(sys.argv) > 2 else ""))

"""The paper's tables with this package's figures, for reproduce_paper."""

# Where the paper's tables and figures are on the page.
PLACES = [
    ["the paper's", "here"],
    ["Tables 2 to 8", "the tables of these numbers"],
    ["Figure 6", "the table of this number; Matched images"],
    ["Figures 7, 8", "Loops over time and Keyframes with a loop: rows no_virtual, virtual_paper; orb_..."],
    ["Figure 9", "Matched images: virtual_paper"],
    ["Figures 10, 15", "Trajectories: both methods beside the true path, BRIEF; ORB (orb_...)"],
    ["Figures 11, 16", "Position error over time"],
    ["Figures 12, 13, 17, 18", "Position errors"],
    ["Figures 14, 19", "Trajectories: coloured by the error"],
    ["Figure 20", "Thresholds: Places found over the threshold r (scores summed, as the paper's)"],
]


def number(value, digits):
    return f"{value:.{digits}f}" if isinstance(value, (int, float)) else "–"


def loop_table(base, views):
    rows = [["method", "loops", "correct", "precision", "recall"]]
    for name, v in (("without virtual views", base), ("with virtual views", views)):
        rows.append([name, v["loops_accepted"], number(v["loops_correct"], 0), number(v["precision"], 4),
                     number(v["recall"], 3)])
    return rows


def error_table(base, views):
    rows = [["method", "max [m]", "min [m]", "mean [m]", "RMSE [m]"]]
    if base.get("vio_ape_mean_m") is not None:
        rows.append(["odometry alone", number(base["vio_ape_max_m"], 4), "–", number(base["vio_ape_mean_m"], 4),
                     number(base["vio_ape_rmse_m"], 4)])
    for name, v in (("without virtual views", base), ("with virtual views", views)):
        rows.append([name] + [number(v[f"ape_{key}_m"], 4) for key in ("max", "min", "mean", "rmse")])
    return rows


def cost_table(variants, key, unit, digits):
    rows = [["features", f"without [{unit}]", f"with [{unit}]", "more [%]"]]
    for name, base, views in (("BRIEF", "no_virtual", "virtual_paper"), ("ORB", "orb_no_virtual", "orb_virtual_paper")):
        before, after = variants[base][key], variants[views][key]
        rows.append([name, number(before, digits), number(after, digits), number(100 * (after / before - 1), 1)])
    return rows


def paper_tables(evaluation, poses, check, sources):
    """The paper's tables by caption, as rows with the head first."""
    variants = {entry["name"]: entry for entry in evaluation["variants"]}
    brief = variants["no_virtual"], variants["virtual_paper"]
    orb = variants["orb_no_virtual"], variants["orb_virtual_paper"]
    matches = [["virtual view", "views", "visible corners", "matched", "correct", "precision"]]
    for name, entry in check.items():
        if isinstance(entry, dict) and "correct" in entry:
            matches.append([name.replace("_", " "), entry["views"]]
                           + [number(entry[key], 1) for key in ("visible", "matched", "correct")]
                           + [number(entry["precision"], 3)])
    return {
        "Where the paper's tables and figures are": PLACES,
        "Table 2: sources of poses, fields trained for the same number of steps": [
            ["poses", "PSNR [dB]", "SSIM"],
            *([source["name"], number(source["psnr_db"], 2), number(source["ssim"], 4)]
              for source in poses["sources"]),
            *([name, "does not fit the truth", "–"]
              for name in sources if name not in [source["name"] for source in poses["sources"]]),
        ],
        "Table 3: loops on VINS-Mono's odometry, BRIEF (Figures 7 and 9 below)": loop_table(*brief),
        "Table 4: loops on the same odometry, ORB (Figure 8 below)": loop_table(*orb),
        "Table 5: position errors, BRIEF (Figures 10 to 14 below)": error_table(*brief),
        "Table 6: position errors, ORB (Figures 15 to 19 below)": error_table(*orb),
        "Table 7: processor time of loop closing": cost_table(variants, "cpu_s", "s", 2),
        "Table 8: peak memory": cost_table(variants, "peak_rss_mb", "MB", 1),
        "Figure 6: matches between real images and virtual views, per view": matches,
    }

#!/usr/bin/env python3
"""Checks that measurements are plausible and that their report is whole.

check_report.py <folder of results> <report>

Times are the machine's: their bounds hold on a busy one, too. All bounds hold for 20 frames
and for 1000.
"""

import base64
import io
import math
import pathlib
import re
import sys
from collections import Counter

import paper_values
from lidar_noise_section import check_lidar_noise
from motion_section import check_motion
from noise_results import (BANDS, FILTER, FILTER_OF_EACH, FILTER_ON_VOXELS, FILTERS, METHODS,
                           best_law, least_let_through)
from results import (CAMERAS, CODERS, LIDAR, MERGED, RATES, ReportError, read_machine,
                     read_results, read_rows)
from temporal_section import check_temporal

# Quantities that may be below 0.
SIGNED = ("threshold", "best_threshold", "usual_threshold", "less_percent")
PEERS = ("StatisticalOutlierRemoval", "RadiusOutlierRemoval")


class Checks:
    """Collects what is not as it should be."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.results = read_results(folder)
        self.rows = {name: read_rows(folder, name + ".csv")
                     for name in ("laws", "cell_points", "cell_voxels", "octree_points",
                                  "octree_voxels", "lidar_in_snow")}
        self.machine = read_machine(folder)
        self.problems = []

    def that(self, holds, *what):
        if not holds:
            self.problems.append(" ".join(map(str, what)))

    def between(self, value, least, most, *what):
        self.that(least <= value <= most, *what, f"is {value:g}, not {least:g} to {most:g}")

    def near(self, value, wanted, share, *what):
        self.that(abs(value - wanted) <= share * abs(wanted), *what,
                  f"is {value:g}, not {wanted:g} to {100 * share:g} %")

    def mean(self, *key):
        return self.results.mean(*key)

    def noise(self, sensor, method, quantity, cm=4):
        return self.mean("noise", sensor, method, cm, quantity)


def check_values(check):
    """Every single value."""
    for key, value in check.results.by_key.items():
        check.that(math.isfinite(value.mean) and math.isfinite(value.deviation), key,
                   "is not finite")
        check.that(value.deviation >= 0.0 and value.samples > 0, key, "has no samples")
        check.that(value.samples > 1 or value.deviation == 0.0, key,
                   "has a deviation of one sample")
        # Memory that other nodes freed offsets a part of what a node allocated.
        least = -1.0 if key[4] == "memory_mb" else 0.0
        if key[4] not in SIGNED:
            check.that(value.mean >= least, key, "is negative")
        if key[4].endswith("percent") and key[4] != "cpu_percent":
            check.that(value.mean <= 100.0, key, "is above 100 %")
        if key[0].startswith("noise") and re.search(r"(precision|recall|f1)$", key[4]):
            check.between(value.mean, 0, 1, key)
    for words in ("Processor: ", "cores", "memory: ", "system: ", "compiler: ", "PCL ",
                  "pcl_ext ", "load average"):
        check.that(words in check.machine, f"the machine's line lacks '{words}'")
    check.that(re.search(r"\b20\d\d-\d\d-\d\d\b", check.machine), "there is no date")


def check_cropping(check):
    """Section 3.1."""
    for sensor in CAMERAS + (LIDAR,):
        fewest, most = (2000, 28800) if sensor == LIDAR else (30000, 217088)
        subject = ("cropping", sensor, "SensorPreprocessor", 4)
        cropped, points = (check.mean(*subject, quantity)
                           for quantity in ("cropped_points", "points"))
        check.between(cropped, fewest, most, "cropped points of sensor", sensor)
        check.between(points, cropped, check.mean(*subject, "cloud_points"),
                      "points of sensor", sensor)
        check.near(check.mean(*subject, "kept_percent"), 100 * cropped / points, 0.02,
                   "share of cropped points, sensor", sensor)
    subject = ("cropping", "1", "SensorPreprocessor", 4)
    check.near(check.mean(*subject, "cloud_points"), paper_values.CROPPING["points"], 0,
               "points of Table 2")
    for quantity, words in (("cropped_points", "cropped points"),
                            ("cropping_ratio", "ratio")):
        check.near(check.mean(*subject, quantity), paper_values.CROPPING[words][0], 0.03,
                   words, "of Table 2")


def check_compression(check):
    """Section 3.2."""
    frames = check.mean("streams_run", "", "all", 0, "frames")
    experiments = ("compression", "quadratic", "linear", "resolution")
    for key, value in check.results.by_key.items():
        if key[0] in experiments + ("cropping", "depth_image"):
            check.that(value.samples == (min(frames, 100) if key[0] == "resolution"
                                         else frames), key, "is not of all frames")
        if key[0] in experiments and key[4] == "bytes":
            _check_stream(check, key[:4], value.mean)
    for cm, paper in paper_values.COMPRESSION.items():
        for coder in CODERS:
            check.near(check.mean("compression", "1", coder, cm, "voxels"),
                       paper["voxels"][0], 0.05, "voxels of sensor 1,", coder, cm, "cm")
        for quantity, words in (("bytes_per_voxel", "bytes per voxel"), ("ratio", "ratio")):
            check.near(check.mean("compression", "1", "published", cm, quantity),
                       paper[words][0], 0.1, words, "of published,", cm, "cm")
    for experiment, sensors, edges in (
            ("compression", CAMERAS, (4, 2)), ("quadratic", ("1",), (4,)),
            ("linear", ("1",), (4,)), ("resolution", ("1",), range(1, 21))):
        for sensor in sensors:
            for cm in edges:
                sizes = [check.mean(experiment, sensor, coder, cm, "bytes")
                         for coder in ("small", "balanced", "fast", "published")]
                check.that(sizes == sorted(sizes), "more effort takes more bytes:",
                           experiment, sensor, cm)
    for coder in CODERS:
        subject = ("1", coder, 4)
        for law in ("quadratic", "linear"):
            check.near(check.mean(law, *subject, "voxels"),
                       check.mean("compression", *subject, "voxels"), 0, "voxels of", law)
            check.between(check.mean(law, *subject, "bytes")
                          / check.mean("compression", *subject, "bytes"), 1, 3,
                          "bytes of", law, "against those of count,", coder)
        for cm in range(1, 11):
            check.that(check.mean("resolution", "1", coder, cm, "voxels")
                       > 1.1 * check.mean("resolution", "1", coder, 2 * cm, "voxels"),
                       "half the edge makes no more voxels:", coder, cm)


def _check_stream(check, subject, size):
    """Bytes, voxels, ratio and bandwidth of a stream fit each other."""
    points = check.mean("cropping", subject[1], "SensorPreprocessor", 4, "cropped_points")
    check.near(check.mean(*subject, "bytes_per_voxel"),
               size / check.mean(*subject, "voxels"), 0.05, "bytes per voxel", subject)
    # The mean of a quotient is not the quotient of the means.
    check.near(check.mean(*subject, "ratio"), 16 * points / size, 0.15, "ratio", subject)
    check.near(check.mean(*subject, "megabits_per_second"),
               8e-6 * size * RATES[subject[1]], 0.001, "Mbit/s", subject)


def check_depth_images(check):
    """Section 3.2, depth images."""
    coders = check.results.coders("depth_image")
    check.that(len(coders) == 7, "coders of depth images:", coders)
    for coder in coders:
        subject = ("depth_image", "1", coder, 0)
        size = check.mean(*subject, "bytes")
        check.near(check.mean(*subject, "megabits_per_second"), 8e-6 * size * RATES["1"],
                   0.001, "Mbit/s", coder)
        check.that(size > check.mean("compression", "1", "published", 4, "bytes"), coder,
                   "is smaller than voxels")
        wrong, error = (check.mean(*subject, quantity)
                        for quantity in ("wrong_percent", "error_mm"))
        if coder.startswith("JPEG"):
            check.between(wrong, 1, 100, "wrong pixels,", coder)
            # A step is 51 mm: rounding alone makes 15.
            check.between(error, 10, 5000, "depth error,", coder)
        else:
            check.that(wrong == error == 0.0, coder, "is not lossless")
    for coder, paper in (("raw 16 bits", "raw MB"), ("PNG 16 bits", "compressed MB")):
        check.near(1e-6 * check.mean("depth_image", "1", coder, 0, "bytes"),
                   paper_values.DEPTH_IMAGE[paper], 0.1, "MB of", coder)


def check_at_once(check):
    """Section 3.3. On a busy machine frames are late, but none is lost."""
    rates = {f"cell_sensor_{sensor}": rate for sensor, rate in RATES.items()}
    rates["central"] = sum(RATES.values())
    check.that(check.results.sensors("at_once") == list(rates), "nodes are missing")
    for coder in CODERS:
        def value(node, quantity, coder=coder):
            return check.mean("at_once", node, coder, 4, quantity)
        for node, rate in rates.items():
            check.between(value(node, "frames_per_second"), rate / 20, 3 * rate,
                          "frames per second,", node, coder)
            for quantity in ("megabits_per_second", "cpu_percent", "cycle_ms"):
                check.that(value(node, quantity) > 0.0, quantity, "of", node, coder, "is 0")
        voxels = 0.0
        for sensor in RATES:
            node = f"cell_sensor_{sensor}"
            alone = check.mean("compression", sensor, coder, 4, "bytes")
            # Of few frames another share are I-frames.
            check.between(value(node, "megabits_per_second") / 8e-6
                          / value(node, "frames_per_second"), alone / 4, alone * 4,
                          "bytes of a frame at once,", node, coder)
            voxels += check.mean("compression", sensor, coder, 4, "voxels")
        # A voxel that several sensors see is one.
        check.between(value("central", "merged_voxels"), 0.15 * voxels, 1.02 * voxels,
                      "merged voxels,", coder)
        check.between(sum(value(node, "memory_mb") for node in rates), 1, 10000,
                      "MB of all nodes,", coder)


def check_noise(check):
    """Laws and filter on all sensors."""
    for sensor, methods in METHODS.items():
        check.that(tuple(check.results.coders("noise", sensor=sensor, resolution_cm=4.0))
                   == methods, "methods of sensor", sensor)
        for method in methods:
            subject = f"of {method}, sensor {sensor}"
            precision, recall, f1, area, share = (
                check.noise(sensor, method, quantity)
                for quantity in ("best_precision", "best_recall", "best_f1",
                                 "average_precision", "noise_percent"))
            check.near(f1, 2 * precision * recall / (precision + recall), 0.001, "F1",
                       subject)
            curve = [check.mean("noise_curve", sensor, method, 4, quantity)
                     for quantity in check.results.quantities("noise_curve", sensor=sensor)]
            check.that(len(curve) == 50, "the curve has", len(curve), "steps,", subject)
            check.between(area, sum(curve) / len(curve) - 0.05,
                          sum(curve) / len(curve) + 0.05, "average precision", subject)
            check.between(share, *((0.1, 10) if sensor == LIDAR else (3, 30)), "noise %",
                          subject)
            _check_thresholds(check, sensor, method)
    for sensor in CAMERAS + (MERGED,):
        law = check.noise(sensor, best_law(check.results, sensor), "average_precision")
        let_through = least_let_through(check.results, sensor)
        for method in METHODS[sensor]:
            if method.startswith("filter"):
                check.between(check.noise(sensor, method, "average_precision"),
                              max(0.75, law + 0.15), 1, "average precision of", method,
                              sensor)
                check.between(check.noise(sensor, method, "usual_let_through_percent"),
                              0.1, 0.5 * let_through, "noise let through,", method, sensor)
    check.that(check.noise(MERGED, FILTER_OF_EACH, "average_precision")
               > check.noise(MERGED, FILTER, "average_precision"),
               "filtering after merging is better than before")
    for cm in (1, 2):
        law = check.noise("1", best_law(check.results, "1", cm), "average_precision", cm)
        check.between(check.noise("1", FILTER, "average_precision", cm),
                      max(0.7, law + 0.15), 1, "average precision at", cm, "cm")
    for cm, least in ((4, 0.1), (10, 0.05), (20, 0.02)):
        check.between(check.noise(LIDAR, FILTER_ON_VOXELS, "average_precision", cm), least,
                      0.7, "average precision of the lidar at", cm, "cm")
        check.between(check.mean("noise_threshold:0.0", LIDAR, FILTER_ON_VOXELS, cm,
                                 "surface_kept_percent"), 99.5, 100,
                      "surfaces kept of the lidar at", cm, "cm")
    for sensor in CAMERAS:
        for method in FILTERS:
            check.between(check.noise(sensor, method, "usual_surface_kept_percent"), 95,
                          95.5, "surfaces kept,", method, sensor)
        _check_bands(check, sensor)


def _check_thresholds(check, sensor, method):
    shares = [(float(threshold), share.mean)
              for threshold in check.results.experiments("noise_threshold:")
              if (share := check.results.find("noise_threshold:" + threshold, sensor, method,
                                              4, "let_through_percent"))]
    check.that(len(shares) > 5, "thresholds of", method, sensor)
    ordered = [share for _, share in sorted(shares)]
    check.that(ordered == sorted(ordered, reverse=True),
               "higher thresholds let more through:", method, sensor)


def _check_bands(check, sensor):
    all_noise = all_voxels = 0.0
    for band in BANDS:
        noise, surface = (check.mean("noise_band:" + band, sensor, FILTER, 4, quantity)
                          for quantity in ("noise_voxels", "surface_voxels"))
        all_noise, all_voxels = all_noise + noise, all_voxels + noise + surface
        if noise and surface:
            for method in METHODS[sensor]:
                check.mean("noise_band:" + band, sensor, method, 4, "average_precision")
    check.near(100 * all_noise / all_voxels, check.noise(sensor, FILTER, "noise_percent"),
               0.001, "noise of all bands, sensor", sensor)


def check_person(check):
    """Moving surfaces are kept; not every sensor sees the person in the first second."""
    seen = 0
    for sensor in CAMERAS:
        for quantity in ("machine_kept_percent", "person_kept_percent"):
            kept = check.results.find("noise_threshold:0.0", sensor, FILTER, 4, quantity)
            if kept is not None:
                check.between(kept.mean, 85, 100, quantity, "of sensor", sensor)
        if not check.results.find("noise_threshold:0.0", sensor, FILTER, 4,
                                  "person_worst_percent"):
            continue
        seen += 1
        for threshold in ("0.0", "2.5"):
            poor, all_frames, worst, kept = (
                check.mean("noise_threshold:" + threshold, sensor, FILTER, 4,
                           "person_" + quantity)
                for quantity in ("poor_frames", "frames", "worst_percent", "kept_percent"))
            check.that(poor <= all_frames, "frames with the person, sensor", sensor)
            # Frames with few of the person's voxels are left out of the worst.
            check.that(worst <= kept + 3, "the worst frame of the person, sensor", sensor)
    check.that(seen, "no sensor sees the person")


def check_peers_and_bytes(check):
    """PCL's filters, and bytes where the sensor removes noise."""
    own = check.mean("noise_peers", "1", FILTER, 4, "average_precision")
    check.near(own, check.noise("1", FILTER, "average_precision"), 0.05,
               "average precision of the filter among its peers")
    peers = [name for name in check.results.coders("noise_peers") if name != FILTER]
    for family in PEERS:
        check.that(sum(name.startswith(family) for name in peers) >= 5, "few of", family)
    for name in peers:
        check.between(check.mean("noise_peers", "1", name, 4, "average_precision"), 0.2,
                      own - 0.02, "average precision of", name)
    for sensor, cm in (("1", 4), ("5", 2)):
        names = check.results.coders("noise_time", sensor=sensor)
        median, longest = ({name: check.mean("noise_time", sensor, name, cm, quantity)
                            for name in names} for quantity in ("median_ms", "longest_ms"))
        own = median["VoxelOutlierRemoval on quadratic"]
        check.that(sum(name.startswith(PEERS) for name in names) == 4, "timed filters")
        for name in names:
            # Ten times and more on a machine that does nothing else.
            check.that(median[name] > (2 * own if name.startswith(PEERS) else 0.0), name,
                       "is faster than twice the library's filter,", cm, "cm")
            check.that(longest[name] >= median[name], "longest time of", name)
    codings = check.results.experiments("noise_bytes:")
    check.that(codings == ["count fast", "count balanced", "quadratic fast",
                           "quadratic balanced"], "codings of noise_bytes:", codings)
    for coding in codings:
        def value(name, quantity, coding=coding):
            return check.mean("noise_bytes:" + coding, "1", name, 4, quantity)
        for name in ("log-odds 0", "log-odds 2.5", "the truth"):
            less = value(name, "less_percent")
            check.between(less, 5, 60, "bytes saved,", coding, name)
            check.near(less, 100 * (1 - value(name, "bytes") / value("none", "bytes")),
                       0.001, "bytes saved,", coding, name)
            check.that(value(name, "voxels") < value("none", "voxels"), "voxels,", name)


def check_pictures(check):
    """The points and voxels that the pictures show."""
    for row in check.rows["laws"]:
        check.near(row["cut_off_depth"], paper_values.CUT_OFF_DEPTH, 0.001, "cut-off depth")
        share = min(row["depth"] / row["cut_off_depth"], 1.0)
        for law, intensity in (("count", 1.0), ("linear", share), ("quadratic", share ** 2)):
            check.between(row[law], intensity - 0.001, intensity + 0.001, law,
                          "at", row["depth"], "m")
    points, voxels = check.rows["octree_points"], check.rows["octree_voxels"]
    check.between(len(voxels), 2, 7, "voxels of Figure 7")
    check.that(sum(voxel["count"] for voxel in voxels) == len(points), "points of Figure 7")
    voxels = check.rows["cell_voxels"]
    check.that(len(voxels) < len(check.rows["cell_points"]), "more voxels than points")
    all_of = Counter(int(row["sensor"]) for row in voxels)
    noise_of = Counter(int(row["sensor"]) for row in voxels if row["is_noise"])
    points_of = Counter(int(row["sensor"]) for row in check.rows["cell_points"])
    for sensor in CAMERAS + (LIDAR,):
        number = int(sensor)
        check.that(min(all_of[number], points_of[number]) > 1000, "Figure 11 lacks", sensor)
        if sensor != LIDAR:
            check.between(100 * noise_of[number] / max(all_of[number], 1), 2, 40,
                          "noise % in Figure 11, sensor", sensor)
    cameras = [row for row in voxels if int(row["sensor"]) != int(LIDAR)]
    for law, threshold in paper_values.FIGURE_11.items():
        removed = {}
        for is_noise in (0.0, 1.0):
            shown = [row[law] for row in cameras if row["is_noise"] == is_noise]
            removed[is_noise] = sum(value < threshold for value in shown) / max(len(shown), 1)
        check.that(removed[1.0] > 1.2 * removed[0.0] + 0.01, law, "removes no noise")
    # Both are rounded.
    check.that(all(row["linear"] + 1 >= row["quadratic"] for row in cameras),
               "a linear intensity is below the quadratic one")


def _ink(pixels):
    """Share of a picture that is not white."""
    return float((pixels[..., :3] < 0.98).any(axis=-1).mean())


def check_page(check, page):
    """The report itself."""
    from matplotlib import image  # the tests of this file do without it
    for source in re.findall(r'src="([^"]*)"', page):
        check.that(source.startswith("data:"), source[:80], "comes from elsewhere")
    linked = re.findall(r'href="[^"/]*_measurements/(figure_1[01]\.html)#[^"]*"', page)
    check.that(linked == ["figure_10.html", "figure_11.html"], "the page links", linked)
    check.that(page.count("href=") == len(linked), "the page links something else")
    for name in linked:
        viewer = check.folder / name
        check.that(viewer.is_file() and viewer.stat().st_size > 1_000_000, name, "is not there")
    check.that(not re.search(r"url\(|@import|<script|<link|<iframe", page),
               "the page loads something")
    check.that(not re.search(r"\b(?:nan|inf)\b", page), "a value is not finite")
    for words in ("Figure 5", "Figure 7", "Figure 10", "Figure 11", "Table 2", "Table 3",
                  "Table 4", "Table 5", "3.1 Preprocessing", "3.2 Compression",
                  "Depth images", "Moving sensors and people",
                  "3.3 Frequency and bandwidth", "3.4 Denoising",
                  "Processor: ", "Detection of noise", "What moves", "Against PCL's filters", "By distance",
                  "Thresholds, all cameras merged", "Noise of lidars", "Filter over time"):
        check.that(words in page, f"the page lacks '{words}'")
    pictures = re.findall(r'src="data:image/png;base64,([^"]+)" alt="([^"]*)"', page)
    check.that(len(pictures) == 9, "there are", len(pictures), "pictures")
    for encoded, description in pictures:
        pixels = image.imread(io.BytesIO(base64.b64decode(encoded)))
        check.that(pixels.shape[0] > 200 and pixels.shape[1] > 400
                   and _ink(pixels) > 0.02, f"'{description}' is blank")
        if not description.startswith("Top views"):
            continue
        height, width = (size // part for size, part in zip(pixels.shape, (2, 3)))
        for row, column in ((0, 0), (0, 1), (0, 2), (1, 0), (1, 1)):
            # The middle of a view, without its frame.
            view = pixels[row * height + height // 4:(row + 1) * height - height // 5,
                          column * width + width // 5:(column + 1) * width - width // 5]
            check.that(_ink(view) > 0.05, "a view of Figure 11 is blank:", row, column)


def problems_of(folder, page):
    """Sentences about all that is not plausible or not there."""
    check = Checks(folder)
    for run in (check_values, check_cropping, check_compression, check_motion,
                check_depth_images, check_at_once, check_noise, check_person,
                check_peers_and_bytes, check_lidar_noise, check_temporal, check_pictures,
                lambda checks: check_page(checks, page)):
        try:
            run(check)
        except ReportError as error:
            check.problems.append(str(error))
    return check.problems


def main(folder, report):
    try:
        problems = problems_of(folder, pathlib.Path(report).read_text(encoding="utf-8"))
    except (OSError, ReportError) as error:
        problems = [str(error)]
    for problem in problems[:20]:
        print(f"check_report.py: {problem}", file=sys.stderr)
    return 1 if problems else 0


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    sys.exit(main(sys.argv[1], sys.argv[2]))

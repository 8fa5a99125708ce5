#!/usr/bin/env python3
# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
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

import paper_values
from results import CAMERAS, CODERS, LIDAR, RATES, ReportError, read_results
from tables import (AIRS, DUST, FILTER, FILTERED, LIDAR_CM, POINT_FILTER, SNOW, best_law)

BY_EFFORT = ("small", "balanced", "fast", "published")


class Checks:
    """Collects what is not as it should be."""

    def __init__(self, results):
        self.results = results
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


def check_values(check):
    """Every single value."""
    for key, value in check.results.by_key.items():
        check.that(math.isfinite(value.deviation) and value.deviation >= 0.0
                   and value.samples > 0, key, "has no samples")
        # Thresholds of log-odds have any sign; memory that other nodes freed offsets a part
        # of what a node allocated.
        if not key[4].endswith("threshold"):
            check.that(value.mean >= (-1.0 if key[4] == "memory_mb" else 0.0)
                       and math.isfinite(value.mean), key, "is negative or not finite")
        if key[4].endswith("percent") and key[4] not in ("cpu_percent",
                                                         "of_unfiltered_percent"):
            check.that(value.mean <= 100.0, key, "is above 100 %")
        if re.search(r"(precision|recall|f1)$", key[4]):
            check.between(value.mean, 0, 1, key)
    check.that(re.match(r"Processor: .*cores; memory: .*compiler: .*pcl_ext .*\b20\d\d-\d\d-\d\d",
                        check.results.machine), "the machine is not described")


def check_streams(check):
    """Sections 3.1 and 3.2."""
    for quantity, words in (("cropped_points", "cropped points"),
                            ("cropping_ratio", "ratio")):
        check.near(check.mean("cropping", "1", "SensorPreprocessor", 4, quantity),
                   paper_values.CROPPING[words][0], 0.03, words, "of Table 2")
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
                         for coder in BY_EFFORT]
                check.that(sizes == sorted(sizes), "more effort takes more bytes:",
                           experiment, sensor, cm)


def check_depth_images(check):
    """Section 3.2, depth images."""
    for coder in check.results.names("depth_image", 2):
        wrong, error = (check.mean("depth_image", "1", coder, 0, quantity)
                        for quantity in ("wrong_percent", "error_mm"))
        if coder.startswith("JPEG"):
            # A step is 51 mm: rounding alone makes 15.
            check.between(error, 10, 5000, "depth error,", coder)
        else:
            check.that(wrong == error == 0.0, coder, "is not lossless")
    for coder, paper in (("raw 16 bits", "raw MB"), ("PNG 16 bits", "compressed MB")):
        check.near(1e-6 * check.mean("depth_image", "1", coder, 0, "bytes"),
                   paper_values.DEPTH_IMAGE[paper], 0.1, "MB of", coder)


def check_at_once(check):
    """Section 3.3. On a busy machine frames are late, but none is lost."""
    rate = len(CAMERAS) * RATES["1"]
    for coder in CODERS:
        check.between(check.mean("at_once", "central", coder, 4, "frames_per_second"),
                      rate / 20, 3 * rate, "frames per second,", coder)
        voxels = sum(check.mean("compression", sensor, coder, 4, "voxels")
                     for sensor in CAMERAS)
        # A voxel that several sensors see is one.
        check.between(check.mean("at_once", "central", coder, 4, "merged_voxels"),
                      0.15 * voxels, 1.02 * voxels, "merged voxels,", coder)


def check_noise(check):
    """Laws, the filter and PCL's on the cameras."""
    for sensor in CAMERAS:
        def noise(method, quantity, sensor=sensor):
            return check.mean("noise", sensor, method, 4, quantity)
        law = best_law(check.results, sensor)
        check.between(noise(FILTER, "noise_percent"), 3, 30, "noise % of sensor", sensor)
        check.between(noise(FILTER, "average_precision"),
                      max(0.75, noise(law, "average_precision") + 0.15), 1,
                      "average precision of the filter, sensor", sensor)
        check.between(noise(FILTER, "usual_let_through_percent"), 0.1,
                      0.5 * noise(law, "usual_let_through_percent"),
                      "noise let through, sensor", sensor)
        check.between(noise(FILTER, "usual_surface_kept_percent"), 95, 95.5,
                      "surfaces kept, sensor", sensor)
    peers = [name for name in check.results.names("noise", 2, "1") if "OutlierRemoval" in name]
    check.that(len(peers) == 4, "PCL's filters:", peers)
    for name in peers:
        check.between(check.mean("noise", "1", name, 4, "average_precision"), 0.2,
                      check.mean("noise", "1", FILTER, 4, "average_precision") - 0.02,
                      "average precision of", name)
        # Ten times and more on a machine that does nothing else.
        check.that(check.mean("noise", "1", name, 4, "median_ms")
                   > 2 * check.mean("noise", "1", FILTER, 4, "median_ms"), name,
                   "is faster than twice the library's filter")


def check_lidar_noise(check):
    """The filter finds snow and keeps surfaces."""
    for sensor, (fewest, most) in zip(AIRS, ((0.1, 3), (2, 10), (3, 15))):
        check.between(check.mean("lidar_points", sensor, POINT_FILTER, LIDAR_CM,
                                 "noise_percent"), fewest, most, "noise % of sensor", sensor)
        check.between(check.mean("lidar_points_threshold:0.0", sensor, POINT_FILTER, LIDAR_CM,
                                 "surface_kept_percent"), 99, 100, "surfaces kept of", sensor)
    check.between(check.mean("lidar_points_threshold:0.0", SNOW, POINT_FILTER, LIDAR_CM,
                             "let_through_percent"), 0, 30, "noise let through in snow")
    own, of_voxels = (check.mean("lidar_points", SNOW, method, LIDAR_CM, "average_precision")
                      for method in (POINT_FILTER, "filter on voxels"))
    check.between(own, max(0.85, of_voxels + 0.1), 1, "average precision in snow")
    check.that(DUST in check.results.names("lidar_points", 1), "there is no dust")


def check_temporal(check):
    """The filter saves bytes, shows the surfaces and adds no noise."""
    for sensor, words in FILTERED.items():
        def value(name, quantity, sensor=sensor):
            return check.mean("temporal", sensor, name, 4, quantity)
        # Points at the border of the crop box may fall on either side when they are moved.
        check.between(value("none", "surface_percent"), 99, 100, "unfiltered,", words)
        for name in ("temporal", "both"):
            check.between(value(name, "surface_percent"), 95, 100, "surfaces,", name, words)
            if sensor in CAMERAS:
                check.between(value(name, "of_unfiltered_percent"), 2, 60,
                              "bytes of unfiltered,", name, words)
        if sensor != LIDAR:
            check.that(value("temporal", "noise_percent") <= value("none", "noise_percent"),
                       "TemporalVoxelFilter adds noise,", words)


def check_page(check, folder, page):
    """The report itself."""
    from matplotlib import image  # the tests of this file do without it
    for source in re.findall(r'src="([^"]*)"', page):
        check.that(source.startswith("data:"), source[:80], "comes from elsewhere")
    linked = re.findall(r'href="[^"/]*_measurements/(figure_1[01]\.html)#[^"]*"', page)
    check.that(linked == ["figure_10.html", "figure_11.html"], "the page links", linked)
    check.that(page.count("href=") == len(linked), "the page links something else")
    for name in linked:
        viewer = pathlib.Path(folder) / name
        check.that(viewer.is_file() and viewer.stat().st_size > 1_000_000, name, "is not there")
    check.that(not re.search(r"url\(|@import|<script|<link|<iframe|\bnan\b|\binf\b", page),
               "the page loads something, or a value is not finite")
    for words in ("Figure 5", "Figure 7", "Figure 10", "Figure 11", "Table 2", "Table 3",
                  "Table 4", "Table 5", "3.1 Preprocessing", "3.2 Compression",
                  "Depth images", "3.3 Frequency and bandwidth", "3.4 Denoising",
                  "Detection of noise", "Noise of lidars", "Filter over time"):
        check.that(words in page, f"the page lacks '{words}'")
    pictures = re.findall(r'src="data:image/png;base64,([^"]+)" alt="([^"]*)"', page)
    check.that(len(pictures) == 6, "there are", len(pictures), "pictures")
    for encoded, description in pictures:
        pixels = image.imread(io.BytesIO(base64.b64decode(encoded)))
        # Share of the picture that is not white.
        ink = float((pixels[..., :3] < 0.98).any(axis=-1).mean())
        check.that(pixels.shape[0] > 200 and pixels.shape[1] > 400 and ink > 0.02,
                   f"'{description}' is blank")


def problems_of(folder, page):
    """Sentences about all that is not plausible or not there."""
    check = Checks(read_results(folder))
    for run in (check_values, check_streams, check_depth_images, check_at_once, check_noise,
                check_lidar_noise, check_temporal,
                lambda checks: check_page(checks, folder, page)):
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

#!/usr/bin/env python3
"""Checks that a report's figures are plausible.

check_report.py <folder of measurements> <report> [options of unittest]

No times are checked: they are the machine's.
"""

import base64
import io
import math
import pathlib
import re
import sys
import unittest

from matplotlib import image

from results import CODERS, KINECTS, LIDAR, read_results

FOLDER, REPORT = map(pathlib.Path, sys.argv[1:3]) if len(sys.argv) > 2 else (None, None)


class Figures(unittest.TestCase):
    """What was measured."""

    @classmethod
    def setUpClass(cls):
        cls.results = read_results(FOLDER)

    def mean(self, *key):
        return self.results.figure(*key).mean

    def test_all_figures_are_numbers(self):
        for key, figure in self.results.all_figures():
            self.assertTrue(math.isfinite(figure.mean), key)
            self.assertGreaterEqual(figure.deviation, 0.0, key)
            self.assertGreater(figure.samples, 0, key)

    def test_sensor_1_has_the_workload_of_the_paper(self):
        points = self.mean("cropping", "1", "SensorPreprocessor", 4, "cropped_points")
        self.assertTrue(36500 < points < 38500, points)
        for coder, (fewest, most) in (("balanced", (17000, 18500)),
                                      ("published", (17000, 19000))):
            voxels = self.mean("compression", "1", coder, 4, "voxels")
            self.assertTrue(fewest < voxels < most, (coder, voxels))
            voxels = self.mean("compression", "1", coder, 2, "voxels")
            self.assertTrue(32000 < voxels < 34500, (coder, voxels))

    def test_every_sensor_sees_the_cell(self):
        for sensor in KINECTS:
            points = self.mean("cropping", sensor, "SensorPreprocessor", 4,
                               "cropped_points")
            self.assertTrue(30000 < points < 217088, (sensor, points))
        points = self.mean("cropping", LIDAR, "SensorPreprocessor", 4, "cropped_points")
        self.assertTrue(2000 < points < 28800, points)

    def test_published_takes_the_bytes_that_the_paper_says(self):
        for resolution_cm in (4, 2):
            per_voxel = self.mean("compression", "1", "published", resolution_cm,
                                  "bytes_per_voxel")
            self.assertTrue(0.7 < per_voxel < 0.9, per_voxel)
        ratio = self.mean("compression", "1", "published", 4, "ratio")
        self.assertTrue(37 < ratio < 44, ratio)

    def test_more_effort_takes_fewer_bytes_and_all_fewer_than_published(self):
        for experiment, sensors, resolutions in (
                ("compression", KINECTS, (4, 2)), ("quadratic", ("1",), (4,)),
                ("linear", ("1",), (4,)), ("resolution", ("1",), range(1, 21))):
            for sensor in sensors:
                for resolution_cm in resolutions:
                    sizes = [self.mean(experiment, sensor, coder, resolution_cm, "bytes")
                             for coder in ("small", "balanced", "fast", "published")]
                    self.assertEqual(sizes, sorted(sizes),
                                     (experiment, sensor, resolution_cm))

    def test_voxels_of_half_the_edge_are_more(self):
        for coder in CODERS:
            for edge in range(1, 11):
                self.assertGreater(
                    self.mean("resolution", "1", coder, edge, "voxels"),
                    1.1 * self.mean("resolution", "1", coder, 2 * edge, "voxels"),
                    (coder, edge))

    def test_png_keeps_every_depth_and_jpeg_does_not(self):
        coders = self.results.coders("depth_image")
        self.assertEqual(len(coders), 8)
        for coder in coders:
            wrong = self.mean("depth_image", "1", coder, 0, "wrong_percent")
            if coder.startswith("PNG"):
                self.assertEqual(wrong, 0.0, coder)
                self.assertEqual(self.mean("depth_image", "1", coder, 0, "error_mm"), 0.0)
            else:
                self.assertTrue(1.0 < wrong < 100.0, (coder, wrong))
            bytes_of_image = self.mean("depth_image", "1", coder, 0, "bytes")
            bytes_of_voxels = self.mean("compression", "1", "published", 4, "bytes")
            self.assertGreater(bytes_of_image, bytes_of_voxels, coder)

    def test_all_nodes_ran_at_once(self):
        nodes = self.results.sensors("at_once")
        self.assertEqual(len(nodes), 8)
        for node in nodes:
            for coder in CODERS:
                for quantity in ("frames_per_second", "megabits_per_second",
                                 "cpu_percent", "cycle_ms"):
                    self.assertGreater(self.mean("at_once", node, coder, 4, quantity),
                                       0.0, (node, coder, quantity))


class Page(unittest.TestCase):
    """The report itself."""

    @classmethod
    def setUpClass(cls):
        cls.page = REPORT.read_text(encoding="utf-8")

    def pictures(self):
        for encoded in re.findall(r'src="data:image/png;base64,([^"]+)"', self.page):
            yield image.imread(io.BytesIO(base64.b64decode(encoded)))

    def ink(self, pixels):
        """Share of a picture that is not white."""
        return float((pixels[..., :3] < 0.98).any(axis=-1).mean())

    def test_nothing_comes_from_elsewhere(self):
        for source in re.findall(r'(?:src|href)="([^"]*)"', self.page):
            self.assertTrue(source.startswith("data:"), source[:80])
        self.assertNotRegex(self.page, r"url\(|@import|<script|<link|<iframe")

    def test_every_picture_is_there_and_not_blank(self):
        pictures = list(self.pictures())
        self.assertEqual(len(pictures), 5)
        for pixels in pictures:
            self.assertGreater(pixels.shape[0], 200)
            self.assertGreater(pixels.shape[1], 400)
            self.assertGreater(self.ink(pixels), 0.02)

    def test_every_view_of_figure_11_shows_something(self):
        pixels = list(self.pictures())[-1]
        height, width = (size // part for size, part in zip(pixels.shape, (2, 3)))
        for row, column in ((0, 0), (0, 1), (0, 2), (1, 0), (1, 1)):
            # The middle of a view, without its frame.
            view = pixels[row * height + height // 4:(row + 1) * height - height // 5,
                          column * width + width // 5:(column + 1) * width - width // 5]
            self.assertGreater(self.ink(view), 0.05, (row, column))

    def test_every_section_is_there(self):
        for words in ("Figure 5", "Figure 7", "Figure 10", "Figure 11",
                      "3.1 Preprocessing", "3.2 Compression", "Depth images",
                      "3.3 Frequency and bandwidth", "3.4 Denoising", "Processor: "):
            self.assertIn(words, self.page)

    def test_no_figure_is_missing(self):
        self.assertNotRegex(self.page, r"\b(?:nan|inf)\b")


if __name__ == "__main__":
    if FOLDER is None:
        sys.exit(__doc__)
    unittest.main(argv=[sys.argv[0]] + sys.argv[3:])

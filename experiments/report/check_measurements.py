#!/usr/bin/env python3
"""Checks that what was measured is plausible: check_measurements.py <folder>.

Times are the machine's: of them no more is asked than what holds on a busy one, too.
"""

import math
import sys

import plain_checks
from check_noise import Noise, NoiseAgainstPeers
from check_pictures import Pictures
from measured import Measured
from results import CODERS, KINECTS, LIDAR, RATES, ReportError

# Quantities that may lie below 0.
SIGNED = ("threshold", "best_threshold", "usual_threshold", "less_percent")


class Figures(Measured):
    """What holds for all figures."""

    def test_all_figures_are_numbers(self):
        for key, figure in self.results.all_figures():
            if not math.isfinite(figure.mean) or not math.isfinite(figure.deviation):
                self.fail(f"{key} is {figure.mean} ± {figure.deviation}")
            self.assertGreaterEqual(figure.deviation, 0.0, key)
            self.assertGreater(figure.samples, 0, key)

    def test_one_sample_has_no_deviation(self):
        for key, figure in self.results.all_figures():
            if figure.samples == 1:
                self.assertEqual(figure.deviation, 0.0, key)

    def test_nothing_is_below_zero(self):
        for key, figure in self.results.all_figures():
            # Memory that others gave back can hide a little of what a node took.
            least = -1.0 if key[4] == "memory_mb" else 0.0
            if key[4] not in SIGNED:
                self.assertGreaterEqual(figure.mean, least, key)

    def test_no_share_is_above_all(self):
        for key, figure in self.results.all_figures():
            if key[4].endswith("percent") and key[4] != "cpu_percent":
                self.assertLessEqual(figure.mean, 100.0, key)

    def test_the_machine_is_told(self):
        for words in ("Processor: ", "cores", "memory: ", "system: ", "compiler: ", "PCL ",
                      "pcl_ext ", "load average"):
            self.assertIn(words, self.machine)
        self.assertRegex(self.machine, r"\b20\d\d-\d\d-\d\d\b")


class Streams(Measured):
    """Sections 3.1 and 3.2."""

    def test_every_frame_was_measured(self):
        frames = self.mean("streams_run", "", "all", 0, "frames")
        for experiment in ("cropping", "compression", "quadratic", "linear",
                           "depth_image"):
            for key in self.keys_of(experiment):
                self.assertEqual(self.results.figure(*key).samples, frames, key)
        for key in self.keys_of("resolution"):
            self.assertEqual(self.results.figure(*key).samples, min(frames, 100), key)

    def test_sensor_1_has_the_workload_of_the_paper(self):
        points = self.mean("cropping", "1", "SensorPreprocessor", 4, "cropped_points")
        self.assert_between(points, 36500, 38500, "cropped points of sensor 1")
        for coder, (fewest, most) in (("balanced", (17000, 18500)),
                                      ("published", (17000, 19000))):
            self.assert_between(self.mean("compression", "1", coder, 4, "voxels"), fewest,
                                most, f"voxels of sensor 1, {coder}, 4 cm")
            self.assert_between(self.mean("compression", "1", coder, 2, "voxels"), 32000,
                                34500, f"voxels of sensor 1, {coder}, 2 cm")

    def test_every_sensor_sees_the_cell(self):
        for sensor in KINECTS + (LIDAR,):
            fewest, most = (2000, 28800) if sensor == LIDAR else (30000, 217088)
            subject = ("cropping", sensor, "SensorPreprocessor", 4)
            cropped = self.mean(*subject, "cropped_points")
            points = self.mean(*subject, "points")
            self.assert_between(cropped, fewest, most, f"cropped points of {sensor}")
            self.assert_between(points, cropped, most, f"points of sensor {sensor}")
            self.assert_near(self.mean(*subject, "kept_percent"), 100 * cropped / points,
                             0.02, f"share of cropped points, sensor {sensor}")

    def test_bytes_voxels_ratio_and_bandwidth_fit_each_other(self):
        for experiment in ("compression", "quadratic", "linear", "resolution"):
            for _, sensor, coder, cm, quantity in self.keys_of(experiment):
                if quantity != "bytes":
                    continue
                subject = (experiment, sensor, coder, cm)
                size = self.mean(*subject, "bytes")
                points = self.mean("cropping", sensor, "SensorPreprocessor", 4,
                                   "cropped_points")
                self.assert_near(self.mean(*subject, "bytes_per_voxel"),
                                 size / self.mean(*subject, "voxels"), 0.05,
                                 f"bytes per voxel, {subject}")
                # Means of quotients are above quotients of means, of few frames by more.
                self.assert_near(self.mean(*subject, "ratio"), 16 * points / size, 0.15,
                                 f"ratio, {subject}")
                self.assert_near(self.mean(*subject, "megabits_per_second"),
                                 8e-6 * size * RATES[sensor], 0.001,
                                 f"Mbit/s, {subject}")
        for coder in self.results.coders("depth_image"):
            subject = ("depth_image", "1", coder, 0)
            self.assert_near(self.mean(*subject, "megabits_per_second"),
                             8e-6 * self.mean(*subject, "bytes") * RATES["1"], 0.001,
                             f"Mbit/s, {subject}")

    def test_published_takes_the_bytes_that_the_paper_says(self):
        for cm in (4, 2):
            self.assert_between(self.mean("compression", "1", "published", cm,
                                          "bytes_per_voxel"), 0.7, 0.9,
                                f"bytes per voxel, published, {cm} cm")
        self.assert_between(self.mean("compression", "1", "published", 4, "ratio"), 37, 44,
                            "ratio, published")

    def test_more_effort_takes_fewer_bytes_and_all_fewer_than_published(self):
        for experiment, sensors, resolutions in (
                ("compression", KINECTS, (4, 2)), ("quadratic", ("1",), (4,)),
                ("linear", ("1",), (4,)), ("resolution", ("1",), range(1, 21))):
            for sensor in sensors:
                for cm in resolutions:
                    sizes = [self.mean(experiment, sensor, coder, cm, "bytes")
                             for coder in ("small", "balanced", "fast", "published")]
                    self.assertEqual(sizes, sorted(sizes), (experiment, sensor, cm))

    def test_laws_change_intensities_and_no_voxels(self):
        for coder in CODERS:
            counts = self.mean("compression", "1", coder, 4, "voxels")
            count_bytes = self.mean("compression", "1", coder, 4, "bytes")
            for law in ("quadratic", "linear"):
                self.assertEqual(self.mean(law, "1", coder, 4, "voxels"), counts,
                                 f"voxels, {law}, {coder}")
                self.assert_between(self.mean(law, "1", coder, 4, "bytes"),
                                    count_bytes, 3 * count_bytes,
                                    f"bytes, {law}, {coder}, against those of counts")

    def test_voxels_of_half_the_edge_are_more(self):
        for coder in CODERS:
            for edge in range(1, 11):
                self.assertGreater(
                    self.mean("resolution", "1", coder, edge, "voxels"),
                    1.1 * self.mean("resolution", "1", coder, 2 * edge, "voxels"),
                    f"voxels of {edge} cm, {coder}")

    def test_png_keeps_every_depth_and_jpeg_does_not(self):
        coders = self.results.coders("depth_image")
        self.assertEqual(len(coders), 8)
        for coder in coders:
            wrong = self.mean("depth_image", "1", coder, 0, "wrong_percent")
            error = self.mean("depth_image", "1", coder, 0, "error_mm")
            if coder.startswith("PNG"):
                self.assertEqual((wrong, error), (0.0, 0.0), coder)
            else:
                self.assert_between(wrong, 1, 100, f"wrong pixels, {coder}")
                # A step is 51 mm: rounding alone makes 15.
                self.assert_between(error, 10, 5000, f"depth error, {coder}")
            self.assertGreater(
                self.mean("depth_image", "1", coder, 0, "bytes"),
                self.mean("compression", "1", "published", 4, "bytes"), coder)


class AtOnce(Measured):
    """Section 3.3. A busy machine lets frames come late, but all of them come."""

    NODES = tuple(f"cell_sensor_{sensor}" for sensor in KINECTS + (LIDAR,)) + ("central",)

    def figure(self, node, coder, quantity):
        return self.mean("at_once", node, coder, 4, quantity)

    def test_all_nodes_ran_with_all_coders(self):
        self.assertEqual(tuple(self.results.sensors("at_once")), self.NODES)
        for node in self.NODES:
            for coder in CODERS:
                for quantity in ("frames_per_second", "megabits_per_second",
                                 "cpu_percent", "cycle_ms"):
                    self.assertGreater(self.figure(node, coder, quantity), 0.0,
                                       f"{quantity}, {node}, {coder}")

    def test_rates_are_near_the_sensors(self):
        rates = {f"cell_sensor_{sensor}": rate for sensor, rate in RATES.items()}
        rates["central"] = sum(RATES.values())
        for node in self.NODES:
            for coder in CODERS:
                self.assert_between(self.figure(node, coder, "frames_per_second"),
                                    rates[node] / 20, 3 * rates[node],
                                    f"frames a second, {node}, {coder}")

    def test_a_frame_has_the_bytes_that_it_has_by_itself(self):
        for sensor in RATES:
            node = f"cell_sensor_{sensor}"
            for coder in CODERS:
                size = (self.figure(node, coder, "megabits_per_second") / 8e-6
                        / self.figure(node, coder, "frames_per_second"))
                by_itself = self.mean("compression", sensor, coder, 4, "bytes")
                # Of few frames another share are I-frames.
                self.assert_between(size, by_itself / 4, by_itself * 4,
                                    f"bytes of a frame at once, {node}, {coder}")

    def test_merged_voxels_are_those_of_the_sensors(self):
        for coder in CODERS:
            voxels = [self.mean("compression", sensor, coder, 4, "voxels")
                      for sensor in RATES]
            # Where sensors see the same there is one voxel for all.
            self.assert_between(self.figure("central", coder, "merged_voxels"),
                                0.15 * sum(voxels), 1.02 * sum(voxels),
                                f"merged voxels, {coder}")

    def test_nodes_take_memory(self):
        for coder in CODERS:
            memory = [self.figure(node, coder, "memory_mb") for node in self.NODES]
            self.assert_between(sum(memory), 1, 10000, f"MB of all nodes, {coder}")


CASES = (Figures, Streams, AtOnce, Noise, NoiseAgainstPeers, Pictures)


def main():
    try:
        Measured.read(sys.argv[1])
    except (OSError, ReportError) as error:
        sys.exit(f"check_measurements.py: {error}")
    sys.exit(plain_checks.run("check_measurements.py", CASES))


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main()

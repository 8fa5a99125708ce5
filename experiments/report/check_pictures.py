"""Checks of what the figures are drawn from."""

from collections import Counter

from measured import Measured
from results import KINECTS, LIDAR

# Kinect V2 at 4 cm, metres: its field of view and pixels tell it.
CUT_OFF_DEPTH = 14.57
THRESHOLD = 64


class Pictures(Measured):
    """Figures 5, 7, 10 and 11."""

    def test_figure_5_shows_the_laws(self):
        laws = self.rows["laws"]
        self.assertGreater(len(laws), 100)
        for row in laws:
            self.assert_near(row["cut_off_depth"], CUT_OFF_DEPTH, 0.001, "cut-off depth")
            share = min(row["depth"] / row["cut_off_depth"], 1.0)
            for law, intensity in (("count", 1.0), ("linear", share),
                                   ("quadratic", share ** 2)):
                self.assert_between(row[law], intensity - 0.001, intensity + 0.001,
                                    f"{law} intensity at {row['depth']} m")

    def test_figure_7_shows_an_octree(self):
        points, voxels, cells = (self.rows["octree_" + name]
                                 for name in ("points", "voxels", "cells"))
        root = next((cell for cell in cells if cell["level"] == 3), None)
        self.assertIsNotNone(root, "the octree has no root")
        self.assert_near(root["edge"], 0.32, 0.001, "edge of the octree's root")
        numbers = Counter(cell["level"] for cell in cells)
        self.assertEqual(numbers[0], len(voxels), "cells of the last level")
        self.assertTrue(1 == numbers[3] < numbers[2] < numbers[1] < numbers[0] <= 512,
                        f"cells of the levels: {dict(numbers)}")
        self.assertGreater(len(voxels), 20)
        self.assertEqual(sum(voxel["count"] for voxel in voxels), len(points),
                         "points of all voxels")
        for row in points + voxels:
            for axis in "xyz":
                self.assert_between(row[axis], root[axis] - 0.0001,
                                    root[axis] + root["edge"] + 0.0001,
                                    f"{axis} of what lies in the octree")

    def test_every_sensor_is_in_figure_11(self):
        for name in ("cell_points", "cell_voxels"):
            numbers = Counter(int(row["sensor"]) for row in self.rows[name])
            for sensor in KINECTS + (LIDAR,):
                self.assertGreater(numbers[int(sensor)], 1000,
                                   f"{name} of sensor {sensor}")

    def test_voxels_are_fewer_than_points(self):
        self.assertLess(len(self.rows["cell_voxels"]), len(self.rows["cell_points"]))

    def test_every_sensor_has_noise_and_surface(self):
        noise = Counter(int(row["sensor"]) for row in self.rows["cell_voxels"]
                        if row["is_noise"])
        voxels = Counter(int(row["sensor"]) for row in self.rows["cell_voxels"])
        for sensor in KINECTS:
            share = 100 * noise[int(sensor)] / max(voxels[int(sensor)], 1)
            self.assert_between(share, 2, 40, f"noise % in figures 10 and 11, {sensor}")

    def test_each_law_removes_more_of_the_noise_than_of_the_surfaces(self):
        kinects = [row for row in self.rows["cell_voxels"]
                   if int(row["sensor"]) != int(LIDAR)]
        for law, threshold in (("count", 2), ("linear", THRESHOLD),
                               ("quadratic", THRESHOLD)):
            removed = {}
            for is_noise in (0.0, 1.0):
                shown = [row[law] for row in kinects if row["is_noise"] == is_noise]
                removed[is_noise] = (sum(value < threshold for value in shown)
                                     / max(len(shown), 1))
            self.assertGreater(removed[1.0], 1.2 * removed[0.0] + 0.01,
                               f"share of the noise that {law} {threshold} removes")

    def test_linear_intensities_are_not_below_quadratic_ones(self):
        for row in self.rows["cell_voxels"]:
            if int(row["sensor"]) != int(LIDAR):
                # Both are rounded.
                self.assertGreaterEqual(row["linear"] + 1, row["quadratic"], row)

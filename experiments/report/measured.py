"""What all checks of measurements look at."""

import unittest

from results import read_machine, read_results, read_rows


class Measured(unittest.TestCase):
    """Checks of the folder that was read last."""

    longMessage = True

    @classmethod
    def read(cls, folder):
        """Reads a folder for all checks; OSError or ReportError tells what is wrong."""
        Measured.results = read_results(folder)
        Measured.machine = read_machine(folder)
        Measured.rows = {name: read_rows(folder, name + ".csv")
                         for name in ("laws", "cell_points", "cell_voxels",
                                      "octree_points", "octree_voxels", "octree_cells")}

    def mean(self, *key):
        return self.results.mean(*key)

    def keys_of(self, experiment):
        keys = [key for key, _ in self.results.all_figures() if key[0] == experiment]
        self.assertTrue(keys, f"nothing was measured of '{experiment}'")
        return keys

    def assert_between(self, value, least, most, what):
        if not least <= value <= most:
            self.fail(f"{what}: {value:g} is not within {least:g} and {most:g}")

    def assert_near(self, value, wanted, share, what):
        if not abs(value - wanted) <= share * abs(wanted):
            self.fail(f"{what}: {value:g} is not {wanted:g}, to {100 * share:g} %")

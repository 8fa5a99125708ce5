"""Reads what the measuring programs wrote."""

import csv
import pathlib
from typing import NamedTuple

CODERS = ("published", "fast", "balanced", "small")
KINECTS = ("1", "2", "3", "4", "5", "6")
LIDAR = "7"


class Figure(NamedTuple):
    mean: float
    deviation: float
    samples: int


class Results:
    """Figures by experiment, sensor, coder, resolution in cm and quantity."""

    def __init__(self, files):
        self._figures = {}
        for file in files:
            with open(file, newline="", encoding="utf-8") as lines:
                for row in csv.DictReader(lines):
                    key = (row["experiment"], row["sensor"], row["coder"],
                           float(row["resolution_cm"]), row["quantity"])
                    self._figures[key] = Figure(float(row["mean"]),
                                                float(row["deviation"]),
                                                int(row["samples"]))

    def figure(self, experiment, sensor, coder, resolution_cm, quantity):
        """The figure; KeyError tells what is missing."""
        return self._figures[(experiment, sensor, coder, float(resolution_cm), quantity)]

    def values(self, experiment, position):
        """What an experiment has at a position of the key, in the order of the files."""
        return list(dict.fromkeys(key[position] for key in self._figures
                                  if key[0] == experiment))

    def sensors(self, experiment):
        return self.values(experiment, 1)

    def coders(self, experiment):
        return self.values(experiment, 2)

    def all_figures(self):
        return self._figures.items()


def read_results(folder):
    """All results in a folder."""
    files = sorted(pathlib.Path(folder).glob("results*.csv"))
    if not files:
        raise FileNotFoundError(f"there are no results in '{folder}'")
    return Results(files)

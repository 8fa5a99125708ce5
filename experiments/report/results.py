# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Reads what the program benchmark printed and wrote."""

import csv
import pathlib
from typing import NamedTuple

CODERS = ("published", "fast", "balanced", "small")
CAMERAS = ("1", "2", "3", "4", "5", "6")
LIDAR = "7"
# Frames per second.
RATES = {**{sensor: 20.0 for sensor in CAMERAS}, LIDAR: 10.0}


class ReportError(Exception):
    """What is wrong with the measurements, in a sentence for the user."""


class Value(NamedTuple):
    mean: float
    deviation: float
    samples: int


class Results:
    """Values by experiment, sensor, coder or method, voxel edge in cm and quantity; of files
    with a line that describes the machine, an empty one, and CSV."""

    def __init__(self, files):
        self.by_key = {}
        self.machine = ""
        for file in files:
            self._read(file)

    def _read(self, file):
        with open(file, newline="", encoding="utf-8") as lines:
            self.machine = self.machine or lines.readline().strip()
            rows = csv.DictReader(line for line in lines
                                  if line.strip() and not line.startswith("Processor: "))
            for row in rows:
                try:
                    key = (row["experiment"], row["sensor"], row["coder"],
                           float(row["resolution_cm"]), row["quantity"])
                    value = Value(float(row["mean"]), float(row["deviation"]),
                                  int(row["samples"]))
                except (KeyError, TypeError, ValueError) as error:
                    raise ReportError(f"'{file}' has a line that is not a result: "
                                      f"{error}") from error
                if key in self.by_key:
                    raise ReportError(f"'{file}': {key} is there twice")
                self.by_key[key] = value

    def find(self, experiment, sensor, coder, resolution_cm, quantity):
        """The value, or None."""
        return self.by_key.get((experiment, sensor, coder, float(resolution_cm), quantity))

    def value(self, *key):
        """The value, which must be there."""
        value = self.find(*key)
        if value is None:
            raise ReportError("the measurements lack " + ", ".join(map(str, key)))
        return value

    def mean(self, *key):
        return self.value(*key).mean

    def names(self, experiment, position, sensor=None):
        """What an experiment has at a position of the key, in the order of the files: its
        sensors (1), coders (2) or quantities (4)."""
        return list(dict.fromkeys(key[position] for key in self.by_key if key[0] == experiment
                                  and sensor in (None, key[1])))


def read_results(folder):
    """All results in a folder."""
    files = sorted(pathlib.Path(folder).glob("results*.csv"))
    if not files:
        raise ReportError(f"there are no results in '{folder}'")
    return Results(files)

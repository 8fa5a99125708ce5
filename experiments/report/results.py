"""Reads what the measuring programs wrote."""

import csv
import pathlib
from typing import NamedTuple

CODERS = ("published", "fast", "balanced", "small")
CAMERAS = ("1", "2", "3", "4", "5", "6")
LIDAR = "7"
MERGED = "merged"  # the voxels of all cameras on one grid
# Frames per second.
RATES = {**{sensor: 20.0 for sensor in CAMERAS}, LIDAR: 10.0}


class ReportError(Exception):
    """What is wrong with the measurements, in a sentence for the user."""


class Value(NamedTuple):
    mean: float
    deviation: float
    samples: int


class Results:
    """Values by experiment, sensor, coder, voxel edge in cm and quantity."""

    def __init__(self, files):
        self.by_key = {}
        for file in files:
            self._read(file)

    def _read(self, file):
        with open(file, newline="", encoding="utf-8") as lines:
            for number, row in enumerate(csv.DictReader(lines), start=2):
                try:
                    key = (row["experiment"], row["sensor"], row["coder"],
                           float(row["resolution_cm"]), row["quantity"])
                    value = Value(float(row["mean"]), float(row["deviation"]),
                                  int(row["samples"]))
                except (KeyError, TypeError, ValueError) as error:
                    raise ReportError(f"'{file}', line {number}, is not a result: "
                                      f"{error}") from error
                if key in self.by_key:
                    raise ReportError(f"'{file}', line {number}: {key} is there twice")
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

    def _at(self, experiment, position, sensor=None, resolution_cm=None):
        return list(dict.fromkeys(
            key[position] for key in self.by_key
            if key[0] == experiment and sensor in (None, key[1])
            and resolution_cm in (None, key[3])))

    def sensors(self, experiment, **wanted):
        """Sensors of an experiment in the order of the files, if wanted of one `sensor` or
        `resolution_cm`; coders() and quantities() likewise."""
        return self._at(experiment, 1, **wanted)

    def coders(self, experiment, **wanted):
        return self._at(experiment, 2, **wanted)

    def quantities(self, experiment, **wanted):
        return self._at(experiment, 4, **wanted)

    def experiments(self, prefix):
        """What follows a prefix in experiments' names, in the order of the files."""
        return list(dict.fromkeys(key[0][len(prefix):] for key in self.by_key
                                  if key[0].startswith(prefix)))


def read_results(folder):
    """All results in a folder."""
    files = sorted(pathlib.Path(folder).glob("results*.csv"))
    if not files:
        raise ReportError(f"there are no results in '{folder}'")
    return Results(files)


def read_rows(folder, name):
    """A CSV file of numbers as a list of rows, each by the header's names."""
    file = pathlib.Path(folder) / name
    rows = []
    with open(file, newline="", encoding="utf-8") as lines:
        for number, row in enumerate(csv.DictReader(lines), start=2):
            try:
                rows.append({key: float(value) for key, value in row.items()})
            except (TypeError, ValueError) as error:
                raise ReportError(f"'{file}', line {number}: {error}") from error
    if not rows:
        raise ReportError(f"'{file}' has no rows")
    return rows


def read_machine(folder):
    """The line that describes the machine."""
    return (pathlib.Path(folder) / "machine.txt").read_text(encoding="utf-8").strip()

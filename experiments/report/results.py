"""Reads what the measuring programs wrote."""

import csv
import pathlib
from typing import NamedTuple

CODERS = ("published", "fast", "balanced", "small")
KINECTS = ("1", "2", "3", "4", "5", "6")
LIDAR = "7"
MERGED = "merged"
# Frames a second.
RATES = {**{sensor: 20.0 for sensor in KINECTS}, LIDAR: 10.0}


class ReportError(Exception):
    """What is wrong with the measurements, in a sentence for the user."""


class Figure(NamedTuple):
    mean: float
    deviation: float
    samples: int


class Results:
    """Figures by experiment, sensor, coder, resolution in cm and quantity."""

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
                    figure = Figure(float(row["mean"]), float(row["deviation"]),
                                    int(row["samples"]))
                except (KeyError, TypeError, ValueError) as error:
                    raise ReportError(f"'{file}', line {number}, is not a result: "
                                      f"{error}") from error
                if key in self.by_key:
                    raise ReportError(f"'{file}', line {number}: {key} is there twice")
                self.by_key[key] = figure

    def find(self, experiment, sensor, coder, resolution_cm, quantity):
        """The figure, or None."""
        return self.by_key.get((experiment, sensor, coder, float(resolution_cm),
                                  quantity))

    def figure(self, *key):
        """The figure, which must be there."""
        figure = self.find(*key)
        if figure is None:
            raise ReportError("the measurements lack " + ", ".join(map(str, key)))
        return figure

    def mean(self, *key):
        return self.figure(*key).mean

    def values(self, experiment, position, **wanted):
        """What an experiment has at a position of the key, in the order of the files; of
        one sensor or resolution alone, if `sensor` or `resolution_cm` says so."""
        return list(dict.fromkeys(
            key[position] for key in self.by_key
            if key[0] == experiment
            and wanted.get("sensor", key[1]) == key[1]
            and wanted.get("resolution_cm", key[3]) == key[3]))

    def experiments(self, prefix):
        """What follows a prefix in experiments' names, in the order of the files."""
        return list(dict.fromkeys(key[0][len(prefix):] for key in self.by_key
                                  if key[0].startswith(prefix)))

    def sensors(self, experiment, **wanted):
        return self.values(experiment, 1, **wanted)

    def coders(self, experiment, **wanted):
        return self.values(experiment, 2, **wanted)

    def all_figures(self):
        return self.by_key.items()


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
        raise ReportError(f"'{file}' holds nothing")
    return rows


def read_machine(folder):
    """The line that tells the machine."""
    return (pathlib.Path(folder) / "machine.txt").read_text(encoding="utf-8").strip()

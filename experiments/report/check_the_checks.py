#!/usr/bin/env python3
"""Checks that check_measurements.py notices mistakes: check_the_checks.py <folder>.

Each mistake is made in what was read of a folder whose checks all hold.
"""

import copy
import sys

import plain_checks
from check_measurements import CASES
from measured import Measured
from noise_results import FILTER
from results import Figure, ReportError


def changing(quantity, change, *parts):
    """A mistake in all figures of a quantity whose key has all parts."""
    def make(measured):
        figures = measured.results.by_key
        changed = [key for key in figures
                   if key[4] == quantity and all(part in "|".join(map(str, key))
                                                 for part in parts)]
        for key in changed:
            figures[key] = change(figures[key])
        return len(changed)
    return make


def scaled(factor):
    return lambda figure: figure._replace(mean=figure.mean * factor)


def constant(value):
    return lambda figure: figure._replace(mean=value)


def without(prefix):
    """The figures of an experiment are missing."""
    def make(measured):
        figures = measured.results.by_key
        gone = [key for key in figures if key[0].startswith(prefix)]
        for key in gone:
            del figures[key]
        return len(gone)
    return make


def in_rows(name, change):
    """A mistake in what the pictures are drawn from."""
    def make(measured):
        measured.rows[name] = [changed for row in measured.rows[name]
                               if (changed := change(dict(row))) is not None]
        return 1
    return make


def set_to(**values):
    return lambda row: {**row, **values}


def swapped(one, other):
    return lambda row: {**row, one: row[other], other: row[one]}


def one_sample(measured):
    figures = measured.results.by_key
    for key, figure in figures.items():
        if key[0] == "compression":
            figures[key] = Figure(figure.mean, figure.deviation, 1)
    return 1


def no_machine(measured):
    measured.machine = ""
    return 1


MISTAKES = {
    "no figures of noise": without("noise"),
    "no laws on noise": without("noise_threshold:"),
    "no times of filters": without("noise_time"),
    "average precision of a tenth": changing("average_precision", constant(0.1), FILTER),
    "average precision above 1": changing("average_precision", constant(1.1), "|merged|"),
    "average precision that is no number": changing("average_precision",
                                                    constant(float("nan")), "count"),
    "laws as good as the filter": changing("average_precision", constant(0.93), "|linear|"),
    "the filter lets all through": changing("usual_let_through_percent", constant(100.0),
                                            "|1|" + FILTER),
    "the filter removes the person": changing("person_kept_percent", constant(20.0),
                                              "noise_threshold:0.0", FILTER),
    "no person": changing("person_worst_percent", constant(100.5)),
    "slow filter": changing("median_ms", constant(1360.0), "VoxelOutlierRemoval"),
    "longer streams": changing("less_percent", constant(-99.0)),
    "bytes that do not fit": changing("bytes", scaled(2.0), "noise_bytes", "log-odds 0"),
    "voxels a tenth of their bytes": changing("bytes_per_voxel", scaled(10.0),
                                              "quadratic|"),
    "bandwidth of nothing": changing("megabits_per_second", constant(0.001),
                                     "compression"),
    "bandwidth of nothing at once": changing("megabits_per_second", constant(0.001),
                                             "cell_sensor_4"),
    "ratio of nothing": changing("ratio", scaled(0.1), "compression|3"),
    "time below zero": changing("encode_ms", scaled(-1.0)),
    "JPEG without an error": changing("error_mm", constant(0.0), "JPEG"),
    "PNG with one": changing("error_mm", constant(1.0), "PNG"),
    "no rate": changing("frames_per_second", constant(0.5), "cell_sensor_1"),
    "three merged voxels": changing("merged_voxels", constant(3.0)),
    "memory below zero": changing("memory_mb", scaled(-1.0)),
    "more kept than there was": changing("kept_percent", constant(922.0)),
    "other share kept": changing("kept_percent", constant(90.0), "cropping|1"),
    "one sample": one_sample,
    "no machine": no_machine,
    "laws swapped in figure 5": in_rows("laws", swapped("linear", "quadratic")),
    "cut-off depth of figure 5": in_rows("laws", set_to(cut_off_depth=7.3)),
    "one point in figure 7": in_rows("octree_points", lambda row: None),
    "figure 7 moved": in_rows("octree_voxels", lambda row: {**row, "x": row["x"] + 0.2}),
    "figure 7 without levels": in_rows(
        "octree_cells", lambda row: row if row["level"] == 0 else None),
    "figure 11 of sensor 6": in_rows(
        "cell_voxels", lambda row: row if row["sensor"] == 6 else None),
    "points of figure 11 without sensor 3": in_rows(
        "cell_points", lambda row: None if row["sensor"] == 3 else row),
    "no noise in figure 10": in_rows("cell_voxels", set_to(is_noise=0.0)),
    "all as intense in figure 10": in_rows("cell_voxels", set_to(quadratic=255.0)),
}


def main(folder):
    Measured.read(folder)
    lines, _ = plain_checks.failed_checks(CASES)
    if lines:
        raise ReportError(f"the checks fail without a mistake: {lines[0]}")
    whole = (Measured.results, Measured.rows, Measured.machine)
    missed = []
    for name, make in MISTAKES.items():
        Measured.results = copy.deepcopy(whole[0])
        Measured.rows, Measured.machine = dict(whole[1]), whole[2]
        if not make(Measured):
            missed.append(f"'{name}' changes nothing")
        elif not plain_checks.failed_checks(CASES)[0]:
            missed.append(f"'{name}' is not noticed")
    for words in missed:
        print(f"check_the_checks.py: {words}", file=sys.stderr)
    if not missed:
        print(f"check_the_checks.py: all {len(MISTAKES)} mistakes are noticed",
              file=sys.stderr)
    return 1 if missed else 0


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    try:
        sys.exit(main(sys.argv[1]))
    except (OSError, ReportError) as error:
        sys.exit(f"check_the_checks.py: {error}")

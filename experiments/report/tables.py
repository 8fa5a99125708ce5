# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""The report's tables: the paper's values beside the measured ones, and quantities of
results."""

from page import DASH, Table, mean_and_deviation, mean_of, number
from paper_values import (COMPRESSION, CROPPING, DEPTH_IMAGE, PERFORMANCE,
                          SENSORS_IN_A_GIGABIT, UNCOMPRESSED_KIB_PER_SECOND)
from results import CAMERAS, CODERS, LIDAR, RATES, Value

GIGABIT_IN_MEGABITS = 1000.0
KIB_PER_SECOND_OF_MEGABIT = 1e6 / 8 / 1024
BYTES_PER_POINT = 16  # XYZ and padding or intensity, four floats


def quantities(results, caption, first, columns, rows):
    """A table of results. Columns: heading, quantity, digits. Rows: words and a subject, or
    words alone for a group; a subject is experiment, sensor, coder and edge in cm."""
    table = Table(caption, [first] + [heading for heading, _, _ in columns])
    for words, *subject in rows:
        if subject:
            table.add_row([words] + [
                mean_and_deviation(results.find(*subject, quantity), digits)
                for _, quantity, digits in columns])
        else:
            table.add_group(words)
    return table


def _sensor_name(sensor):
    return f"{sensor}, VLP-16" if sensor == LIDAR else f"{sensor}, Kinect V2"


def _scaled(value, factor):
    return Value(value.mean * factor, value.deviation * factor, value.samples)


def _derived(mean):
    """A value that is computed from means, without a deviation."""
    return Value(mean, 0.0, 1)


def _paper_cell(reported, digits):
    if isinstance(reported, tuple):
        return mean_and_deviation(Value(*reported, 2), digits)
    return DASH if reported is None else number(reported, digits)


def beside_paper(caption, columns):
    """A table with the paper's column, and a value and its ratio to the paper's per column."""
    header = ["", "paper"]
    for column in columns:
        header += [column, "÷ paper"]
    return Table(caption, header, paper_column=1)


def add_beside_paper(table, words, reported, digits, values):
    """A row; a value that is None was not measured."""
    row = [words, _paper_cell(reported, digits)]
    paper = reported[0] if isinstance(reported, tuple) else reported
    for value in values:
        has_ratio = value is not None and reported is not None
        row += [mean_and_deviation(value, digits),
                number(value.mean / paper, 2) if has_ratio else DASH]
    table.add_row(row)


def _cropping(results, quantity):
    return results.value("cropping", "1", "SensorPreprocessor", 4, quantity)


def _cropped_kib(results):
    return _scaled(_cropping(results, "cropped_points"), BYTES_PER_POINT / 1024)


def table_2(results):
    """Cropping of sensor 1."""
    table = beside_paper("Table 2. Cropping, mean ± standard deviation over the frames.",
                         ["sensor 1"])
    points = _cropping(results, "cloud_points")
    for words, digits, measured in (
            ("points", 0, points),
            ("KiB", 0, _scaled(points, BYTES_PER_POINT / 1024)),
            ("cropped points", 0, _cropping(results, "cropped_points")),
            ("cropped KiB", 1, _cropped_kib(results)),
            ("ratio", 2, _cropping(results, "cropping_ratio"))):
        add_beside_paper(table, words, CROPPING[words], digits, [measured])
    return table


def cropping_table(results):
    """Cropping of all sensors."""
    return quantities(
        results, "All sensors: points of a frame, mean ± standard deviation over the frames.",
        "sensor", (("with a return", "points", 0), ("in the crop box", "cropped_points", 0),
                   ("kept %", "kept_percent", 1), ("moving and cropping, ms",
                                                   "preprocess_ms", 2)),
        [(_sensor_name(sensor), "cropping", sensor, "SensorPreprocessor", 4)
         for sensor in CAMERAS + (LIDAR,)])


def table_3_or_4(results, resolution_cm):
    """Compression of sensor 1 with the point count as intensity."""
    paper = COMPRESSION[resolution_cm]
    table = beside_paper(f"Table {3 if resolution_cm == 4 else 4}. Compression at "
                         f"{resolution_cm} cm, mean ± standard deviation over the frames.",
                         CODERS)

    def values(quantity, factor=1.0):
        return [_scaled(results.value("compression", "1", coder, resolution_cm, quantity),
                        factor) for coder in CODERS]
    cropped = _cropping(results, "cropped_points")
    for words, digits, measured in (
            ("cropped points", 0, [cropped] * len(CODERS)),
            ("cropped KiB", 1, [_cropped_kib(results)] * len(CODERS)),
            ("voxels", 0, values("voxels")),
            ("KiB", 2, values("bytes", 1 / 1024)),
            ("bytes per voxel", 2, values("bytes_per_voxel")),
            ("ratio", 1, values("ratio")),
            ("points per voxel", 2, [_derived(cropped.mean / voxels.mean)
                                     for voxels in values("voxels")])):
        add_beside_paper(table, words, paper[words], digits, measured)
    return table


STREAM_COLUMNS = (("voxels", "voxels", 0), ("bytes", "bytes", 0),
                  ("bytes per voxel", "bytes_per_voxel", 3), ("ratio", "ratio", 1),
                  ("Mbit/s", "megabits_per_second", 2), ("encode ms", "encode_ms", 2),
                  ("decode ms", "decode_ms", 2))


def laws_table(results):
    """Sensor 1 with each intensity law."""
    rows = []
    for experiment, cm, words in (
            ("compression", 4, "4 cm, count"), ("compression", 2, "2 cm, count"),
            ("quadratic", 4, "4 cm, quadratic"), ("linear", 4, "4 cm, linear")):
        rows += [(words,)] + [(coder, experiment, "1", coder, cm) for coder in CODERS]
    return quantities(results, "Sensor 1 by intensity law, mean ± standard deviation over the "
                      "frames.", "coder", STREAM_COLUMNS, rows)


def all_sensors_table(results):
    """Bytes per voxel of every sensor."""
    table = Table("All sensors, means over the frames; voxels of the efforts, and bytes per "
                  "voxel.", ["sensor", "voxels"] + list(CODERS))
    for cm in (4, 2):
        table.add_group(f"{cm} cm")
        for sensor in CAMERAS + (LIDAR,):
            table.add_row(
                [_sensor_name(sensor),
                 number(results.mean("compression", sensor, "balanced", cm, "voxels"), 0)]
                + [number(results.mean("compression", sensor, coder, cm, "bytes_per_voxel"), 3)
                   for coder in CODERS])
    return table


def depth_image_table(results):
    """Depth images beside the paper's sizes."""
    table = Table("Sensor 1's depth image, mean ± standard deviation over the frames; the "
                  f"paper reports {DEPTH_IMAGE['raw MB']} MB raw and "
                  f"{DEPTH_IMAGE['compressed MB']} MB compressed.",
                  ["coder", "paper, MB", "MB", "÷ paper", "ratio", "encode ms", "decode ms",
                   "depth error, mm RMS", "wrong pixels %"], paper_column=1)
    points = _cropping(results, "cropped_points").mean
    voxels = COMPRESSION[4]["KiB"][0] * 1024e-6
    for experiment, coder, cm, reported, digits in (
            *(("depth_image", coder, 0,
               DEPTH_IMAGE["raw MB" if coder.startswith("raw") else "compressed MB"], 2)
              for coder in results.names("depth_image", 2)),
            *(("compression", coder, 4, voxels, 4) for coder in CODERS)):
        subject = (experiment, "1", coder, cm)
        size = _scaled(results.value(*subject, "bytes"), 1e-6)
        table.add_row([coder if cm == 0 else f"voxels of 4 cm, {coder}",
                       _paper_cell(reported, digits), mean_and_deviation(size, 4),
                       number(size.mean / reported, 2),
                       number(BYTES_PER_POINT * points / (1e6 * size.mean), 1)]
                      + [mean_and_deviation(results.find(*subject, quantity), digits)
                         for quantity, digits in (
                             ("encode_ms", 2), ("decode_ms", 2), ("error_mm", 0),
                             ("wrong_percent", 1))])
    return table


def _stream(results, coder, call, rate=None):
    """One stream by the processor time of a frame, at a rate or as fast as one thread can."""
    cycle = results.value("compression", "1", coder, 4, call)
    size = results.mean("compression", "1", coder, 4, "bytes")
    rate = rate or 1000.0 / cycle.mean
    return {"frames per second": _derived(rate), "KiB/s": _derived(rate * size / 1024),
            "cycle ms": cycle, "processor % of a core": _derived(cycle.mean * rate / 10.0)}


def _centre(results, coder):
    """The central computer with the streams of all cameras."""
    def value(quantity):
        return results.value("at_once", "central", coder, 4, quantity)
    return {"processor % of a core": value("cpu_percent"),
            "memory MiB": _scaled(value("memory_mb"), 1e6 / 1024 ** 2)}


def table_5(results):
    """Rates, times and memory of one sensor's stream at 4 cm."""
    table = beside_paper("Table 5. Performance at 4 cm, sensor 1, point count as intensity; "
                         "mean ± standard deviation.", CODERS)
    measured = {
        "compression at the highest rate": lambda coder: _stream(results, coder, "encode_ms"),
        "compression at 20 Hz": lambda coder: _stream(results, coder, "encode_ms", RATES["1"]),
        "decompression at 20 Hz": lambda coder: _stream(results, coder, "decode_ms",
                                                        RATES["1"]),
        "decompression of all sensors": lambda coder: _centre(results, coder)}
    for group, paper in PERFORMANCE.items():
        table.add_group(group)
        columns = [measured[group](coder) for coder in CODERS]
        for quantity, reported in paper.items():
            add_beside_paper(table, quantity, reported, 1,
                             [column.get(quantity) for column in columns])
    return table


def at_once_table(results):
    """The run of all cameras' streams at the central computer."""
    return quantities(
        results, "The streams of all six cameras at the central computer, 4 cm.", "coder",
        (("frames per second", "frames_per_second", 1), ("late %", "late_percent", 1),
         ("latency ms", "latency_ms", 2), ("longest latency ms", "longest_latency_ms", 1),
         ("processor, % of a core", "cpu_percent", 1), ("memory MB", "memory_mb", 1),
         ("merging ms", "merge_ms", 2), ("merged voxels", "merged_voxels", 0)),
        [(coder, "at_once", "central", coder, 4) for coder in CODERS])


def summary_table(results):
    """The paper's main values and their counterparts."""
    table = beside_paper("Main values of the paper and of sensor 1, means over the frames.",
                         CODERS)

    def add(words, reported, digits, measure):
        values = [_derived(measure(coder)) for coder in CODERS]
        add_beside_paper(table, words, reported, digits, values)

    def mean(coder, cm, quantity):
        return results.mean("compression", "1", coder, cm, quantity)
    for cm in (4, 2):
        add(f"compression ratio, {cm} cm", COMPRESSION[cm]["ratio"][0], 1,
            lambda coder, cm=cm: mean(coder, cm, "ratio"))
        add(f"bytes per voxel, {cm} cm", COMPRESSION[cm]["bytes per voxel"][0], 2,
            lambda coder, cm=cm: mean(coder, cm, "bytes_per_voxel"))
    add("KiB/s of a sensor at 20 Hz, 4 cm", PERFORMANCE["compression at 20 Hz"]["KiB/s"], 1,
        lambda coder: mean(coder, 4, "megabits_per_second") * KIB_PER_SECOND_OF_MEGABIT)
    add("KiB/s of its cropped points", UNCOMPRESSED_KIB_PER_SECOND, 0,
        lambda coder: _cropped_kib(results).mean * RATES["1"])
    add("sensors in a gigabit, 4 cm (about)", SENSORS_IN_A_GIGABIT, 0,
        lambda coder: GIGABIT_IN_MEGABITS / mean(coder, 4, "megabits_per_second"))
    return table


LAWS = ("count", "quadratic", "linear")
FILTER = "filter on quadratic"
# Of a decision: heading, quantity, digits.
SHARES = (("let through %", "let_through_percent", 1),
          ("surfaces %", "surface_kept_percent", 1),
          ("still %", "still_kept_percent", 1),
          ("machines %", "machine_kept_percent", 1),
          ("person %", "person_kept_percent", 1),
          ("worst frame %", "person_worst_percent", 0))


def best_law(results, sensor):
    """The law of the highest average precision."""
    return max(LAWS, key=lambda law: results.mean("noise", sensor, law, 4,
                                                  "average_precision"))


def _prefixed(prefix, columns):
    return tuple((heading, prefix + quantity, digits) for heading, quantity, digits in columns)


def noise_summary_table(results):
    """A row for each camera."""
    table = Table("Noise detected by the best law and by the filter, 4 cm.",
                  ["sensor", "noise %", "AP, best law", "AP, filter",
                   "let through %, law", "let through %, filter", "person kept %",
                   "in the worst frame %"])
    for sensor in CAMERAS:
        law = best_law(results, sensor)

        def cell(method, quantity, digits, sensor=sensor):
            return mean_of(results.find("noise", sensor, method, 4, quantity), digits)
        table.add_row([sensor, cell(FILTER, "noise_percent", 1),
                       f"{cell(law, 'average_precision', 3)}, {law}",
                       cell(FILTER, "average_precision", 3),
                       cell(law, "usual_let_through_percent", 1)]
                      + [cell(FILTER, f"usual_{quantity}_percent", digits)
                         for quantity, digits in (("let_through", 1), ("person_kept", 1),
                                                  ("person_worst", 0))])
    return table


def noise_methods_table(results):
    """All methods on all cameras."""
    columns = (("AP", "average_precision", 3),
               *_prefixed("best_", (("precision", "precision", 3), ("recall", "recall", 3),
                                    ("F1", "f1", 3))),
               *_prefixed("usual_", SHARES), ("median ms", "median_ms", 2),
               ("longest ms", "longest_ms", 1))
    rows = []
    for sensor in CAMERAS:
        rows += [(f"sensor {sensor}",)] + [(method, "noise", sensor, method, 4)
                                           for method in results.names("noise", 2, sensor)]
    return quantities(results, "Each method: at the threshold of the best F1, at the highest "
                      "that keeps 95 % of the surfaces' voxels, and the processor time of a "
                      "frame's scores.", "method", columns, rows)


def noise_thresholds_table(results):
    """The filter at log-odds that users set."""
    rows = []
    for threshold in ("0.0", "2.5"):
        rows += [(f"log-odds {threshold}",)] + [
            (sensor, "noise_threshold:" + threshold, sensor, FILTER, 4) for sensor in CAMERAS]
    return quantities(results, "The filter at log-odds 0, the default, and 2.5: voxels kept.",
                      "sensor", SHARES, rows)


SNOW, DUST = LIDAR + " in snow", LIDAR + " in dust"
# Sensor of the results, and the air in words.
AIRS = {LIDAR: "clear air", SNOW: "snow, 1.5 mm of water an hour", DUST: "a cloud of dust"}
POINT_FILTER = "filter on points"
LIDAR_CM = 10


def lidar_table(results):
    """All methods in clear air, snow and dust."""
    rows, thresholds = [], []
    for sensor, air in AIRS.items():
        noise = results.mean("lidar_points", sensor, POINT_FILTER, LIDAR_CM, "noise_percent")
        methods = results.names("lidar_points", 2, sensor)
        rows += [(f"{air}: {number(noise, 1)} % of the points are noise",)]
        rows += [(method, "lidar_points", sensor, method, LIDAR_CM) for method in methods]
        thresholds += [(air,)] + [
            (method, f"lidar_points_threshold:{'2.0' if 'DROR' in method else '0.0'}", sensor,
             method, LIDAR_CM) for method in methods if "DSOR" not in method]
    own = (SHARES[0], ("surfaces %", "surface_kept_percent", 2), SHARES[4])
    return [quantities(results, "Noise of the lidar that is found among its points; shares "
                       "where 95 % of the surfaces' points are kept.", "method",
                       (("AP", "average_precision", 3), *_prefixed("usual_", own),
                        ("ms", "median_ms", 1)), rows),
            quantities(results, "The same at log-odds 0, and of DROR at its authors' "
                       "threshold.", "method", own, thresholds)]


HAND = "hand"  # the camera on a hand of a robot
FILTERS = {"none": "no filter", "outliers": "VoxelOutlierRemoval",
           "temporal": "TemporalVoxelFilter", "both": "both"}
FILTERED = {**{sensor: f"sensor {sensor}, count" for sensor in CAMERAS},
            LIDAR: "lidar, native", HAND: "camera on a hand, count"}


def temporal_table(results):
    """Streams with and without filters."""
    rows = []
    for sensor, words in FILTERED.items():
        rows += [(words,)] + [(filter_words, "temporal", sensor, name, 4)
                              for name, filter_words in FILTERS.items()]
    return quantities(
        results, "Streams with and without filters, 4 cm, balanced, an I-frame every 300; "
        "mean ± standard deviation over the frames.", "filter",
        (("bytes", "bytes", 0), ("of unfiltered %", "of_unfiltered_percent", 1),
         ("surfaces %", "surface_percent", 2), ("worst frame %", "surface_worst_percent", 2),
         ("person %", "person_percent", 1), ("worst frame %", "person_worst_percent", 1),
         ("noise %", "noise_percent", 2), ("encode ms", "encode_ms", 2),
         ("decode ms", "decode_ms", 2)), rows)

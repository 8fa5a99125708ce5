"""The report's tables of sections 3.1 to 3.4: the paper's values beside the measured ones."""

from page import DASH, Table, mean_and_deviation, number
from paper_values import (COMPRESSION, CROPPING, DEPTH_IMAGE, PERFORMANCE,
                          SENSORS_IN_A_GIGABIT, UNCOMPRESSED_KIB_PER_SECOND)
from results import CODERS, LIDAR, RATES, Value

GIGABIT_IN_MEGABITS = 1000.0
KIB_PER_SECOND_OF_MEGABIT = 1e6 / 8 / 1024
BYTES_PER_POINT = 16  # XYZ and padding or intensity, four floats


def _sensor_name(sensor):
    return f"{sensor}, VLP-16" if sensor == LIDAR else f"{sensor}, Kinect V2"


def _scaled(value, factor):
    return Value(value.mean * factor, value.deviation * factor, value.samples)


def _derived(mean):
    """A value that is computed from means, without a deviation."""
    return Value(mean, 0.0, 1)


def _paper_mean(reported):
    return reported[0] if isinstance(reported, tuple) else reported


def _paper_cell(reported, digits):
    if reported is None:
        return DASH
    if isinstance(reported, tuple):
        return f"{number(reported[0], digits)} ± {number(reported[1], digits)}"
    return number(reported, digits)


def beside_paper(caption, columns):
    """A table with the paper's column, and a value and its ratio to the paper's per column."""
    header = ["", "paper"]
    for column in columns:
        header += [column, "÷ paper"]
    return Table(caption, header, paper_column=1)


def add_beside_paper(table, words, reported, digits, values):
    """A row; a value that is None was not measured."""
    row = [words, _paper_cell(reported, digits)]
    for value in values:
        has_ratio = value is not None and reported is not None
        row += [DASH if value is None else mean_and_deviation(value, digits),
                number(value.mean / _paper_mean(reported), 2) if has_ratio else DASH]
    table.add_row(row)


def _cropping(results, sensor, quantity):
    return results.value("cropping", sensor, "SensorPreprocessor", 4, quantity)


def _cropped_kib(results):
    return _scaled(_cropping(results, "1", "cropped_points"), BYTES_PER_POINT / 1024)


def table_2(results):
    """Cropping of sensor 1."""
    def value(quantity):
        return _cropping(results, "1", quantity)
    table = beside_paper("Table 2. Cropping, mean ± standard deviation over the frames.",
                         ["sensor 1"])
    points, cropped = value("cloud_points"), value("cropped_points")
    for words, digits, measured in (
            ("points", 0, _derived(points.mean)),
            ("KiB", 0, _derived(points.mean * BYTES_PER_POINT / 1024)),
            ("cropped points", 0, cropped),
            ("cropped KiB", 1, _cropped_kib(results)),
            ("ratio", 2, value("cropping_ratio"))):
        add_beside_paper(table, words, CROPPING[words], digits, [measured])
    return table


def cropping_table(results):
    """Cropping of all sensors."""
    table = Table("All sensors: points of a frame, mean ± standard deviation over the frames.",
                  ["sensor", "with a return", "in the crop box", "kept %",
                   "moving and cropping, ms"])
    for sensor in results.sensors("cropping"):
        table.add_row([_sensor_name(sensor)] + [
            mean_and_deviation(_cropping(results, sensor, quantity), digits)
            for quantity, digits in (("points", 0), ("cropped_points", 0),
                                     ("kept_percent", 1), ("preprocess_ms", 2))])
    return table


def table_3_or_4(results, resolution_cm):
    """Compression of sensor 1 with the point count as intensity."""
    paper = COMPRESSION[resolution_cm]
    table = beside_paper(f"Table {3 if resolution_cm == 4 else 4}. Compression at "
                         f"{resolution_cm} cm, mean ± standard deviation over the frames.",
                         CODERS)

    def values(quantity, factor=1.0):
        return [_scaled(results.value("compression", "1", coder, resolution_cm, quantity),
                        factor) for coder in CODERS]
    cropped = _cropping(results, "1", "cropped_points")
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


def laws_table(results):
    """Sensor 1 with each intensity law."""
    table = Table("Sensor 1 by intensity law, mean ± standard deviation over the frames.",
                  ["coder", "voxels", "bytes", "bytes per voxel", "ratio", "Mbit/s",
                   "encode ms", "decode ms"])
    for experiment, resolution_cm, words in (
            ("compression", 4, "4 cm, count"), ("compression", 2, "2 cm, count"),
            ("quadratic", 4, "4 cm, quadratic"), ("linear", 4, "4 cm, linear")):
        table.add_group(words)
        for coder in CODERS:
            table.add_row([coder] + [
                mean_and_deviation(results.value(experiment, "1", coder, resolution_cm,
                                                 quantity), digits)
                for quantity, digits in (
                    ("voxels", 0), ("bytes", 0), ("bytes_per_voxel", 3), ("ratio", 1),
                    ("megabits_per_second", 2), ("encode_ms", 2), ("decode_ms", 2))])
    return table


def all_sensors_table(results):
    """Bytes per voxel and ratio of every sensor."""
    header = ["sensor", "voxels"]
    for quantity in ("bytes per voxel", "ratio"):
        header += [f"{quantity}, {coder}" for coder in CODERS]
    table = Table("All sensors, means over the frames; voxels of the efforts.", header)
    for resolution_cm in (4, 2):
        table.add_group(f"{resolution_cm} cm")
        for sensor in results.sensors("compression"):
            def mean(coder, quantity, digits, sensor=sensor, cm=resolution_cm):
                return number(results.mean("compression", sensor, coder, cm, quantity), digits)
            table.add_row([_sensor_name(sensor), mean("balanced", "voxels", 0)]
                          + [mean(coder, "bytes_per_voxel", 3) for coder in CODERS]
                          + [mean(coder, "ratio", 1) for coder in CODERS])
    return table


def depth_image_table(results):
    """Depth images beside the paper's sizes."""
    table = Table("Sensor 1's depth image, mean ± standard deviation over the frames; the "
                  f"paper reports {DEPTH_IMAGE['raw MB']} MB raw and "
                  f"{DEPTH_IMAGE['compressed MB']} MB compressed.",
                  ["coder", "paper, MB", "MB", "÷ paper", "ratio", "Mbit/s", "encode ms",
                   "decode ms", "depth error, mm RMS", "wrong pixels %"], paper_column=1)

    def add_row(experiment, coder, resolution_cm, reported, digits=2):
        def cell(quantity, digits):
            value = results.find(experiment, "1", coder, resolution_cm, quantity)
            return DASH if value is None else mean_and_deviation(value, digits)
        size = _scaled(results.value(experiment, "1", coder, resolution_cm, "bytes"), 1e-6)
        table.add_row([coder.replace(" cropped", ""),
                       DASH if reported is None else number(reported, digits),
                       mean_and_deviation(size, 4),
                       DASH if reported is None else number(size.mean / reported, 2)]
                      + [cell(quantity, digits) for quantity, digits in (
                          ("ratio", 1), ("megabits_per_second", 1), ("encode_ms", 2),
                          ("decode_ms", 2), ("error_mm", 0), ("wrong_percent", 1))])
    coders = results.coders("depth_image")
    table.add_group("the whole image")
    for coder in coders:
        if not coder.endswith(" cropped"):
            add_row("depth_image", coder, 0,
                    DEPTH_IMAGE["raw MB" if coder.startswith("raw") else "compressed MB"])
    table.add_group("pixels outside the crop box set to no return")
    for coder in coders:
        if coder.endswith(" cropped"):
            add_row("depth_image", coder, 0, None)
    table.add_group("for comparison, voxels of 4 cm with a count")
    for coder in CODERS:
        add_row("compression", coder, 4, COMPRESSION[4]["KiB"][0] * 1024e-6, 4)
    return table


def resolution_table(results):
    """Bits per voxel by voxel edge."""
    table = Table("Sensor 1, bits per voxel, means over the frames.",
                  ["voxel edge cm", "voxels"] + list(CODERS))
    for resolution_cm in range(1, 21):
        def mean(coder, quantity, cm=resolution_cm):
            return results.mean("resolution", "1", coder, cm, quantity)
        table.add_row([str(resolution_cm), number(mean("balanced", "voxels"), 0)]
                      + [number(8 * mean(coder, "bytes_per_voxel"), 2) for coder in CODERS])
    return table


def _at_highest_rate(results, coder):
    """Compression as fast as one thread can, from its processor time per frame."""
    cycle = results.value("compression", "1", coder, 4, "encode_ms")
    rate = 1000.0 / cycle.mean
    size = results.mean("compression", "1", coder, 4, "bytes")
    return {"frames per second": _derived(rate), "KiB/s": _derived(rate * size / 1024),
            "cycle ms": cycle, "processor % of a core": _derived(100.0)}


def _node(results, node, coder):
    """A node of the run of all sensors at once."""
    def value(quantity):
        return results.value("at_once", node, coder, 4, quantity)
    return {"frames per second": value("frames_per_second"),
            "KiB/s": _scaled(value("megabits_per_second"), KIB_PER_SECOND_OF_MEGABIT),
            "cycle ms": value("cycle_ms"),
            "processor % of a core": value("cpu_percent"),
            "memory MiB": _scaled(value("memory_mb"), 1e6 / 1024 ** 2)}


def _decompression(results, coder):
    """One stream at its sensor's rate, from the processor time per frame."""
    cycle = results.value("compression", "1", coder, 4, "decode_ms")
    size = results.mean("compression", "1", coder, 4, "bytes")
    return {"frames per second": _derived(RATES["1"]),
            "KiB/s": _derived(RATES["1"] * size / 1024), "cycle ms": cycle,
            "processor % of a core": _derived(cycle.mean * RATES["1"] / 10.0)}


def table_5(results):
    """Rates, times and memory of one sensor's stream at 4 cm."""
    table = beside_paper("Table 5. Performance at 4 cm, sensor 1, point count as intensity; "
                         "mean ± standard deviation.", CODERS)
    measured = {
        "compression at the highest rate": _at_highest_rate,
        "compression at 20 Hz": lambda *key: _node(key[0], "cell_sensor_1", key[1]),
        "decompression at 20 Hz": _decompression,
        "decompression of all sensors": lambda *key: _node(key[0], "central", key[1])}
    for group, paper in PERFORMANCE.items():
        table.add_group(group)
        columns = [measured[group](results, coder) for coder in CODERS]
        for quantity, reported in paper.items():
            add_beside_paper(table, quantity, reported, 1,
                             [column.get(quantity) for column in columns])
    return table


def at_once_table(results):
    """All nodes of the run of all sensors at once."""
    table = Table("All sensors' nodes and the central one at once, 4 cm; mean ± standard "
                  "deviation over the seconds of the run, cycle time over the frames.",
                  ["node", "frames per second", "Mbit/s", "cycle ms", "longest cycle ms",
                   "processor, % of a core", "memory MB"])
    for coder in CODERS:
        table.add_group(coder)
        for node in results.sensors("at_once"):
            def value(quantity, coder=coder, node=node):
                return results.value("at_once", node, coder, 4, quantity)
            table.add_row([node.replace("_", " "),
                           mean_and_deviation(value("frames_per_second"), 1),
                           mean_and_deviation(value("megabits_per_second"), 2),
                           mean_and_deviation(value("cycle_ms"), 2),
                           number(value("max_cycle_ms").mean, 1),
                           mean_and_deviation(value("cpu_percent"), 1),
                           number(value("memory_mb").mean, 1)])
    return table


def merge_table(results):
    """Merging at the central node."""
    table = Table("Merging of all streams at the central node, 20 times per second; no voxel "
                  "is removed before.",
                  ["coder", "merging ms", "merged voxels", "load average before the run"])
    for coder in CODERS:
        table.add_row([coder] + [
            mean_and_deviation(results.value("at_once", "central", coder, 4, quantity), digits)
            for quantity, digits in (("merge_ms", 2), ("merged_voxels", 0),
                                     ("load_before", 1))])
    return table


def summary_table(results):
    """The paper's main values and their counterparts."""
    table = beside_paper("Main values of the paper and of sensor 1, means over the frames.",
                         CODERS)

    def add(words, reported, digits, measure):
        values = [_derived(measure(coder)) for coder in CODERS]
        add_beside_paper(table, words, reported, digits, values)

    def mean(coder, cm, quantity):
        return results.mean("compression", "1", coder, cm, quantity)

    def kib_per_second(coder):
        return mean(coder, 4, "megabits_per_second") * KIB_PER_SECOND_OF_MEGABIT
    for cm in (4, 2):
        add(f"compression ratio, {cm} cm", COMPRESSION[cm]["ratio"][0], 1,
            lambda coder, cm=cm: mean(coder, cm, "ratio"))
        add(f"bytes per voxel, {cm} cm", COMPRESSION[cm]["bytes per voxel"][0], 2,
            lambda coder, cm=cm: mean(coder, cm, "bytes_per_voxel"))
    add("KiB/s of a sensor at 20 Hz, 4 cm", PERFORMANCE["compression at 20 Hz"]["KiB/s"], 1,
        kib_per_second)
    add("KiB/s of its cropped points", UNCOMPRESSED_KIB_PER_SECOND, 0,
        lambda coder: _cropped_kib(results).mean * RATES["1"])
    add("sensors in a gigabit, 4 cm (about)", SENSORS_IN_A_GIGABIT, 0,
        lambda coder: GIGABIT_IN_MEGABITS / mean(coder, 4, "megabits_per_second"))
    return table


def filter_table(kept):
    """What the filters of Figure 11 leave, by distance from the sensor; kept[filter][band] is
    kept surface, all surface, kept noise and all noise."""
    bands = list(next(iter(kept.values())))
    table = Table("Voxels of the six Kinect V2 in the frame of Figure 11 that each filter "
                  "keeps, by distance from the sensor.",
                  ["filter", "of"] + bands)
    for name, by_band in kept.items():
        for words, first in (("surface %", 0), ("noise %", 2)):
            table.add_row([name, words] + [
                number(100 * by_band[band][first] / by_band[band][first + 1], 1)
                if by_band[band][first + 1] else DASH for band in bands])
    return table

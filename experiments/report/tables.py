"""The report's tables: the paper's figures, as far as they are at hand, and measured ones."""

from page import DASH, NOT_AT_HAND, Table, mean_and_deviation, number
from results import CODERS, LIDAR

# From the paper's abstract, and from what simulator/README.md quotes of its text.
PAPER = {
    "cropped_points": 37100,
    "ratio_4cm": 40.5,
    "sensors_in_gigabit": 440,
    4: {"voxels": 17800, "bytes_per_voxel": 0.82},
    2: {"voxels": 33300, "bytes_per_voxel": 0.80},
}

GIGABIT_IN_MEGABITS = 1000.0


def _sensor_name(sensor):
    return f"{sensor}, VLP-16" if sensor == LIDAR else f"{sensor}, Kinect V2"


def summary_table(results):
    """The paper's figures that are at hand, all of sensor 1, and their like."""
    table = Table("Sensor 1, number of points as intensity: all figures of the paper that "
                  "are at hand, and what was measured; means over the frames.",
                  ["", "paper"] + list(CODERS))
    points = number(results.figure("cropping", "1", "SensorPreprocessor", 4,
                                   "cropped_points").mean, 0)
    table.add_row(["points in the crop box", number(PAPER["cropped_points"], 0)]
                  + [points] * len(CODERS))

    def add_row(words, paper, resolution_cm, quantity, digits):
        table.add_row([words, number(paper, digits)] + [
            number(results.figure("compression", "1", coder, resolution_cm,
                                  quantity).mean, digits) for coder in CODERS])
    for resolution_cm in (4, 2):
        paper = PAPER[resolution_cm]
        add_row(f"voxels, {resolution_cm} cm", paper["voxels"], resolution_cm, "voxels", 0)
        add_row(f"bytes per voxel, {resolution_cm} cm", paper["bytes_per_voxel"],
                resolution_cm, "bytes_per_voxel", 2)
    add_row("compression ratio, 4 cm", PAPER["ratio_4cm"], 4, "ratio", 1)
    table.add_row(["sensors in a gigabit, 4 cm",
                   "about " + number(PAPER["sensors_in_gigabit"], 0)]
                  + [number(_sensors_in_gigabit(results, "compression", "1", coder, 4), 0)
                     for coder in CODERS])
    return table.html()


def _sensors_in_gigabit(results, *subject):
    return GIGABIT_IN_MEGABITS / results.figure(*subject, "megabits_per_second").mean


def cropping_table(results):
    table = Table("Points of a frame, mean ± standard deviation over the frames.",
                  ["sensor", "with a return", "in the crop box", "kept %",
                   "moving and cropping, ms"])
    table.add_row(["1, paper", NOT_AT_HAND, number(PAPER["cropped_points"], 0),
                   NOT_AT_HAND, NOT_AT_HAND], is_of_paper=True)
    for sensor in results.sensors("cropping"):
        def cell(quantity, digits, sensor=sensor):
            return mean_and_deviation(
                results.figure("cropping", sensor, "SensorPreprocessor", 4, quantity),
                digits)
        table.add_row([_sensor_name(sensor), cell("points", 0), cell("cropped_points", 0),
                       cell("kept_percent", 1), cell("preprocess_ms", 2)])
    return table.html()


COMPRESSION_HEADER = ["coder", "voxels", "bytes", "bytes per voxel",
                      "ratio", "Mbit/s", "encode ms", "decode ms", "sensors in a gigabit"]


def _compression_row(results, experiment, sensor, coder, resolution_cm):
    def figure(quantity):
        return results.figure(experiment, sensor, coder, resolution_cm, quantity)
    return [coder,
            mean_and_deviation(figure("voxels"), 0),
            mean_and_deviation(figure("bytes"), 0),
            mean_and_deviation(figure("bytes_per_voxel"), 3),
            mean_and_deviation(figure("ratio"), 1),
            mean_and_deviation(figure("megabits_per_second"), 2),
            mean_and_deviation(figure("encode_ms"), 2),
            mean_and_deviation(figure("decode_ms"), 2),
            number(_sensors_in_gigabit(results, experiment, sensor, coder,
                                       resolution_cm), 0)]


def _paper_row(resolution_cm):
    paper = PAPER[resolution_cm]
    is_4cm = resolution_cm == 4
    return ["paper", number(paper["voxels"], 0), NOT_AT_HAND,
            number(paper["bytes_per_voxel"], 2),
            number(PAPER["ratio_4cm"], 1) if is_4cm else NOT_AT_HAND, NOT_AT_HAND,
            NOT_AT_HAND, NOT_AT_HAND,
            number(PAPER["sensors_in_gigabit"], 0) if is_4cm else NOT_AT_HAND]


def compression_table(results):
    """Sensor 1, beside the paper."""
    table = Table("Sensor 1, mean ± standard deviation over the frames.",
                  COMPRESSION_HEADER)
    for resolution_cm in (4, 2):
        table.add_chapter(f"{resolution_cm} cm, number of points as intensity")
        table.add_row(_paper_row(resolution_cm), is_of_paper=True)
        for coder in CODERS:
            table.add_row(_compression_row(results, "compression", "1", coder,
                                           resolution_cm))
    for law in ("quadratic", "linear"):
        table.add_chapter(f"4 cm, {law} law")
        for coder in CODERS:
            table.add_row(_compression_row(results, law, "1", coder, 4))
    return table.html()


def all_sensors_table(results):
    """Bytes per voxel and ratio of every sensor."""
    header = ["sensor"]
    for quantity in ("voxels", "bytes per voxel", "ratio"):
        header += ([quantity] if quantity == "voxels"
                   else [f"{quantity}, {coder}" for coder in CODERS])
    table = Table("All sensors, means over the frames; voxels of the efforts.", header)
    for resolution_cm in (4, 2):
        table.add_chapter(f"{resolution_cm} cm")
        for sensor in results.sensors("compression"):
            def mean(coder, quantity, digits, sensor=sensor, cm=resolution_cm):
                return number(results.figure("compression", sensor, coder, cm,
                                             quantity).mean, digits)
            table.add_row([_sensor_name(sensor), mean("balanced", "voxels", 0)]
                          + [mean(coder, "bytes_per_voxel", 3) for coder in CODERS]
                          + [mean(coder, "ratio", 1) for coder in CODERS])
    return table.html()


def depth_image_table(results):
    table = Table("Sensor 1's depth image, mean ± standard deviation over the frames.",
                  ["coder", "bytes", "ratio", "Mbit/s", "encode ms", "decode ms",
                   "depth error, mm RMS", "wrong pixels %"])
    table.add_row(["paper"] + [NOT_AT_HAND] * 7, is_of_paper=True)

    def add_rows(coders):
        for coder in coders:
            def cell(quantity, digits, coder=coder):
                return mean_and_deviation(
                    results.figure("depth_image", "1", coder, 0, quantity), digits)
            table.add_row([coder.replace(" cropped", ""), cell("bytes", 0), cell("ratio", 1),
                           cell("megabits_per_second", 1), cell("encode_ms", 2),
                           cell("decode_ms", 2), cell("error_mm", 0),
                           cell("wrong_percent", 1)])
    coders = results.coders("depth_image")
    table.add_chapter("the whole image")
    add_rows([coder for coder in coders if not coder.endswith("cropped")])
    table.add_chapter("what lies outside of the crop box set to no return")
    add_rows([coder for coder in coders if coder.endswith("cropped")])
    table.add_chapter("for comparison, voxels of 4 cm with a count")
    for coder in CODERS:
        row = _compression_row(results, "compression", "1", coder, 4)
        table.add_row([coder, row[2], row[4], row[5], row[6], row[7], DASH, DASH])
    return table.html()


def at_once_table(results):
    table = Table("All sensors' nodes and the central one at once, 4 cm; mean ± standard "
                  "deviation over the seconds of the run, cycle time over the frames.",
                  ["node", "frames a second", "Mbit/s", "cycle ms", "longest cycle ms",
                   "processor, % of a core", "memory MB"])
    table.add_chapter("paper")
    table.add_row(["all nodes"] + [NOT_AT_HAND] * 6, is_of_paper=True)
    for coder in CODERS:
        table.add_chapter(coder)
        for node in results.sensors("at_once"):
            def figure(quantity, coder=coder, node=node):
                return results.figure("at_once", node, coder, 4, quantity)
            table.add_row([node.replace("_", " "),
                           mean_and_deviation(figure("frames_per_second"), 1),
                           mean_and_deviation(figure("megabits_per_second"), 2),
                           mean_and_deviation(figure("cycle_ms"), 2),
                           number(figure("max_cycle_ms").mean, 1),
                           mean_and_deviation(figure("cpu_percent"), 1),
                           number(figure("memory_mb").mean, 1)])
    return table.html()


def merge_table(results):
    table = Table("The central node's merging of all streams, 20 times a second; no voxel is "
                  "removed before.",
                  ["coder", "merging ms", "merged voxels", "load average before the run"])
    for coder in CODERS:
        table.add_row([coder] + [
            mean_and_deviation(results.figure("at_once", "central", coder, 4, quantity),
                               digits)
            for quantity, digits in (("merge_ms", 2), ("merged_voxels", 0), ("load_before", 1))])
    return table.html()


def resolution_table(results):
    table = Table("Sensor 1, bits per voxel, means over the frames.",
                  ["voxel edge cm", "voxels"] + list(CODERS))
    for resolution_cm in range(1, 21):
        def mean(coder, quantity, cm=resolution_cm):
            return results.figure("resolution", "1", coder, cm, quantity).mean
        table.add_row([str(resolution_cm), number(mean("balanced", "voxels"), 0)]
                      + [number(8 * mean(coder, "bytes_per_voxel"), 2)
                         for coder in CODERS])
    return table.html()


def filtering_table(counts):
    """Of one frame of the six Kinects: what each filter of Figure 11 leaves."""
    table = Table("Voxels of the six Kinects in the frame of Figure 11.",
                  ["filter", "voxels", "surface", "of it kept %", "noise",
                   "of it let through %"])
    all_voxels, all_noise = counts["none"]
    for name, (voxels, noise) in counts.items():
        surface = voxels - noise
        table.add_row([name, number(voxels, 0), number(surface, 0),
                       _percent(surface, all_voxels - all_noise),
                       number(noise, 0), _percent(noise, all_noise)])
    return table.html()


def _percent(part, whole):
    return number(100 * part / whole, 1) if whole else DASH

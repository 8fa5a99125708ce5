"""The report's tables of noise."""

from noise_results import (AIM_AVERAGE_PRECISION, AIM_LET_THROUGH, BANDS, FILTER,
                           FILTER_OF_EACH, FILTER_ON_VOXELS, FILTER_THRESHOLDS, FILTER_WITHOUT_HISTORY,
                           METHODS, best_law, least_let_through)
from page import DASH, Table, mean_of, number
from results import CAMERAS, LIDAR, MERGED

# Columns of a decision: heading, quantity, digits.
SHARES = (("let through %", "let_through_percent", 1),
          ("surfaces %", "surface_kept_percent", 1),
          ("still %", "still_kept_percent", 1),
          ("machines %", "machine_kept_percent", 1),
          ("person %", "person_kept_percent", 1),
          ("worst frame %", "person_worst_percent", 0))
SCORES = (("precision", "precision", 3), ("recall", "recall", 3), ("F1", "f1", 3))


def _headings(columns):
    return [heading for heading, _, _ in columns]


def _cells(results, columns, *subject, prefix=""):
    """The values of columns, or dashes."""
    return [mean_of(results.find(*subject, prefix + quantity), digits)
            for _, quantity, digits in columns]


def _is_met(met):
    return "met" if met else "not met"


def _summary_row(results, name, sensor, method, resolution_cm):
    subject = ("noise", sensor, method, resolution_cm)
    law = best_law(results, sensor, resolution_cm)
    of_law = results.mean("noise", sensor, law, resolution_cm, "average_precision")
    precision = results.mean(*subject, "average_precision")
    let_through = results.mean(*subject, "usual_let_through_percent")
    least = least_let_through(results, sensor, resolution_cm)
    return [name, mean_of(results.find(*subject, "noise_percent"), 1),
            f"{number(of_law, 3)}, {law}", number(precision, 3),
            _is_met(precision >= AIM_AVERAGE_PRECISION), number(least, 1),
            number(let_through, 1), _is_met(let_through <= AIM_LET_THROUGH * least)
            ] + _cells(results, SHARES[-2:], *subject, prefix="usual_")


def summary_table(results):
    """A row for each sensor, and for all merged."""
    table = Table("Noise detected by the best law and by the filter.",
                  ["sensor", "noise %", "AP, best law", "AP, filter", "0.9",
                   "let through %, best law", "let through %, filter", "a fifth",
                   "person kept %", "in the worst frame %"])
    table.add_group("4 cm, filter on quadratic intensities")
    for sensor in CAMERAS:
        table.add_row(_summary_row(results, sensor, sensor, FILTER, 4))
    table.add_group("4 cm, all six cameras merged, filter before or after merging")
    table.add_row(_summary_row(results, "after", MERGED, FILTER, 4))
    table.add_row(_summary_row(results, "before", MERGED, FILTER_OF_EACH, 4))
    for resolution_cm in (2, 1):
        table.add_group(f"{resolution_cm} cm, filter on quadratic intensities")
        for sensor in results.sensors("noise", resolution_cm=float(resolution_cm)):
            table.add_row(_summary_row(results, sensor, sensor, FILTER, resolution_cm))
    table.add_group("The lidar, filter without intensities")
    for resolution_cm in (4, 10, 20):
        if LIDAR not in results.sensors("noise", resolution_cm=float(resolution_cm)):
            continue
        table.add_row(_summary_row(results, f"{LIDAR}, {resolution_cm} cm", LIDAR,
                                   FILTER_ON_VOXELS, resolution_cm))
    return table


def methods_table(results):
    """All methods of all sensors, at their best threshold and where 95 % are kept."""
    columns = (("AP", "average_precision", 3), ("best threshold", "best_threshold", 2),
               *((heading, "best_" + quantity, digits)
                 for heading, quantity, digits in SCORES),
               ("95 % threshold", "usual_threshold", 2),
               *((heading, "usual_" + quantity, digits)
                 for heading, quantity, digits in SHARES))
    table = Table("Each method on each sensor: at the threshold of the best F1, and at the "
                  "highest that keeps 95 % of the surfaces' voxels.",
                  ["sensor"] + _headings(columns))
    subjects = [(sensor, 4) for sensor in METHODS] + [
        (sensor, resolution_cm) for resolution_cm in (1, 2, 10, 20)
        for sensor in results.sensors("noise", resolution_cm=float(resolution_cm))]
    for method in dict.fromkeys(name for names in METHODS.values() for name in names):
        table.add_group(method)
        for sensor, resolution_cm in subjects:
            if method in METHODS[sensor]:
                name = sensor if resolution_cm == 4 else f"{sensor}, {resolution_cm} cm"
                table.add_row([name] + _cells(results, columns, "noise", sensor, method,
                                              resolution_cm))
    return table


def noise_of_bands_table(results):
    """Share of noise at each distance."""
    table = Table("Noise % of the voxels, by their distance from the sensor.",
                  ["sensor"] + list(BANDS))
    for sensor in CAMERAS + (LIDAR,):
        row = [sensor]
        for band in BANDS:
            noise, surface = (results.mean("noise_band:" + band, sensor, "count", 4, kind)
                              for kind in ("noise_voxels", "surface_voxels"))
            row.append(number(100 * noise / (noise + surface), 1) if noise + surface
                       else DASH)
        table.add_row(row)
    return table


def bands_table(results, caption, quantity, digits):
    """A quantity by distance; a dash where a band has no surface or no noise."""
    table = Table(caption, ["sensor"] + list(BANDS))

    def cell(band, sensor, method):
        subject = ("noise_band:" + band, sensor, method, 4)
        is_judged = all(results.mean(*subject, voxels) > 0
                        for voxels in ("noise_voxels", "surface_voxels"))
        return mean_of(results.find(*subject, quantity), digits) if is_judged else DASH
    for method in dict.fromkeys(name for sensor in CAMERAS + (LIDAR,)
                                for name in METHODS[sensor]):
        table.add_group(method)
        for sensor in CAMERAS + (LIDAR,):
            if method in METHODS[sensor]:
                table.add_row([sensor] + [cell(band, sensor, method) for band in BANDS])
    return table


def thresholds_table(results, sensor):
    """A sensor's values at each threshold of each method."""
    table = Table("", ["threshold"] + _headings(SCORES + SHARES))
    prefix = "noise_threshold:"
    for method in METHODS[sensor]:
        table.add_group(method)
        for threshold in sorted(results.experiments(prefix), key=float):
            subject = (prefix + threshold, sensor, method, 4)
            if results.find(*subject, "surface_kept_percent"):
                table.add_row([threshold] + _cells(results, SCORES + SHARES, *subject))
    return table


def person_table(results):
    """Shares of moving surfaces that the filter keeps, at thresholds that users set, and where
    95 % of all surfaces are kept."""
    columns = (SHARES[0],) + SHARES[2:]
    table = Table("Voxels kept of noise, of what stands still, of machines and of the person, "
                  "at log-odds 0 (the default) and 2.5, and at those that keep 95 % of the "
                  "surfaces' voxels. Frames below 80 %: frames in which less than that is "
                  "kept of the person, of those with at least 20 of the person's voxels.",
                  ["sensor"] + _headings(columns) + ["frames below 80 %"])

    def add_rows(words, method, experiment, prefix):
        table.add_group(f"{method}, {words}")
        for sensor in CAMERAS:
            subject = (experiment, sensor, method, 4)
            frames, poor = (results.find(*subject, prefix + "person_" + quantity)
                            for quantity in ("frames", "poor_frames"))
            table.add_row([sensor] + _cells(results, columns, *subject, prefix=prefix)
                          + [f"{poor.mean:.0f} of {frames.mean:.0f}"
                             if frames and frames.mean else DASH])
    for method in (FILTER, FILTER_WITHOUT_HISTORY):
        for threshold in FILTER_THRESHOLDS:
            add_rows(f"log-odds {threshold}", method, "noise_threshold:" + threshold, "")
        add_rows("95 % of the surfaces' voxels kept", method, "noise", "usual_")
    return table


def _family_and_setting(name):
    """A filter's name, and its setting."""
    family, _, setting = name.partition(" ")
    return ("VoxelOutlierRemoval", "on " + setting.split()[-1]) if family == "filter" \
        else (family, setting)


def _add_by_family(table, methods, suffix, cells):
    """A group for each filter, and a row for each of its settings."""
    last_family = None
    for method in methods:
        family, setting = _family_and_setting(method)
        if family != last_family:
            table.add_group(family + suffix)
            last_family = family
        table.add_row([setting] + cells(method))


def peers_table(results):
    """PCL's filters against this library's."""
    shares = (SHARES[0],) + SHARES[2:]
    table = Table("PCL's filters on the centres of sensor 1's voxels, 4 cm, and this "
                  "library's.", ["setting", "AP"] + _headings(SCORES + shares))

    def cells(method):
        subject = ("noise_peers", "1", method, 4)
        return ([mean_of(results.find(*subject, "average_precision"), 3)]
                + _cells(results, SCORES, *subject, prefix="best_")
                + _cells(results, shares, *subject, prefix="usual_"))
    _add_by_family(table, results.coders("noise_peers"), "", cells)
    return table


def times_table(results):
    """Processor time of a frame."""
    table = Table("Processor time of a frame, milliseconds.",
                  ["setting", "median", "longest", "÷ this library's on quadratic"])
    for sensor, resolution_cm in (("1", 4), ("5", 2)):
        def value(method, quantity, sensor=sensor, cm=resolution_cm):
            return results.mean("noise_time", sensor, method, cm, quantity)

        def cells(method, value=value):
            median = value(method, "median_ms")
            return [number(median, 2), number(value(method, "longest_ms"), 2),
                    number(median / value(methods[0], "median_ms"), 1)]
        methods = results.coders("noise_time", sensor=sensor,
                                 resolution_cm=float(resolution_cm))
        _add_by_family(table, methods, f", sensor {sensor}, {resolution_cm} cm, "
                       f"{number(value(methods[0], 'voxels'), 0)} voxels", cells)
    return table


def bytes_table(results):
    """Bytes of a stream whose noise is removed."""
    columns = (("voxels", "voxels", 0), ("bytes", "bytes", 0),
               ("bytes saved %", "less_percent", 1))
    table = Table("Sensor 1's stream, 4 cm; means of a frame.",
                  ["filter"] + _headings(columns))
    prefix = "noise_bytes:"
    for coding in results.experiments(prefix):
        table.add_group(coding.replace(" ", ", "))
        for name in results.coders(prefix + coding):
            table.add_row([name] + _cells(results, columns, prefix + coding, "1", name, 4))
    return table

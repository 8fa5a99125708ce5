"""The report's tables of noise."""

from noise_results import (AIM_AVERAGE_PRECISION, AIM_LET_THROUGH, BANDS, FILTER,
                           FILTER_OF_EACH, FILTER_THRESHOLDS, FILTER_WITHOUT_HISTORY,
                           METHODS, best_law, least_let_through)
from page import DASH, Table, number, mean_of
from results import CAMERAS, LIDAR, MERGED

# Of the decisions' tables: heading, quantity, digits.
DECISION = (("noise let through %", "let_through_percent", 1),
            ("surfaces kept %", "surface_kept_percent", 1),
            ("still kept %", "still_kept_percent", 1),
            ("machines kept %", "machine_kept_percent", 1),
            ("person kept %", "person_kept_percent", 1),
            ("worst frame %", "person_worst_percent", 0))


def _is_met(met):
    return "met" if met else "not met"


def _summary_row(results, name, sensor, method, resolution_cm):
    def mean(quantity):
        return results.mean("noise", sensor, method, resolution_cm, quantity)

    def found(quantity, digits):
        return mean_of(results.find("noise", sensor, method, resolution_cm, quantity),
                         digits)
    law = best_law(results, sensor, resolution_cm)
    precision = mean("average_precision")
    let_through = mean("usual_let_through_percent")
    of_law = least_let_through(results, sensor, resolution_cm)
    return [name, found("noise_percent", 1),
            number(results.mean("noise", sensor, law, resolution_cm,
                                "average_precision"), 3) + f", {law}",
            number(precision, 3), _is_met(precision >= AIM_AVERAGE_PRECISION),
            number(of_law, 1), number(let_through, 1),
            _is_met(let_through <= AIM_LET_THROUGH * of_law),
            found("usual_person_kept_percent", 1),
            found("usual_person_worst_percent", 0)]


def summary_table(results):
    """A row for each sensor, and for what is made of all."""
    table = Table(
        "Average precision (AP) of “this voxel is noise”, and how much noise is let "
        "through where 95 % of the surfaces' voxels stay.",
        ["sensor", "noise %", "AP, best law", "AP, filter", "0.9",
         "let through %, best law", "let through %, filter", "a fifth",
         "person kept %", "in the worst frame %"])
    table.add_group("4 cm, filter on quadratic intensities")
    for sensor in CAMERAS:
        table.add_row(_summary_row(results, sensor, sensor, FILTER, 4))
    table.add_group("4 cm, all six cameras merged")
    table.add_row(_summary_row(results, "filter after", MERGED, FILTER, 4))
    table.add_row(_summary_row(results, "filter before", MERGED, FILTER_OF_EACH, 4))
    table.add_group("2 cm, filter on quadratic intensities")
    for sensor in results.sensors("noise", resolution_cm=2.0):
        table.add_row(_summary_row(results, sensor, sensor, FILTER, 2))
    table.add_group("4 cm, the lidar's own intensities, which the filter is not made for")
    table.add_row(_summary_row(results, LIDAR, LIDAR, "filter on native", 4))
    return table


def methods_table(results):
    """All methods of all sensors, at their best threshold and where 95 % stay."""
    table = Table(
        "Each way to tell noise, on each sensor: at the threshold of the best F1, and at "
        "the highest that keeps 95 % of the surfaces' voxels.",
        ["sensor", "AP", "best threshold", "precision", "recall", "F1",
         "95 % threshold", "let through %", "still %", "machines %", "person %",
         "worst frame %"])
    subjects = [(sensor, 4) for sensor in METHODS] + [
        (sensor, 2) for sensor in results.sensors("noise", resolution_cm=2.0)]
    for method in dict.fromkeys(name for names in METHODS.values() for name in names):
        table.add_group(method)
        for sensor, resolution_cm in subjects:
            if method not in METHODS[sensor]:
                continue
            row = [sensor if resolution_cm == 4 else f"{sensor}, {resolution_cm} cm"]
            for quantity, digits in (
                    ("average_precision", 3), ("best_threshold", 2),
                    ("best_precision", 3), ("best_recall", 3), ("best_f1", 3),
                    ("usual_threshold", 2), ("usual_let_through_percent", 1),
                    ("usual_still_kept_percent", 1), ("usual_machine_kept_percent", 1),
                    ("usual_person_kept_percent", 1),
                    ("usual_person_worst_percent", 0)):
                row.append(mean_of(results.find("noise", sensor, method, resolution_cm,
                                                  quantity), digits))
            table.add_row(row)
    return table


def noise_of_bands_table(results):
    """How much of what lies at each distance is noise."""
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
    """A quantity by depth; a dash where a band has no surface or no noise."""
    table = Table(caption, ["sensor"] + list(BANDS))
    for method in dict.fromkeys(name for sensor in CAMERAS + (LIDAR,)
                                for name in METHODS[sensor]):
        table.add_group(method)
        for sensor in CAMERAS + (LIDAR,):
            if method not in METHODS[sensor]:
                continue
            row = [sensor]
            for band in BANDS:
                def find(wanted, band=band, sensor=sensor, method=method):
                    return results.find("noise_band:" + band, sensor, method, 4, wanted)
                is_judged = all(results.mean("noise_band:" + band, sensor, method, 4,
                                             voxels) > 0
                                for voxels in ("noise_voxels", "surface_voxels"))
                row.append(mean_of(find(quantity), digits) if is_judged else DASH)
            table.add_row(row)
    return table


def thresholds_table(results, sensor):
    """A sensor's figures at each threshold of each method."""
    table = Table("", ["threshold", "precision", "recall", "F1"]
                  + [heading for heading, _, _ in DECISION])
    prefix = "noise_threshold:"
    thresholds = sorted(results.experiments(prefix), key=float)
    for method in METHODS[sensor]:
        table.add_group(method)
        for threshold in thresholds:
            def find(quantity, method=method, threshold=threshold):
                return results.find(prefix + threshold, sensor, method, 4, quantity)
            if find("surface_kept_percent") is None:
                continue
            table.add_row([threshold] + [mean_of(find(quantity), 3)
                                         for quantity in ("precision", "recall", "f1")]
                          + [mean_of(find(quantity), digits)
                             for _, quantity, digits in DECISION])
    return table


def _person_row(results, experiment, sensor, method, prefix=""):
    def find(quantity):
        return results.find(experiment, sensor, method, 4, prefix + quantity)
    frames = find("person_frames")
    poor_frames = (f"{find('person_poor_frames').mean:.0f} of {frames.mean:.0f}"
                   if frames and frames.mean else DASH)
    return [sensor] + [mean_of(find(quantity), digits) for quantity, digits in (
        ("let_through_percent", 1), ("still_kept_percent", 1),
        ("machine_kept_percent", 1), ("person_kept_percent", 1),
        ("person_worst_percent", 0))] + [poor_frames]


def person_table(results):
    """What the filter leaves of what moves, at thresholds that users set, and where as much
    is left of all surfaces."""
    table = Table(
        "What stays of noise, of machines and of the person: at log-odds 0 (the default) "
        "and 2.5, and at the log-odds that keep 95 % of the sensor's surfaces' voxels. "
        "The worst frame, and frames in which less than 80 % of the person stays, are of "
        "those with 20 of the person's voxels or more; –: the person is not seen.",
        ["sensor", "noise %", "still %", "machines %", "person %", "worst frame %",
         "frames below 80 %"])
    for method in (FILTER, FILTER_WITHOUT_HISTORY):
        for threshold in FILTER_THRESHOLDS:
            table.add_group(f"{method}, log-odds {threshold}")
            for sensor in CAMERAS:
                table.add_row(_person_row(results, "noise_threshold:" + threshold, sensor,
                                          method))
    for method in (FILTER, FILTER_WITHOUT_HISTORY):
        table.add_group(f"{method}, 95 % of the surfaces' voxels kept")
        for sensor in CAMERAS:
            table.add_row(_person_row(results, "noise", sensor, method, "usual_"))
    return table


def _family_and_setting(name):
    """A filter's name, and how it is set."""
    family, _, setting = name.partition(" ")
    return ("VoxelOutlierRemoval", "on " + setting.split()[-1]) if family == "filter" \
        else (family, setting)


def peers_table(results):
    """PCL's filters against this library's."""
    table = Table("PCL's filters on the centres of sensor 1's voxels, 4 cm, and this "
                  "library's.",
                  ["setting", "AP", "precision", "recall", "F1", "let through %",
                   "still %", "machines %", "person %", "worst frame %"])
    last_family = None
    for method in results.coders("noise_peers"):
        family, setting = _family_and_setting(method)
        if family != last_family:
            table.add_group(family)
            last_family = family

        def find(quantity, method=method):
            return results.find("noise_peers", "1", method, 4, quantity)
        table.add_row([setting, mean_of(find("average_precision"), 3)]
                      + [mean_of(find("best_" + quantity), 3)
                         for quantity in ("precision", "recall", "f1")]
                      + [mean_of(find(f"usual_{quantity}_percent"), digits)
                         for quantity, digits in (
                             ("let_through", 1), ("still_kept", 1), ("machine_kept", 1),
                             ("person_kept", 1), ("person_worst", 0))])
    return table


def times_table(results):
    """Processor time of a frame."""
    table = Table("Processor time of a frame, milliseconds.",
                  ["setting", "median", "longest", "times this library's on quadratic"])
    for sensor, resolution_cm in (("1", 4), ("5", 2)):
        methods = results.coders("noise_time", sensor=sensor,
                                 resolution_cm=float(resolution_cm))
        own = results.mean("noise_time", sensor, methods[0], resolution_cm, "median_ms")
        voxels = results.mean("noise_time", sensor, methods[0], resolution_cm, "voxels")
        last_family = None
        for method in methods:
            family, setting = _family_and_setting(method)
            if family != last_family:
                table.add_group(f"{family}, sensor {sensor}, {resolution_cm} cm, "
                                  f"{number(voxels, 0)} voxels")
                last_family = family
            median = results.mean("noise_time", sensor, method, resolution_cm,
                                  "median_ms")
            table.add_row([setting, number(median, 2),
                           mean_of(results.find("noise_time", sensor, method,
                                                  resolution_cm, "longest_ms"), 2),
                           number(median / own, 1)])
    return table


def bytes_table(results):
    """What a stream shrinks by."""
    table = Table("Sensor 1's stream, 4 cm, where the filter runs in its SensorNode; means "
                  "of a frame.",
                  ["filter", "voxels", "bytes", "less bytes %"])
    prefix = "noise_bytes:"
    for coding in results.experiments(prefix):
        table.add_group(coding.replace(" ", ", "))
        for name in results.coders(prefix + coding):
            def find(quantity, coding=coding, name=name):
                return results.find(prefix + coding, "1", name, 4, quantity)
            table.add_row([name, mean_of(find("voxels"), 0),
                           mean_of(find("bytes"), 0),
                           mean_of(find("less_percent"), 1)])
    return table

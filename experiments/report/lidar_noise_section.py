"""The report's section on noise of lidars, and its checks."""

from page import DASH, Table, mean_of, note, number, paragraph, picture
from results import ReportError

SNOW, DUST = "7 in snow", "7 in dust"
# Sensor of the results, and the air in words.
AIRS = {"7": "clear air", SNOW: "snow, 1.5 mm of water an hour",
        DUST: "a cloud of dust"}
FILTER = "filter on points"
# Method: its name in words, and its threshold; that of DSOR's authors is for another lidar,
# outdoors, and removes all points here.
METHODS = {FILTER: ("PointOutlierRemoval", "0.0"),
           "filter on rays": ("VoxelOutlierRemoval, rays, voxels of 10 cm", "0.0"),
           "filter on voxels": ("VoxelOutlierRemoval, voxels, voxels of 10 cm", "0.0"),
           "DSOR 5 neighbours": ("DSOR, 5 neighbours", None),
           "DROR 10 steps": ("DROR, radius of 10 azimuth steps", "2.0")}
RESOLUTION_CM = 10


def _points(results, experiment, sensor, method, quantity):
    """Of points; methods that score voxels have results of points by the voxels' edge."""
    of_points = results.find(experiment, sensor, method, 0, quantity)
    return of_points or results.find(experiment, sensor, method, RESOLUTION_CM, quantity)


def _at_threshold(results, sensor, method, quantity):
    """At the method's threshold."""
    return _points(results, f"scan_points_threshold:{METHODS[method][1]}", sensor, method,
                   quantity)


def _removed_percent(results, sensor, method):
    """Noise that is removed at that threshold, or None."""
    let_through = _at_threshold(results, sensor, method, "let_through_percent")
    return None if let_through is None else 100 - let_through.mean


def lidar_table(results):
    """All methods in clear air, snow and dust."""
    table = Table("Noise of the lidar that is found among its points.",
                  ["method", "AP, points", "AP, voxels of 10 cm", "95 %: let through %",
                   "95 %: person kept %", "own threshold: noise removed %",
                   "surfaces kept %", "person kept %", "ms"])
    for sensor, air in AIRS.items():
        noise = _points(results, "scan_points", sensor, FILTER, "noise_percent")
        table.add_group(f"{air}: {mean_of(noise, 1)} % of the points are noise")
        for method, (words, _) in METHODS.items():
            subject = (results, sensor, method)
            precision, let_through, person = (
                _points(results, "scan_points", sensor, method, quantity)
                for quantity in ("average_precision", "usual_let_through_percent",
                                 "usual_person_kept_percent"))
            if precision is None:
                raise ReportError(f"the measurements lack {method} of sensor {sensor}")
            removed = _removed_percent(*subject)
            table.add_row([
                words, mean_of(precision, 3),
                mean_of(results.find("scan_voxels", sensor, method, RESOLUTION_CM,
                                     "average_precision"), 3),
                mean_of(let_through, 1), mean_of(person, 1),
                DASH if removed is None else number(removed, 1),
                *(mean_of(_at_threshold(*subject, quantity), digits)
                  for quantity, digits in (("surface_kept_percent", 2),
                                           ("person_kept_percent", 1))),
                mean_of(_points(results, "scan_time", sensor, method, "median_ms"), 1)])
    return table


def lidar_noise_section(results, snow_picture):
    """The section's HTML."""
    frames = results.value("scan_time", "7", FILTER, 0, "median_ms").samples
    snow, dust = (_removed_percent(results, sensor, FILTER) for sensor in (SNOW, DUST))
    kept = _at_threshold(results, SNOW, FILTER, "surface_kept_percent").mean
    return [
        "<h2>Noise of lidars</h2>",
        paragraph("PointOutlierRemoval tells what floats in the air from surfaces by the "
                  "ranges of the rays around each point, at the sensor, before points "
                  "become voxels. Here on the cell's VLP-16 in simulated snow and dust "
                  "(simulator/README.md): in snow, at log-odds 0, it removes "
                  f"{number(snow, 1)} % of the noise and keeps {number(kept, 2)} % of the "
                  "surfaces' points. Dust is dense, as surfaces are; in it the filter removes "
                  f"{number(dust, 1)} % of the noise."),
        picture(snow_picture, "The lidar in snow, before and after PointOutlierRemoval",
                "One revolution in snow, before and after PointOutlierRemoval at log-odds 0, "
                "the cell from above and as a range image, a ring a row. What stays of "
                "the noise are mixed echoes, which lie near a surface, in clear air, too."),
        lidar_table(results).html(),
        note(f"{frames} revolutions from the start of the stream, seed 1. AP: average "
             "precision, of points, and of voxels of 10 cm, whose score is the highest of "
             "their points. 95 %: noise that is let through, and the "
             "person's points that are kept, where 95 % of all surfaces' points are. Own "
             "threshold: what methods do at log-odds 0, and DROR to points with fewer than two "
             "neighbours, as its authors have it; the threshold of DSOR's authors removes all "
             "points here. Noise of clear air: echoes that mix at edges. ms: processor time "
             "of a revolution. experiments/noise/README.md has more methods, and recorded "
             "scans."),
    ]


def check_lidar_noise(check):
    """The filter finds snow and keeps surfaces, in the numbers and in the picture."""
    for sensor, (fewest, most) in zip(AIRS, ((0.1, 3), (2, 10), (3, 15))):
        share = _points(check.results, "scan_points", sensor, FILTER, "noise_percent")
        check.between(share.mean if share else 0.0, fewest, most, "noise % of sensor", sensor)
        check.between(check.mean("scan_points_threshold:0.0", sensor, FILTER, 0,
                                 "surface_kept_percent"), 99, 100, "surfaces kept of", sensor)
    check.between(_removed_percent(check.results, SNOW, FILTER) or 0.0, 70, 100,
                  "noise removed in snow")
    own, of_voxels = (check.mean("scan_points", SNOW, method, cm, "average_precision")
                      for method, cm in ((FILTER, 0), ("filter on voxels", RESOLUTION_CM)))
    check.between(own, max(0.85, of_voxels + 0.1), 1, "average precision in snow")
    snow = [row["log_odds"] >= 0 for row in check.rows["lidar_in_snow"] if row["is_snow"]]
    surfaces = [row["log_odds"] >= 0 for row in check.rows["lidar_in_snow"]
                if not row["is_snow"] and not row["is_mixed_echo"]]
    check.that(len(snow) > 300 and len(surfaces) > 10_000, "there is little in the snow:",
               len(snow), len(surfaces))
    check.between(sum(snow) / max(len(snow), 1), 0, 0.1, "snow that is shown")
    check.between(sum(surfaces) / max(len(surfaces), 1), 0.99, 1, "surfaces that are shown")

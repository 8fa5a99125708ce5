"""The report's section on noise."""

import noise_tables as tables
import pictures
from noise_results import (AIM_AVERAGE_PRECISION, AIM_LET_THROUGH, FILTER, FILTER_OF_EACH,
                           FILTER_WITHOUT_HISTORY, METHODS, best_law, least_let_through)
from page import bullets, details, note, number, mean_of, paragraph, picture
from results import CAMERAS, LIDAR, MERGED


def aims_in_words(results):
    """Whether the aims are met, in two sentences."""
    def least(quantity, sensors):
        return min((results.mean("noise", sensor, FILTER, 4, quantity), sensor)
                   for sensor in sensors)
    precision, weakest = least("average_precision", CAMERAS)
    shares = {sensor: results.mean("noise", sensor, FILTER, 4,
                                   "usual_let_through_percent")
              / least_let_through(results, sensor) for sensor in CAMERAS + (MERGED,)}
    worst = max(shares, key=shares.get)
    where = "merged voxels" if worst == MERGED else f"sensor {worst}"
    at_2cm = results.mean("noise", "1", FILTER, 2, "average_precision")

    def verdict_on(value):
        return "met" if value >= AIM_AVERAGE_PRECISION else "not met"
    return [
        f"Aim: an average precision of {AIM_AVERAGE_PRECISION} for “this voxel is noise”. "
        f"The least of the six cameras is {number(precision, 3)} (sensor {weakest}): "
        f"{verdict_on(precision)}. The best law reaches "
        f"{number(max(_law_precision(results, sensor) for sensor in CAMERAS), 3)} at most on one camera. "
        f"At 2 cm sensor 1 has {number(at_2cm, 3)}: {verdict_on(at_2cm)}.",
        "Aim: where 95 % of the surfaces' voxels stay, at most a fifth of the noise that "
        "the best law lets through. The largest share is "
        f"{number(100 * shares[worst], 0)} % ({where}): "
        f"{'met' if shares[worst] <= AIM_LET_THROUGH else 'not met'}.",
    ]


def _law_precision(results, sensor):
    return results.mean("noise", sensor, best_law(results, sensor), 4,
                        "average_precision")


class _Words:
    """Figures as words, of sensor 1 if no other is named."""

    def __init__(self, results):
        self.results = results

    def at(self, threshold, method, quantity, sensor="1"):
        return mean_of(self.results.find("noise_threshold:" + threshold, sensor, method,
                                           4, quantity), 1)

    def in_band(self, band, method, quantity, digits=1):
        return mean_of(self.results.find("noise_band:" + band, "1", method, 4, quantity),
                         digits)

    def usual(self, method, quantity, sensor="1", digits=1):
        return mean_of(self.results.find("noise", sensor, method, 4,
                                           "usual_" + quantity), digits)


FAR, NEAR = "9 m and more", "3 to 5 m"


def _where_laws_fail(words):
    return [
        "Count: far away every voxel of a surface holds one point, as noise does. The "
        "lowest threshold that removes anything, 2, keeps "
        f"{words.at('2.0', 'count', 'surface_kept_percent')} % of the surfaces' voxels and "
        f"{words.at('2.0', 'count', 'person_kept_percent')} % of the person's; with 95 % "
        f"kept, {words.usual('count', 'let_through_percent')} % of the noise passes.",
        "Quadratic: one point far away is worth as much as a voxel of a surface, and near "
        "the sensor one of a surface's fringe is worth next to nothing. At the threshold "
        f"that keeps 95 %, {words.in_band(FAR, 'quadratic', 'let_through_percent')} % of "
        "the noise beyond 9 m passes, and at 3 to 5 m "
        f"{words.in_band(NEAR, 'quadratic', 'surface_kept_percent')} % of the surfaces' "
        "voxels stay.",
        "Linear: the same, "
        f"{words.in_band(FAR, 'linear', 'let_through_percent')} % and "
        f"{words.in_band(NEAR, 'linear', 'surface_kept_percent')} %.",
    ]


def _where_the_filter_fails(words):
    # A camera that does not see the person has no such figure.
    kept = {sensor: words.results.find("noise", sensor, FILTER, 4,
                                       "usual_person_kept_percent") for sensor in CAMERAS}
    worst = min((sensor for sensor in CAMERAS if kept[sensor]),
                key=lambda sensor: kept[sensor].mean, default=CAMERAS[0])
    return [
        "The filter: noise that touches a surface, and single points of a surface's "
        "fringe. Far away a voxel's face has one or two rays: beyond 9 m its average "
        f"precision is {words.in_band(FAR, FILTER, 'average_precision', 3)}, and it lets "
        f"{words.in_band(FAR, FILTER, 'let_through_percent')} % through at that threshold; "
        f"at 3 to 5 m {words.in_band(NEAR, FILTER, 'average_precision', 3)} and "
        f"{words.in_band(NEAR, FILTER, 'let_through_percent')} %.",
        "The filter on the person: of all cameras it keeps least of the person on sensor "
        f"{worst}, {words.usual(FILTER, 'person_kept_percent', worst)} % of the person's "
        "voxels where 95 % of all surfaces' stay, in the worst frame "
        f"{words.usual(FILTER, 'person_worst_percent', worst, 0)} %; without history "
        f"{words.usual(FILTER_WITHOUT_HISTORY, 'person_kept_percent', worst)} %.",
        "Merged voxels judged together: noise of one sensor lies beside another's "
        f"surfaces. The filter lets {words.usual(FILTER, 'let_through_percent', MERGED)} % "
        "through; where each camera's voxels are filtered before they are merged, "
        f"{words.usual(FILTER_OF_EACH, 'let_through_percent', MERGED)} %.",
        "Sensor 7, the lidar: its intensity is the surface's reflectivity, which tells "
        "nothing of noise. Its own threshold lets "
        f"{words.usual('native', 'let_through_percent', LIDAR)} % through with 95 % kept. "
        "The filter at log-odds 0 would keep "
        f"{words.at('0.0', 'filter on native', 'surface_kept_percent', LIDAR)} % of the "
        "surfaces' voxels there and let "
        f"{words.at('0.0', 'filter on native', 'let_through_percent', LIDAR)} % of the "
        "noise through, on counts keep "
        f"{words.at('0.0', 'filter on count', 'surface_kept_percent', LIDAR)} %: the rings are so far apart that a voxel of a surface has few "
        "neighbours. It is not to be used on such a stream.",
    ]


def where_each_fails(results):
    """Sentences with the figures of sensor 1, as far as they say no other."""
    words = _Words(results)
    return _where_laws_fail(words) + _where_the_filter_fails(words)


def frames_in_words(results):
    """How many frames each part of the section is of."""
    def frames(experiment, sensor, method, quantity, resolution_cm=4):
        return results.value(experiment, sensor, method, resolution_cm, quantity).samples
    own = "VoxelOutlierRemoval on quadratic"
    return (f"Frames: {frames('noise', '1', FILTER, 'average_precision')} of each sensor "
            f"and merged, {frames('noise', '1', FILTER, 'average_precision', 2)} at 2 cm, "
            f"{frames('noise_peers', '1', FILTER, 'average_precision')} for PCL's filters, "
            f"{frames('noise_time', '1', own, 'median_ms')} and "
            f"{frames('noise_time', '5', own, 'median_ms', 2)} for the times at 4 and 2 cm, "
            f"{frames('noise_bytes:count fast', '1', 'none', 'bytes')} for bytes; the "
            "stream's first ones, seed 1. All of this section but the times repeats "
            "exactly.")


def _aims_and_failures(results):
    return [
        "<h2>Noise and surface told apart</h2>",
        paragraph("What the paper could only look at: how well each law, and a filter that "
                  "knows a voxel's neighbours and history (VoxelOutlierRemoval), tells "
                  "noise from surface. A voxel is noise if it holds no point of a "
                  "surface; noise is what is to be found."),
        bullets(aims_in_words(results)),
        tables.summary_table(results).html(),
        note("“0.9” and “a fifth” are the aims above. Best law: of count, quadratic and "
             "linear; of the lidar its own intensity and the count, and the filter on its "
             "intensities. The person's share, and that of the worst frame with 20 of the "
             "person's voxels or more, are of the filter at that threshold. "
             + frames_in_words(results)),
        picture(pictures.precision_over_recall(results),
                "Precision over recall of laws and filter for sensor 1 and all merged",
                "Precision over recall of “this voxel is noise”: the share of noise among "
                "the voxels removed, over the share of the noise that is removed. Towards "
                "the upper right is better."),
        "<h3>Where each fails</h3>",
        bullets(where_each_fails(results)),
    ]


def _comparisons(results):
    return [
        "<h3>What moves</h3>",
        tables.person_table(results).html(),
        "<h3>Against PCL's filters</h3>",
        tables.peers_table(results).html(),
        note("StatisticalOutlierRemoval is judged by the mean distance to its neighbours, "
             "RadiusOutlierRemoval by their number, so that each is at its best threshold; "
             "best F1, and let through and kept where 95 % of the surfaces' voxels stay. "
             "The radius is in voxel edges."),
        tables.times_table(results).html(),
        "<h3>Bytes, where the sensor removes noise</h3>",
        tables.bytes_table(results).html(),
        note("“The truth”: a filter that removes all points that are no surface's, and "
             "nothing else."),
    ]


def _all_figures(results):
    return [
        "<h3>All figures</h3>",
        *details("Each law and filter on each sensor",
                 [tables.methods_table(results).html()]),
        *details("By distance", [
            tables.noise_of_bands_table(results).html(),
            tables.bands_table(results, "Average precision, by the distance of the voxel "
                               "from the sensor. – : no surface or no noise is there.",
                               "average_precision", 3).html(),
            tables.bands_table(results, "Noise let through %, at the threshold that keeps "
                               "95 % of the surfaces' voxels of all distances.",
                               "let_through_percent", 1).html(),
            tables.bands_table(results, "Surfaces' voxels kept %, at that threshold.",
                               "surface_kept_percent", 1).html()]),
        *(block for sensor in METHODS for block in details(
            ("Thresholds, all cameras merged" if sensor == MERGED
             else f"Thresholds, sensor {sensor}"),
            [tables.thresholds_table(results, sensor).html()])),
    ]


def noise_section(results):
    """The section's HTML."""
    return _aims_and_failures(results) + _comparisons(results) + _all_figures(results)

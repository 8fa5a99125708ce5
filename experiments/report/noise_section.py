"""The report's section on noise."""

import noise_tables as tables
import pictures
from noise_results import FILTER, METHODS
from page import details, note, paragraph, picture
from results import MERGED


def _frames_in_words(results):
    """How many frames each part of the section is of."""
    def frames(experiment, sensor, method, quantity, resolution_cm=4):
        return results.value(experiment, sensor, method, resolution_cm, quantity).samples
    own = "VoxelOutlierRemoval on quadratic"
    return (f"Frames: {frames('noise', '1', FILTER, 'average_precision')} of each sensor "
            f"and merged, {frames('noise', '1', FILTER, 'average_precision', 2)} at 2 cm, "
            f"{frames('noise_peers', '1', FILTER, 'average_precision')} for PCL's filters, "
            f"{frames('noise_time', '1', own, 'median_ms')} and "
            f"{frames('noise_time', '5', own, 'median_ms', 2)} for the times at 4 and 2 cm, "
            f"{frames('noise_bytes:count fast', '1', 'none', 'bytes')} for bytes; seed 1, "
            "from the start of the stream. Everything but the times repeats exactly.")


def _summary(results):
    return [
        "<h2>Detection of noise</h2>",
        paragraph("The paper judges its filters by eye. The simulator has the truth: a "
                  "voxel is noise if it holds no point of a surface. This section measures "
                  "how well noise is detected by the three laws with a threshold, by this "
                  "library's VoxelOutlierRemoval (“the filter”), which uses a voxel's "
                  "neighbours and earlier frames, and by PCL's outlier filters. "
                  "experiments/noise/README.md lists where each fails."),
        tables.summary_table(results).html(),
        note("AP: average precision, the area under precision over recall. Let through: "
             "noise that is kept at the threshold that keeps 95 % of the surfaces' voxels. "
             "“0.9” and “a fifth”: whether the filter's AP is 0.9 or more, and whether it "
             "lets through at most a fifth of what the best law does. Best law: of count, "
             "quadratic and linear; of the lidar its own intensity and count. Person: share "
             "of the person's voxels that the filter keeps at that threshold, and in the "
             "worst frame with at least 20 of them; –: the person is not seen. "
             + _frames_in_words(results)),
        picture(pictures.precision_over_recall(results),
                "Precision over recall of laws and filter for sensor 1 and all merged",
                "Precision over recall of the detection of noise: share of noise among the "
                "removed voxels, over the share of the noise that is removed. Higher is "
                "better."),
    ]


def _comparisons(results):
    return [
        "<h3>What moves</h3>",
        tables.person_table(results).html(),
        "<h3>Against PCL's filters</h3>",
        tables.peers_table(results).html(),
        note("StatisticalOutlierRemoval is judged by the mean distance to its neighbours, "
             "RadiusOutlierRemoval by their number, so that each is at its best threshold. "
             "Precision, recall and F1: at the best F1; the others where 95 % of the "
             "surfaces' voxels are kept. The radius is in voxel edges."),
        tables.times_table(results).html(),
        "<h3>Bytes with the filter in the sensor's node</h3>",
        tables.bytes_table(results).html(),
        note("“The truth”: exactly the points that are not of a surface are removed."),
    ]


def _all_values(results):
    return [
        "<h3>All values</h3>",
        *details("Each law and filter on each sensor",
                 [tables.methods_table(results).html()]),
        *details("By distance", [
            tables.noise_of_bands_table(results).html(),
            tables.bands_table(results, "Average precision, by the distance of the voxel "
                               "from the sensor; –: no surface or no noise is there.",
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
    return _summary(results) + _comparisons(results) + _all_values(results)

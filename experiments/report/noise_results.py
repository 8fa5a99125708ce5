"""Methods and aims of the section on noise, and the best of the laws."""

from results import CAMERAS, LIDAR, MERGED

LAWS = ("count", "quadratic", "linear")
FILTER = "filter on quadratic"
FILTER_WITHOUT_HISTORY = "filter on quadratic without history"
FILTER_ON_VOXELS = "filter on voxels"
FILTERS = (FILTER, FILTER_WITHOUT_HISTORY, "filter on linear", "filter on count",
           FILTER_ON_VOXELS)
FILTER_OF_EACH = "filter on quadratic of each sensor"
METHODS = {**{sensor: LAWS + FILTERS for sensor in CAMERAS},
           MERGED: LAWS + (FILTER, FILTER_WITHOUT_HISTORY, "filter on count",
                           FILTER_OF_EACH),
           LIDAR: ("native", "count", "filter on count", FILTER_ON_VOXELS)}
BANDS = ("up to 3 m", "3 to 5 m", "5 to 7 m", "7 to 9 m", "9 m and more")
FILTER_THRESHOLDS = ("0.0", "2.5")

# Aims of the filter: an average precision, and a share of the noise that the best law lets
# through where as many of the surfaces' voxels are kept.
AIM_AVERAGE_PRECISION = 0.9
AIM_LET_THROUGH = 0.2


def laws_of(sensor):
    return ("native", "count") if sensor == LIDAR else LAWS


def best_law(results, sensor, resolution_cm=4):
    """The law of the highest average precision."""
    return max(laws_of(sensor),
               key=lambda law: results.mean("noise", sensor, law, resolution_cm,
                                            "average_precision"))


def least_let_through(results, sensor, resolution_cm=4):
    """Of the laws, the least noise that is let through, in percent, where 95 % of the
    surfaces' voxels are kept."""
    return min(results.mean("noise", sensor, law, resolution_cm,
                            "usual_let_through_percent") for law in laws_of(sensor))

"""The report's section on TemporalVoxelFilter, and its checks."""

from page import Table, mean_of, note, number, paragraph, picture
from results import CAMERAS, LIDAR

HAND = "hand"  # the camera on a hand of a robot
FILTERS = {"none": "no filter", "outliers": "VoxelOutlierRemoval",
           "temporal": "TemporalVoxelFilter", "both": "both"}
# Law, sensor and voxel edge, cm, of each stream.
STREAMS = ([("count", sensor, 4) for sensor in CAMERAS]
           + [("quadratic", sensor, 4) for sensor in CAMERAS]
           + [("count", sensor, 2) for sensor in CAMERAS]
           + [("count", HAND, 4), ("native", LIDAR, 4)])
# In few frames little appears, and its share is left to chance.
LEAST_NEW = 1000
# Heading, quantity and digits.
COLUMNS = (("voxels", "voxels", 0),
           ("bytes, I-frame every 300", "balanced 300 bytes", 0),
           ("of unfiltered %", "balanced 300 of_unfiltered_percent", 1),
           ("bytes, I-frame every 30", "balanced 30 bytes", 0),
           ("of unfiltered %", "balanced 30 of_unfiltered_percent", 1),
           ("bytes of an I-frame", "balanced 30 i_frame_bytes", 0),
           ("of a P-frame", "balanced 30 p_frame_bytes", 0),
           ("bytes, fast, I-frame every 300", "fast 300 bytes", 0),
           ("surfaces %", "surface_percent", 2),
           ("worst frame %", "surface_worst_percent", 2),
           ("new surfaces %", "new_percent", 1),
           ("two frames later %", "new_later_percent", 1),
           ("person %", "person_percent", 1),
           ("worst frame %", "person_worst_percent", 1),
           ("noise %", "noise_percent", 2),
           ("ghosts", "ghosts", 1),
           ("left behind", "left_behind", 1),
           ("intensity error", "intensity_error_ratio", 2),
           ("filter ms", "filter_ms", 2),
           ("decoding ms", "decode_ms", 2))


def _name(law, sensor, resolution_cm):
    camera = {HAND: "camera on a hand", LIDAR: "lidar"}.get(sensor, f"sensor {sensor}")
    return f"{camera}, {law}, {resolution_cm} cm"


def temporal_table(results):
    """All quantities of all streams and filters."""
    table = Table("Streams with and without filters; means of a frame.",
                  ["filter"] + [heading for heading, _, _ in COLUMNS])
    for law, sensor, cm in STREAMS:
        table.add_group(_name(law, sensor, cm))
        for name, words in FILTERS.items():
            table.add_row([words] + [
                mean_of(results.find(f"temporal:{law}", sensor, name, cm, quantity), digits)
                for _, quantity, digits in COLUMNS])
    return table


def _definitions(frames, judged):
    """What the table's columns are."""
    return [
        note(f"{frames} frames from the start of the stream, 20 a second (the lidar 10); "
             f"surfaces, noise, ghosts and intensities: the last {judged}, as the filter "
             "knows nothing at first. VoxelOutlierRemoval at log-odds 0, before "
             "TemporalVoxelFilter(8) where both are used. A voxel is of a surface if it "
             "holds a point of one. Near: within one voxel, one of the 26 neighbours or "
             "the voxel itself. Surfaces, person: share of their voxels in the frame that "
             "are near a shown one, of the person in frames with at least 20 of its "
             "voxels. New surfaces: the same of voxels of a surface with none near in the "
             "five frames before and with at least three neighbours of a surface, in the "
             "first frame and, if a surface is still near, two frames later."),
        note("Noise: share of the shown voxels without a surface near in the last ten "
             "frames. Ghosts: shown voxels in a frame that the sensor sees through in this "
             "frame and the three before: of the simulator's rays without errors, one at "
             "least passes through the voxel's cube, and all that do end more than two "
             "voxel edges, along the ray, behind it. They include noise, and points "
             "that are measured in front of a far or oblique surface. Left behind: ghosts "
             "without a surface near in these four frames, but with one in the 16 before. "
             "Intensity error: rms difference of the shown intensities from the "
             "voxel's mean over all frames, divided by that of the unfiltered ones, of "
             "voxels that 80 % of the frames have; –: there are none. Times: processor "
             "time of one thread, for each frame the shortest of three; decoding is that "
             "of the effort fast, an I-frame every 300.")]


def temporal_section(results, bytes_picture, worst_picture):
    """The section's HTML."""
    def value(quantity, name="temporal"):
        return results.value("temporal:count", "1", name, 4, quantity)
    frames = value("voxels").samples
    judged = value("surface_percent").samples
    return [
        "<h2>Filter over time</h2>",
        paragraph("TemporalVoxelFilter shows the voxels that are likely surfaces over the "
                  "last frames, in place of those that a frame happens to hit. Sensor 1, 4 "
                  f"cm, count, balanced, an I-frame every 300 frames: "
                  f"{number(value('balanced 300 bytes').mean, 0)} bytes a frame instead of "
                  f"{number(value('balanced 300 bytes', 'none').mean, 0)}."),
        temporal_table(results).html(),
        *_definitions(frames, judged),
        picture(bytes_picture, "Bytes of each frame with and without filters",
                "Bytes of each frame of sensor 1, 4 cm, count, balanced, with an I-frame "
                "every 30.", is_narrow=True),
        picture(worst_picture, "Top view of the worst frame, unfiltered and filtered",
                "The frame of sensor 1, 4 cm, count, in which TemporalVoxelFilter shows the "
                "smallest share of the surfaces, from above. Left: as measured. Right: as "
                "shown, with the surfaces' voxels that are not near a shown one, and "
                "ghosts."),
    ]


def check_temporal(check):
    """The filter saves bytes and shows the surfaces; the bounds hold for any sensor."""
    for law, sensor, cm in STREAMS:
        def value(name, quantity, law=law, sensor=sensor, cm=cm):
            return check.mean(f"temporal:{law}", sensor, name, cm, quantity)
        stream = _name(law, sensor, cm)
        for quantity in ("surface_percent", "new_percent", "new_later_percent",
                         "balanced 30 of_unfiltered_percent"):
            check.near(value("none", quantity), 100, 0, quantity, "without filter,", stream)
        for name in ("temporal", "both"):
            check.between(value(name, "surface_percent"), 95, 100, "surfaces,", name, stream)
            if value(name, "new_voxels") >= LEAST_NEW:
                check.between(value(name, "new_percent"), 85, 100, "new surfaces,", name,
                              stream)
            check.between(value(name, "balanced 300 of_unfiltered_percent"), 2, 60,
                          "bytes of unfiltered,", name, stream)
        if law != "native":
            check.that(value("temporal", "noise_percent") < value("none", "noise_percent"),
                       "TemporalVoxelFilter adds noise,", stream)

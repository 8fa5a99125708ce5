"""The report's section on sensors and people that move, and its checks."""

from page import Table, note, number
from results import CODERS

# Voxel edge of each stream, cm.
STREAMS = {"fixed camera": 4, "fixed camera and a person": 4, "camera on a hand": 4,
           "lidar at 1 m/s": 10, "lidar at 10 m/s": 10}
# Bytes against those of I-frames alone, where history does not help, of 20 frames and more.
MOST_BYTES = 1.005


def motion_table(results):
    """Bytes per voxel with P-frames and with I-frames alone."""
    table = Table("Moving sensors and people, means over the frames.",
                  ["coder", "voxels", "bytes per voxel, I-frame every 30",
                   "I-frames alone", "less by P-frames, %"])
    for stream, cm in STREAMS.items():
        table.add_group(f"{stream}, {cm} cm")
        for coder in CODERS:
            subject = (stream, coder, cm)
            both, alone = (results.mean(experiment, *subject, "bytes_per_voxel")
                           for experiment in ("motion", "motion_i_frames"))
            table.add_row([coder, number(results.mean("motion", *subject, "voxels"), 0),
                           number(both, 3), number(alone, 3),
                           number(100 * (1 - both / alone), 1)])
    return table


def motion_section(results):
    """The section's HTML."""
    frames = results.value("motion", "fixed camera", "balanced", 4, "bytes").samples
    return [
        "<h3>Moving sensors and people</h3>",
        motion_table(results).html(),
        note(f"{frames} frames of each, point count as intensity, of the lidar its own. "
             "The fixed cameras have the crop box: sensor 1, and a camera that looks along "
             "the aisle in which the person walks. The camera on the hand of a robot and the "
             "lidar on a mobile robot are not cropped: they see floor and walls, too. "
             "10 m/s is the speed of a car. All voxels are on the world's grid; the pose of "
             "each frame is known.")]


def check_motion(check):
    """More effort takes fewer bytes, and history costs few, whatever moves."""
    frames = min(check.mean("streams_run", "", "all", 0, "frames"), 100)
    for stream, cm in STREAMS.items():
        for experiment in ("motion", "motion_i_frames"):
            sizes = [check.results.value(experiment, stream, coder, cm, "bytes")
                     for coder in ("small", "balanced", "fast", "published")]
            check.that(sizes == sorted(sizes), "more effort takes more bytes:", experiment,
                       stream)
            check.that(all(size.samples == frames for size in sizes), experiment, stream,
                       "is not of all frames")
        for coder in CODERS:
            def ratio(quantity, subject=(stream, coder, cm)):
                return (check.mean("motion", *subject, quantity)
                        / check.mean("motion_i_frames", *subject, quantity))
            check.near(ratio("voxels"), 1, 0, "voxels of I-frames alone,", stream, coder)
            check.between(ratio("bytes"), 0.3, MOST_BYTES, "bytes against I-frames alone,",
                          stream, coder)

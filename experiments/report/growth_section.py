"""The report's section on growth with the points and with finer voxels, and its checks."""

from page import DASH, Table, note, number, picture

CODERS = ("fast", "PCL")
USUAL_EDGE = 4  # cm
# From here on a measurement is longer than what the system takes between two frames, and
# memory is more than the system's error in counting it.
SURE_POINTS = 10_000
MOST_POINTS_WITHOUT_WARNING = 300_000


def numbers_of_points(results):
    return sorted(map(int, results.experiments("growth_points:")))


def edge_points(results):
    """Number of points while the voxel edge changes."""
    return int(results.experiments("growth_edges:")[0])


def edges(results):
    """Voxel edges, cm, from coarse to fine."""
    experiment = f"growth_edges:{edge_points(results)}"
    return sorted({key[3] for key in results.by_key if key[0] == experiment}, reverse=True)


def sizes(results):
    """Experiment, voxel edge and number of points of all sizes, in two groups."""
    points = edge_points(results)
    return ([(f"growth_points:{number}", USUAL_EDGE, number)
             for number in numbers_of_points(results)],
            [(f"growth_edges:{points}", edge, points) for edge in edges(results)])


def _of(results, size, coder, quantity):
    experiment, edge, _ = size
    return results.mean(experiment, "room", coder, edge, quantity)


def encode_ns_a_point(results, size, coder):
    return 1e6 * _of(results, size, coder, "encode_median_ms") / size[2]


def decode_ns_a_voxel(results, size, coder):
    return (1e6 * _of(results, size, coder, "decode_median_ms")
            / _of(results, size, coder, "voxels"))


def growth_curves(results):
    """Title of each column of plots, name and logarithmic places of its axis, and by coder
    the two lines."""
    by_points, by_edge = sizes(results)
    return [(title, axis, [size[place] for size in group],
             {coder: ([encode_ns_a_point(results, size, coder) for size in group],
                      [decode_ns_a_voxel(results, size, coder) for size in group])
              for coder in CODERS})
            for title, axis, place, group in (
                (f"voxels of {USUAL_EDGE} cm", "points of a frame", 2, by_points),
                (f"{edge_points(results):,} points", "voxel edge, cm", 1, by_edge))]


def memory_table(results):
    """Memory of encoder and decoder."""
    header = ["points", "voxels"]
    for coder in CODERS:
        header += [f"{coder}: MB to encode", "bytes a point", "MB to decode",
                   "bytes a voxel"]
    table = Table("Memory, without the cloud.", header)
    for size in sizes(results)[0]:
        row = [f"{size[2]:,}", number(_of(results, size, CODERS[0], "voxels"), 0)]
        for coder in CODERS:
            for call, count in (("encode", size[2]),
                                ("decode", _of(results, size, coder, "voxels"))):
                megabytes = _of(results, size, coder, f"{call}_megabytes")
                row += [number(megabytes, 1),
                        number(1e6 * megabytes / count, 0) if size[2] >= SURE_POINTS
                        else DASH]
        table.add_row(row)
    return table


def growth_section(results, plots):
    """The section's HTML, with the plots of growth_curves()."""
    return [
        "<h2>Growth</h2>",
        picture(plots,
                "Time a point to encode and time a voxel to decode, over the number of "
                "points and over the voxel edge, of effort fast and of PCL's class",
                "Effort fast and PCL's class in voxel-grid mode on the sampled room of "
                "doc/benchmarks.md. Where a line is level, time is proportional to the "
                "points or the voxels."),
        memory_table(results).html(),
        note("Each coder has a process of its own. Time: median of the frames after two "
             "I-frame periods, processor time of one thread. Memory: the most that was "
             "resident during calls of the encoder or of the decoder, with the memory that "
             "they keep between frames. PCL's class keeps no intensity.")]


def check_growth(check):
    """Time grows with the points, not faster."""
    results = check.results
    points = numbers_of_points(results)
    check.that(len(points) >= 3 and points[-1] >= 100 * points[0], "numbers of points:",
               points)
    check.that(len(edges(results)) == 8, "voxel edges:", edges(results))
    for group in sizes(results):
        for size in group:
            subject = (*size[:2], "cm")
            for coder in CODERS:
                check.between(_of(results, size, coder, "voxels"), 1, size[2],
                              "voxels,", coder, *subject)
                for quantity in ("encode_median_ms", "decode_median_ms"):
                    check.that(_of(results, size, coder, quantity) > 0.0, quantity, "of",
                               coder, *subject, "is 0")
            # Where voxels have more points than 8 bits hold, each frame has a warning.
            calls = ("encode", "decode") if size[2] <= MOST_POINTS_WITHOUT_WARNING \
                else ("decode",)
            for call in calls:
                check.that(_of(results, size, "fast", f"{call}_allocations") == 0.0,
                           "a steady stream allocates memory,", call, *subject)
    # The more points a voxel has, the less a point costs; 3: a busy machine, other caches.
    sure = [size for size in sizes(results)[0] if size[2] >= SURE_POINTS]
    for size in sure[1:]:
        check.between(encode_ns_a_point(results, size, "fast"), 0.0,
                      3 * encode_ns_a_point(results, sure[0], "fast"),
                      "encoding time a point, ns,", *size[:2], "cm")

#!/usr/bin/env python3
# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
"""Makes the report of results: make_report.py <folder of results> <file to write> <name
that the folder will have beside the file>."""

import pathlib
import sys

import paper_values
import pictures
import tables
from page import link, note, number, page, paragraph, picture
from results import ReportError, read_results

# Frame 90 of 20 a second, as in sample_pictures.cpp.
SHOWN_SECONDS = 4.5

TITLE = "The paper's experiments on the simulated robot cell"


def introduction(results):
    def frames(experiment):
        return results.value(experiment, "1", "balanced", 4, "bytes").samples
    seconds = results.mean("at_once", "central", "balanced", 4, "seconds")
    return [
        paragraph("The experiments of J. Dybedal, A. Aalerud and G. Hovland, “Embedded "
                  "Processing and Compression of 3D Sensor Data for Large Scale Industrial "
                  "Environments”, Sensors 2019, 19(3), 636, repeated in a simulated robot "
                  "cell (simulator/README.md). “÷ paper” is the measured value divided by "
                  f"the paper's. Frames of each sensor: {frames('compression'):,} in "
                  f"sections 3.1 and 3.2 (the paper: {paper_values.FRAMES:,}), "
                  f"{frames('resolution')} at each of 20 voxel edges; section 3.3 runs for "
                  f"{seconds:.1f} s per coder; pictures show one frame."),
        paragraph("Bytes, voxels, errors and shares repeat exactly. Times, processor and memory "
                  "are those of this machine."),
        note(results.machine),
        tables.summary_table(results).html(),
        note("“published” is the bitstream of the paper's authors, written by this library; "
             "fast, balanced and small are the efforts of this library's own bitstream. "
             "The paper does not say which of its six sensors Tables 2 to 5 are of; the "
             "simulated equipment was placed so that sensor 1 has their number of points "
             "and voxels, so these agree by construction. Times are processor time of one "
             "thread unless stated otherwise."),
    ]


def laws_and_octree(folder):
    return [
        "<h2>2.5 Voxel intensity</h2>",
        picture(pictures.laws_over_depth(folder),
                "Intensity of a point over its depth, for the three laws",
                "Figure 5. Intensity of a point over its depth for the three laws, Kinect "
                "V2 at 4 cm. From the cut-off depth on (the paper: "
                f"{paper_values.CUT_OFF_DEPTH} m), one point fills a voxel's face.",
                is_narrow=True),
        picture(pictures.eight_leaves(folder),
                "Points in the voxels of an octree cell, and the decoded points with counts",
                "Figure 7. An octree cell of 8 cm with eight leaves, of sensor 1. Left: the "
                "points in their voxels. Right: after decoding, one point at the centre of "
                "each occupied voxel, with the number of points as intensity.",
                is_narrow=True),
    ]


def preprocessing(results):
    return ["<h2>3.1 Preprocessing</h2>", tables.table_2(results).html(),
            tables.cropping_table(results).html(),
            note("Crop box 0..10, 0..10, 0.1..4 m: the cell without its floor. Ratio: all "
                 "pixels of the image against the cropped points, 16 bytes each.")]


def compression(results):
    return [
        "<h2>3.2 Compression</h2>",
        tables.table_3_or_4(results, 4).html(), tables.table_3_or_4(results, 2).html(),
        note("Ratio: 16 bytes for each cropped point against the frame's bytes. An I-frame "
             "every 30 frames. The published layout anchors its voxels to PCL's octree box, "
             "so they differ from those of the efforts. The paper's Table 4 is of another "
             "recording than its Table 3."),
        tables.laws_table(results).html(),
        note("Encode: from the sensor's cloud to bytes, moving and cropping included. "
             "Decode: from bytes to voxels."),
        "<h3>All sensors</h3>", tables.all_sensors_table(results).html(),
        "<h3>Depth images</h3>", tables.depth_image_table(results).html(),
        note("PNG: libpng, 16 bits of millimetres, lossless. JPEG: libjpeg-turbo, 8 bits, "
             "in steps of 51 mm up to 13 m, quality 90. The paper names the driver's "
             "default JPEG compression, but the source of that driver, IAI Kinect2 "
             "(kinect2_bridge.cpp), has JPEG (quality 90) for 8-bit images and TIFF or PNG, "
             "both lossless, for 16-bit depth, and the paper's size is near that of PNG. "
             "Error: over the pixels with a return before and after. Wrong: off by more "
             "than 10 cm, lost or made up, of the pixels with a return before or after. "
             "Ratio: against 16 bytes for each cropped point."),
        "<h3>Bits per voxel against voxel edge</h3>",
        picture(pictures.bits_over_resolution(results),
                "Bits per voxel over the voxel edge for the four coders",
                "Bits per voxel, sensor 1, point count as intensity.", is_narrow=True),
    ]


def at_once(results):
    return [
        "<h2>3.3 Frequency and bandwidth</h2>", tables.table_5(results).html(),
        note("The paper compresses on one core of a Jetson TX2 (Arm A57) and decompresses "
             "on a Core i5-2500; its memory is that of the whole ROS node, here it is the "
             "growth of resident memory. Compression, and decompression at 20 Hz: from the "
             "processor time of a frame (section 3.2). Decompression of all sensors: from "
             "the run below, with the sending in it."),
        tables.at_once_table(results).html(),
        note("Latency: from when a frame is due to its voxels. Late: of the frames, those "
             "that take longer than 50 ms. Merging: of the last frames of all streams.")]


def view_link(folder_name, figure, threshold):
    """A link to the viewer with the figure's recording, at the frame that the figure shows."""
    settings = f"threshold={threshold}&noise=colour&time={SHOWN_SECONDS}"
    return link(f"{folder_name}/figure_{figure}.html#{settings}",
                f"Figure {figure} in the viewer: as it moves, with the threshold as a slider")


def denoising(folder, folder_name):
    return [
        "<h2>3.4 Denoising</h2>",
        picture(pictures.before_and_after(folder),
                "Cropped points of sensor 1, and its decoded voxels",
                "Figure 10. Sensor 1: the cropped cloud, and the decoded voxels of 4 cm "
                f"without those that have fewer than {paper_values.FIGURE_10_COUNT} "
                "points. A stronger colour is a higher intensity."),
        view_link(folder_name, 10, paper_values.FIGURE_10_COUNT),
        picture(pictures.top_views(folder),
                "Top views of all seven sensors, raw, as voxels and filtered",
                "Figure 11 (b) to (f). Top view of all seven sensors: cropped points, "
                "decoded voxels of 4 cm, and those that the paper's filter values keep: "
                "a count of 2, a linear and a quadratic intensity of 64 of 255."),
        view_link(folder_name, 11, paper_values.FIGURE_11["quadratic"]),
        note("The paper judged Figure 11 by eye: count leaves noise close to the sensors "
             "and removes many far points, linear removes the noise close to the sensors "
             "and keeps more of the far points, quadratic removes evenly over the distance. "
             "The paper filters the lidar's voxels by the lidar's own intensities, "
             "almost all of which exceed the filter values; the scale is not given. Here "
             "the lidar's voxels are all kept."),
    ]


def noise(results):
    frames = results.value("noise", "1", tables.FILTER, 4, "average_precision").samples
    return [
        "<h2>Detection of noise</h2>",
        paragraph("The paper judges its filters by eye. The simulator has the truth: a "
                  "voxel is noise if it holds no point of a surface. Here is how well noise "
                  "is detected by the three laws with a threshold, by this library's "
                  "VoxelOutlierRemoval (“the filter”), which uses a voxel's neighbours and "
                  "earlier frames, and by PCL's outlier filters. doc/noise.md tells where "
                  "each fails."),
        tables.noise_summary_table(results).html(),
        note("AP: average precision, the area under precision over recall. Let through: "
             "noise that is kept at the threshold that keeps 95 % of the surfaces' voxels. "
             "Person: share of the person's voxels that the filter keeps there, and in the "
             "worst frame with at least 20 of them; –: the person is not seen. "
             f"{frames} frames, seed 1. Everything but the times repeats exactly."),
        picture(pictures.precision_over_recall(results),
                "Precision over recall of laws and filter for sensor 1",
                "Precision over recall of the detection of noise, sensor 1, 4 cm. Higher is "
                "better.", is_narrow=True),
        tables.noise_thresholds_table(results).html(),
        tables.noise_methods_table(results).html(),
        note("StatisticalOutlierRemoval is judged by the mean distance to its neighbours, "
             "RadiusOutlierRemoval by their number within a radius in voxel edges, so that "
             "each is at its best threshold."),
    ]


def lidar_noise(results):
    frames = results.value("lidar_points", "7", tables.POINT_FILTER, tables.LIDAR_CM,
                           "median_ms").samples
    return [
        "<h2>Noise of lidars</h2>",
        paragraph("PointOutlierRemoval (“filter on points”) tells what floats in the air from "
                  "surfaces by the ranges of the rays around each point, at the sensor, before "
                  "points become voxels. Here on the cell's VLP-16 in simulated snow and dust "
                  "(simulator/README.md), beside VoxelOutlierRemoval on voxels of 10 cm, DROR "
                  "and DSOR. Dust is dense, as surfaces are; no count of neighbours finds it."),
        *(table.html() for table in tables.lidar_table(results)),
        note(f"{frames} revolutions from the start of the stream, seed 1. Noise of clear air: "
             "echoes that mix at edges. The threshold of DSOR's authors is for another lidar, "
             "outdoors, and removes all points here. doc/noise.md has recorded scans, too."),
    ]


def temporal_filter(results):
    values = [results.value("temporal", "1", name, 4, "bytes")
              for name in ("temporal", "none")]
    return [
        "<h2>Filter over time</h2>",
        paragraph("TemporalVoxelFilter shows the voxels that are likely surfaces over the "
                  "last frames, in place of those that a frame happens to hit. Sensor 1: "
                  f"{number(values[0].mean, 0)} bytes a frame instead of "
                  f"{number(values[1].mean, 0)}."),
        tables.temporal_table(results).html(),
        note(f"{values[0].samples} frames from the start of the stream; what is shown is "
             "judged from frame 20 on, as the filter knows nothing at first. Surfaces, "
             "person: share of the voxels with one of their points that are within one voxel "
             "of a shown one; of the person in frames with at least 20 of its voxels. Noise: "
             "share of the shown voxels without a surface within one voxel in the last ten "
             "frames. VoxelOutlierRemoval at log-odds 0, before TemporalVoxelFilter(8) where "
             "both are used. Times: processor time; encoding has moving, cropping and the "
             "filters in it."),
    ]


def main():
    folder, output = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    folder_name = sys.argv[3]
    results = read_results(folder)
    body = introduction(results) + laws_and_octree(folder)
    body += preprocessing(results) + compression(results) + at_once(results)
    body += denoising(folder, folder_name) + noise(results)
    body += lidar_noise(results) + temporal_filter(results)
    output.parent.mkdir(parents=True, exist_ok=True)
    output.write_text(page(TITLE, body), encoding="utf-8")


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    try:
        main()
    except (OSError, ReportError) as error:
        sys.exit(f"make_report.py: {error}")

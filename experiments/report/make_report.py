#!/usr/bin/env python3
"""Makes the report of results: make_report.py <folder of results> <file to write>."""

import pathlib
import sys

import pictures
import tables
from noise_section import noise_section
from page import note, page, paragraph, picture
from results import ReportError, read_machine, read_results

TITLE = "The paper's experiments on the simulated robot cell"


def introduction(folder, results):
    def frames(experiment, cm=4):
        return results.figure(experiment, "1", "balanced", cm, "bytes").samples
    clouds = results.mean("at_once_run", "", "balanced", 4, "clouds")
    seconds = results.mean("at_once_run", "", "balanced", 4, "seconds")
    return [
        paragraph("What J. Dybedal, A. Aalerud and G. Hovland, “Embedded Processing and "
                  "Compression of 3D Sensor Data for Large Scale Industrial "
                  "Environments”, Sensors 2019, 19(3), 636, measured in a robot cell, "
                  "measured again in a simulated one (simulator/README.md), "
                  f"with {frames('compression'):,} frames of each sensor in sections 3.1 "
                  f"and 3.2, {frames('resolution')} at each of 20 resolutions; with "
                  f"{clouds:.0f} of each sensor in section 3.3, which are repeated for "
                  f"{seconds:g} s for each coder; with one in the figures; and with as "
                  "many as it says there in the section on noise."),
        paragraph("Bytes, voxels, errors and shares repeat exactly, except in section 3.3, "
                  "where they depend on which frames come in time; times, processor and "
                  "memory are this machine's."),
        note(read_machine(folder)),
        tables.summary_table(results),
        note("“published” is the bitstream of the paper's authors, written by this "
             "library; fast, balanced and small are this library's own bitstream. The "
             "paper's text was not at hand: its figures here are those of its abstract "
             "and those that simulator/README.md quotes, and its Tables 2 to 5 "
             "are here by their subjects, in the sections of those names. Times are "
             "processor time of one thread, unless it says otherwise."),
    ]


def laws_and_octree(folder):
    return [
        "<h2>2.5 Voxel intensity</h2>",
        picture(pictures.laws_over_depth(folder),
                "Intensity of a point over its depth, for the three laws",
                "Figure 5. Intensity of a point over its depth for the three laws, "
                "Kinect V2 at 4 cm. From the cut-off depth on one point fills a voxel's "
                "face.", is_narrow=True),
        picture(pictures.small_octree(folder),
                "An octree of four levels, its points, cells, voxels and intensities",
                "Figure 7. A small octree: one cell of 32 cm of the stream's own octree, "
                "with the corner of a carton on the conveyor, as sensor 1 sees it. Each "
                "level halves the cells that hold a point; the last one's are the "
                "voxels, by number of points and by quadratic intensity on the scale of "
                "255. Below, the same as a tree."),
    ]


def preprocessing(results):
    return ["<h2>3.1 Preprocessing</h2>", tables.cropping_table(results),
            note("Crop box 0..10, 0..10, 0.1..4 m, the whole cell without its floor. "
                 "The cell's equipment was placed so that sensor 1 has the paper's "
                 "number of points; the other sensors came out as they did.")]


def compression(results):
    return [
        "<h2>3.2 Compression</h2>", tables.compression_table(results),
        note("Ratio: 16 bytes for each point in the crop box against the frame's "
             "bytes. Encode: from the sensor's cloud, moving and cropping included, to "
             "bytes; decode: to voxels. Sensors in a gigabit: 10⁹ bits a second over "
             "the stream's, at 20 Hz, without the network's own bytes. An I-frame "
             "every 30 frames. The published layout lays its voxels where PCL's octree "
             "box begins, so that they are others than those of the efforts."),
        "<h3>All sensors</h3>", tables.all_sensors_table(results),
        "<h3>Depth images</h3>", tables.depth_image_table(results),
        note("PNG by libpng, 16 bits of millimetres, which loses nothing; JPEG by "
             "libjpeg-turbo, which has 8 bits: steps of 51 mm up to 13 m. Error: of the "
             "pixels that have a return before and after. Wrong: off by more than 10 cm, "
             "lost or made up, of the pixels with a return before or after. The ratio "
             "is again of the points in the crop box."),
        "<h3>Bits per voxel against resolution</h3>",
        picture(pictures.bits_over_resolution(results),
                "Bits per voxel over the voxel edge for the four coders",
                "Bits per voxel, sensor 1, number of points as intensity.",
                is_narrow=True),
        tables.resolution_table(results),
    ]


def at_once(results):
    return ["<h2>3.3 Frequency and bandwidth</h2>", tables.at_once_table(results),
            note("Each node has a thread of its own and gets its clouds at its sensor's "
                 "rate. Cycle: by the clock, from cloud to bytes, or from bytes to "
                 "voxels, for the central node the mean of its streams. It includes "
                 "waiting for a core where others have it: on a busy machine, or one "
                 "with too few cores for all sensors, frames come late, and are caught "
                 "up with at more than the sensor's rate. Rates are of each second. Memory: growth of what is "
                 "resident, without the clouds."),
            tables.merge_table(results)]


def denoising(folder):
    return [
        "<h2>3.4 Denoising</h2>",
        picture(pictures.denoising(folder),
                "Voxels of sensor 1 before and after denoising",
                "Figure 10. Voxels of sensor 1 by height (dark is low), before and after "
                "those with a quadratic intensity below 64 of 255 are removed. Voxels "
                "without a surface point are noise, and red."),
        picture(pictures.top_views(folder),
                "Top views of all seven sensors, raw, as voxels and filtered",
                "Figure 11. Top view of all seven sensors: raw points, unfiltered voxels "
                "of 4 cm, and voxels with a count of at least 2, a linear intensity of at "
                "least 64 and a quadratic one of at least 64 of 255. The lidar has an "
                "intensity of its own, to which none of the thresholds applies; its "
                "voxels all stay."),
        tables.filtering_table(pictures.filtering_counts(folder)),
    ]


def main():
    folder, output = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    results = read_results(folder)
    body = introduction(folder, results) + laws_and_octree(folder)
    body += preprocessing(results) + compression(results) + at_once(results)
    body += denoising(folder) + noise_section(results)
    output.parent.mkdir(parents=True, exist_ok=True)
    output.write_text(page(TITLE, body), encoding="utf-8")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    try:
        main()
    except (OSError, ReportError) as error:
        sys.exit(f"make_report.py: {error}")

#!/usr/bin/env python3
"""Makes the report of results: make_report.py <folder of results> <file to write>."""

import pathlib
import sys

import tables
from page import note, page, paragraph, text
from results import read_results

TITLE = "The paper's experiments on the simulated robot cell"


def introduction(folder, results):
    machine = (folder / "machine.txt").read_text(encoding="utf-8").strip()
    frames = results.figure("compression", "1", "balanced", 4, "bytes").samples
    return [
        paragraph("What J. Dybedal, A. Aalerud and G. Hovland, “Embedded Processing and "
                  "Compression of 3D Sensor Data for Large Scale Industrial "
                  "Environments”, Sensors 2019, 19(3), 636, measured in a robot cell, "
                  "measured again in a simulated one (experiments/cell/README.md)."),
        paragraph(f"{frames:,} frames of each sensor, seed 1. Bytes, voxels and errors "
                  "repeat exactly; times and memory are this machine's."),
        note(machine),
        note("The paper's text was not at hand. Its figures here are those of its "
             "abstract and those that experiments/cell/README.md quotes; sections are "
             "named as the paper names them. “published” is the bitstream of the "
             "paper's authors, written by this library; fast, balanced and small are "
             "this library's own bitstream. Times are processor time of one thread, "
             "unless it says otherwise."),
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
        "<h3>Bits per voxel against resolution</h3>", tables.resolution_table(results),
    ]


def at_once(results):
    return ["<h2>3.3 Frequency and bandwidth</h2>", tables.at_once_table(results),
            note("Each node has a thread of its own and gets its clouds at its sensor's "
                 "rate. Cycle: by the clock, from cloud to bytes, or from bytes to "
                 "voxels, for the central node the mean of its streams; it includes "
                 "waiting for a core where others have it. Memory: growth of what is "
                 "resident, without the clouds."),
            tables.merge_table(results)]


def main():
    folder, output = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    results = read_results(folder)
    body = introduction(folder, results)
    body += preprocessing(results) + compression(results) + at_once(results)
    output.parent.mkdir(parents=True, exist_ok=True)
    output.write_text(page(TITLE, body), encoding="utf-8")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main()

/** \file
 * \brief What the help and the man page say besides the options.
 */
#pragma once

#include <utility>

namespace pcl_ext {
namespace tools {

constexpr const char* one_line = "compress streams of point clouds";

constexpr const char* program_description =
    "Compresses streams of point clouds into voxels with intensity, and back.";

constexpr const char* man_paragraphs[] = {
    ("A recording is a file x.pcxi, the frames of one stream one after the other, an "
     "MCAP "
     "file, or a rosbag2 folder, both with messages of the type "
     "point_cloud_interfaces/msg/CompressedPointCloud2. Where the name of an output is "
     "one "
     "of them, its end tells which: .pcxi, .mcap, or nothing for a folder. The name - "
     "is "
     "the standard input, and as an output the standard output, which gets .pcxi."),
    ("Each folder of clouds that is named is a stream; the folders in it are not "
     "searched. Files named singly or by a glob are a stream for each folder that they "
     "are in, or one stream if the output is .pcxi. A named pipe is read as a file."),
    ("An output is written beside its name, and gets it when it is complete. SIGINT "
     "and "
     "SIGTERM complete it with what was done until then.")};

constexpr std::pair<int, const char*> exit_statuses[] = {
    {0, "All was done. SIGINT and SIGTERM are the regular end of view."},
    {1,
     "Something was lost, is damaged, or could not be read or written; the rest was "
     "done."},
    {2, "The command line is wrong."},
    {130, "The program was interrupted; what was done until then is complete."}};

constexpr std::pair<const char*, const char*> examples[] = {
    {"pcl_ext encode clouds/ -o x.pcxi --resolution 0.05",
     "Compress the PCD and PLY files of a folder, in the order of their names."},
    {"pcl_ext encode bag.mcap -o small.mcap",
     "Compress the clouds of a bag; all other topics stay as they are."},
    {"pcl_ext decode small.mcap -o clouds --remove-outliers --from 10 --to 20",
     "Write ten seconds of it as PCD files, without noise."},
    {"pcl_ext view small.mcap", "Look at it in a browser, until Ctrl-C."},
    {"pcl_ext encode - -o - < bag.mcap | pcl_ext decode - -o clouds",
     "Compress and decode in a pipe."}};

constexpr const char* footer =
    "Exit status: 0 done; 1 something lost, damaged or failed; 2 wrong command line;\n"
    "130 interrupted, what was done until then is complete.";

} // namespace tools
} // namespace pcl_ext

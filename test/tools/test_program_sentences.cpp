// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "tools/cloud_bags.h"
#include "tools/program.h"

#include <pcl/common/io.h>
#include <pcl/io/pcd_io.h>

#include <gtest/gtest.h>

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace pcl_ext::tools::test {

namespace fs = std::filesystem;

namespace {

const std::string data = PCL_EXT_TEST_DATA;

class ProgramSentences : public ProgramTest {
protected:
  ProgramSentences()
  {
    writeClouds("room", roomClouds(2));
    writeClouds("hall", roomClouds(1));
    auto clouds = roomClouds(1);
    pcl::PointCloud<pcl::PointXYZ> plain;
    pcl::copyPointCloud(clouds[0], plain);
    fs::create_directories(folder / "plain");
    pcl::io::savePCDFileBinary(folder / "plain/0.pcd", plain);
    for (pcl::PointXYZI& point : clouds[0])
      point.getVector3fMap() *= 1000.0f;
    writeClouds("millimetres", clouds);
    writeText("rings/0.pcd",
              "VERSION .7\nFIELDS x y z ring time:gps\nSIZE 4 4 4 2 8\nTYPE F F F U F\n"
              "COUNT 1 1 1 1 1\nWIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA ascii\n"
              "1 0 0 0 .1\n2 0 0 1 .2\n");
    writeText("own/bag_0.own", "");
    writeText("page.html", view_page);
    writeText("x.json", "");
    recordTwoStreams(folder / "two.mcap");
    writeBag(folder / "bag.mcap", 2);
    writeMcap(folder / "imu.mcap", {imuChannel()});
    fs::create_directories(folder / "there");
    fs::create_directories(folder / "there.pcxi");
    expectRun("encode room -o x.mcap");
    for (const std::string bag : {"bags/a.mcap", "more/a.mcap"}) {
      fs::create_directories(fs::path(folder / bag).parent_path());
      fs::copy(folder / "bag.mcap", folder / bag);
    }
  }

  void
  writeText(const std::string& name, const std::string& text)
  {
    fs::create_directories(fs::path(folder / name).parent_path());
    test::writeText(folder / name, text);
  }

  /** \brief Expects of each row one line of error, and that nothing is written. */
  void
  expectRefusals(int status, const std::vector<Refusal>& rows)
  {
    const std::size_t files = filesIn(folder / "");
    ProgramTest::expectRefusals(status, rows);
    EXPECT_EQ(filesIn(folder / ""), files);
  }
};

} // namespace

TEST_F(ProgramSentences, OfOptionsThatEncodeRefuses)
{
  const std::string room = "encode room -o y.pcxi ";
  const std::string refused = "' is no whole number from 2 to 64, or 0";
  std::vector<Refusal> rows = {
      {room + "--unit points", "--unit requires --remove-outliers"},
      {room + "--sensor kinect_v2", "add --law quadratic"},
      {room + "--sensor kinect_v2 -l count", "add --law quadratic"},
      {room + "-l count --intensity-field a", "--intensity-field has no"},
      {room + "-l none --intensity-bits 4", "--intensity-bits has no effect"},
      {room + "-l none --aggregation sum", "--aggregation has no effect"},
      {room + "-l count --format published -e small", "--effort has no"},
      {room + "-l count --format published --colour-bits 5",
       "--colour-bits has no effect"},
      {room + "--no-header --frame-id hall", "--frame-id has no effect"},
      {room + "--frame-id " + std::string(1025, 'f'), "--frame-id is 1025 bytes long"},
      {room + "--sensor kinect_v2 -l linear --coarsen", "--coarsen has no"},
      {room + "--use-coordinate-step --crop 0,0,0,1,1,1",
       "--use-coordinate-step has no effect with --origin, --bounding-box or --crop"},
      {room + "--i-frame-every 0.5ms",
       "--i-frame-every is 0.0005; it must be 0.001 to 86400 s, or 0 for the count "
       "alone"},
      {room + "--i-frame-every 1m", "--i-frame-every: '1m' has none of the units ms"},
      {room + "--i-frame-every soon", "--i-frame-every: 'soon' is no number with a"},
      {room + "-l native --remove-outliers --unit faces",
       "--unit is faces and --law is native, whose"},
      {room + "--unit faces --remove-outliers", "--unit is faces and --law is count"},
      {room + "-l count --aggregation mean",
       "--aggregation is mean; it must be sum or automatic with --law count"},
      {room + "--pose 0,0,0,0,0,0 --pose 1,0,0,0,0,0", "--pose is given twice"},
      {room + "--temporal-filter 8",
       "there is no '8'; as the number of --temporal-filter it is given as "
       "--temporal-filter=8"},
      {room + "--keep-order --law count",
       "--law is count; it must be native or none with --keep-order"},
      {room + "--keep-order --coarsen", "--coarsen has no effect with --keep-order"},
      {room + "--keep-order --use-coordinate-step",
       "uses the step of coordinates where"},
      {room + "--pose /roof=1,2,3,0,0,0",
       "--pose: there is no stream '/roof'; there are /room"},
      {room + "--intensity-field signal", "the clouds have no field 'signal'"},
      {room + "--brightness 1", "--brightness"},
      {room + "-r 0", "--resolution: '0' is no number from 1e-06 to 1e+06;"},
      {room + "--resolution 5cm",
       "'5cm' is no number from 1e-06 to 1e+06: edge of a voxel, metres, such as 0.05"},
      {room + "-e great", "great not in {fast,balanced,small}"},
      {room + "-l quadratic", "--sensor is not set"},
      {room + "--sensor d435", "unknown sensor 'd435'"},
      {room + "--sensor 87,58,848", "--sensor needs 4 numbers"},
      {room + "--sensor 87,58,848,0", "columns and rows are whole"},
      {room + "--crop 0,0,0,1,1", "--crop needs 6 numbers"},
      {room + "--crop wide,0,0,1,1,1", "'wide' is not a number"},
      {room + "--crop 0,0,0,1,0,1", "must be below"},
      {room + "--pose 0,0,nan,0,0,0", "'nan' is not a finite number"},
      {room + "--pose 0,0,0", "--pose has 3 numbers"},
      {room + "--pose 0,0,0,1,1,0,0", "has the length 1.4"},
      {room + "--pose 2,0,0,0,0,2,0,0,0,0,2,0", "not a rotation"},
      {room + "--frames 2:", "the longest stream has 2 clouds"},
      {room + "--frames 2:1", "is no frame"},
      {"encode bag.mcap -o y.mcap --frames 2:",
       "--frames begins at 2, and the longest stream has 2 clouds"},
      {room + "--topics /a", "--topics is for bags"},
      {"encode plain -o y.pcxi --intensity-bits 4",
       "--intensity-bits has no effect on clouds without intensities"},
      {"encode plain room -o y.mcap --intensity-range 100",
       "has no effect on clouds without intensities"}};
  for (const std::string option : {"--rate", "--resolution", "--intensity-range"})
    rows.push_back({room + option + " nan", option + ": 'nan' is no "});
  for (const std::string frames : {"1", "65", "4.5", "-8", "0x8", "many"})
    rows.push_back({room + "--temporal-filter=" + frames,
                    "--temporal-filter: '" + frames + refused});
  expectRefusals(2, rows);
}

TEST_F(ProgramSentences, OfInputsAndOutputsThatEncodeRefuses)
{
  const std::string to = " -o y.pcxi";
  expectRefusals(
      2,
      {{"encode room hall" + to, "takes one stream, and there are 2: /room"},
       {"encode room -o x.las", "is no kind of output"},
       {"encode room", "--output is required"},
       {"encode" + to, "IN is required"},
       // Bags.
       {"encode bag.mcap -o y.mcap --rate 5", "--rate is for files"},
       {"encode bag.mcap -o y.mcap -j 257", "--jobs"},
       {"encode bag.mcap -o - --json", "--json has no effect with -o -"},
       {"encode bag.mcap -o y.mcap --topics /left",
        "no clouds of '/left'; there are /front/points, /rear/points"},
       {"encode bag.mcap" + to, "choose one with --topics"},
       {"encode bag.mcap -o bag.mcap", "is an input"},
       {"encode bag.mcap imu.mcap -o y.mcap", "takes one bag"},
       {"encode bags more -o y.mcap", "'y.mcap' takes one bag"},
       {"encode bags more -o made",
        "'bags/a.mcap' and 'more/a.mcap' would both become 'made/a.mcap': encode them "
        "into two folders"},
       {"encode bags -o bags", "is an input"},
       {"encode bags room -o made", "'room' is not"},
       {"encode bags -o made --rate 5", "--rate is for files"}});
  expectRefusals(
      1,
      {{"encode nowhere" + to, "there is no 'nowhere'"},
       {"encode /dev/zero" + to, "is a device: only files and pipes can be read"},
       {"encode /proc/self/status" + to, "it is empty"},
       {"encode room -o missing/x.pcxi", "missing/x.pcxi"},
       {"encode '" + data + "/../CMakeLists.txt'" + to,
        "CMakeLists.txt' is not a cloud: it is text that"},
       {"encode '" + data + "/../../src'" + to, "no PCD, PLY or .bin file in"},
       {"encode '" + data + "'" + to, "name the folders in it"},
       {"encode own" + to, "and no bag; it has 1 other file (bag_0.own)"},
       {"encode imu.mcap -o y.mcap",
        "has no clouds (sensor_msgs/msg/PointCloud2); its topics are /imu"},
       {"encode x.mcap -o y.mcap", "compressed already"}});
  // Frames without points are written.
  expectFailure("encode room --crop 100,100,100,101,101,101 -o y.pcxi",
                1,
                "/room: no point is inside the box; its first points are between (-1");
}

TEST_F(ProgramSentences, OfOtherCommandsThatAreRefused)
{
  const std::string no_question = "; 500kbit/s or 2Mbit/s is one";
  const std::string text_of_files = ": 'pcl_ext encode' makes a recording of it, ";
  std::vector<Refusal> rows = {
      {"frobnicate", "frobnicate"},
      {"encod x.pcd -o y.pcxi",
       "there is no command 'encod'; there are encode, decode, info"},
      {"decode x.mcap -o y.mcap --ply", "--ply is for a folder of files"},
      {"decode x.mcap -o y.mcap --pcd ascii", "--pcd is for a folder"},
      {"decode x.mcap -o y --unit points", "--unit requires --remove-outliers"},
      {"decode x.mcap -o y --min-intensity nan", "--min-intensity: 'nan' is no number"},
      {"decode x.mcap -o y --remove-outliers --sensor-position 4,1", "sensor-position"},
      {"decode x.mcap -o y --remove-outliers --sensor-position 4,1,2 --unit voxels",
       "--sensor-position has no effect without --unit rays"},
      {"decode x.mcap -o y --sensor-position 4,1,2 --unit rays", "requires"},
      {"decode x.mcap -o /dev/null", "is no file or folder"},
      {"decode x.mcap -o there --bag", "exists: name another"},
      {"cut two.mcap -o y.pcxi", "choose one with --streams"},
      {"cut two.mcap -o y.mcap --from 9", "takes 1.950 s"},
      {"cut two.mcap -o y.mcap --from 2 --to 1", "--from must be less than --to"},
      {"cut two.mcap -o y.mcap --streams /a", "there is no '/a'"},
      {"cut two.mcap -o two.mcap", "is an input"},
      {"merge x.mcap -o y.pcxi --prefix a", "--prefix has no effect"},
      {"merge x.mcap x.mcap -o y.mcap --prefix a", "--prefix needs"},
      {"demo --sensor kinect_v1 -n 1", "add --law quadratic"},
      {"advise", "name clouds or a bag, or --cell"},
      {"advise room --cell", "--cell is an input itself"},
      {"advise room --format=published --", "not expected: --format=published; see"},
      {"advise room --law linear", "--sensor is not set"},
      {"benchmark room --cell", "--cell is an input itself"},
      {"benchmark --rate 5", "--rate is for inputs"},
      {"benchmark room -n 0", "--frames"},
      {"benchmark room --json x.json", "'x.json' exists"},
      {"benchmark room --json no/x.json", "there is no folder for it"},
      {"benchmark room --json .", "it is a folder"},
      {"benchmark room --overwrite", "is for the file of --json: add it"},
      {"receive --map-full-intensity 3 -o z.mcap", "add --map"}};
  std::vector<Refusal> rows_of_inputs = {
      {"info /dev/zero", "is a device: only files and pipes can be read"},
      {"info room/000.pcd", "a PCD file" + text_of_files},
      {"view room/000.pcd --page page.html", "a PCD file" + text_of_files},
      {"info room", "'pcl_ext encode' makes a recording"},
      {"info bag.mcap", "'pcl_ext encode' compresses"},
      {"info - < room/000.pcd", "pcl_ext info: 'standard input' is not a recording: "},
      {"verify - < /dev/zero", "'standard input' is a device"},
      {"cut none.mcap -o y.mcap", "cannot open 'none.mcap'"},
      {"advise none", "there is no 'none'"},
      {"benchmark none", "there is no 'none'"}};
  for (const std::string command :
       {"info x.mcap", "info --json x.mcap", "verify x.mcap", "--help"})
    rows_of_inputs.push_back(
        {command + " > /dev/full", "cannot write to the standard output"});
  for (const std::string command : {"encode room", "cut x.mcap", "merge x.mcap"}) {
    for (const std::string there : {"there", "there.pcxi"})
      rows.push_back({command + " -o " + there, "exists: name another"});
    for (const std::string device : {"/dev/null", "/dev/stdout", "/dev/full"})
      rows.push_back({command + " -o " + device, "is no file or folder"});
  }
  for (const auto& [rate, fault] : std::vector<std::pair<std::string, std::string>>{
           {"2", "has no unit"},
           {"2MB/s", "has none of the units bit/s, kbit/s, Mbit/s, Gbit/s"},
           {"0kbit/s", "is not above 0"},
           {"-1Mbit/s", "is not above 0"},
           {"nankbit/s", "is no number with a unit"},
           {"1e999bit/s", "is no number with a unit"},
           {"fast", "is no number with a unit"}})
    rows.push_back({"advise room --max-rate=" + rate,
                    "--max-rate: '" + rate + "' " + fault + no_question});
  expectRefusals(2, rows);
  expectRefusals(1, rows_of_inputs);
}

TEST_F(ProgramSentences, OfCommandsThatSucceed)
{
  const std::string few = "by which the noise of a depth camera is found";
  const std::string images = "'" + data + "'/clouds/image_2x2";
  // What is encoded, and a part of the output and of the remarks.
  const std::vector<std::pair<std::string, std::string>> rows = {
      {"encode room -o a.pcxi --intensity-range 10",
       "use a larger --intensity-range or more --intensity-bits"},
      {"encode room -o b.pcxi -r 0.05 --law count --remove-outliers",
       " voxels removed as outliers"},
      {"encode room -o c.pcxi -r 0.05 --remove-outliers --law none",
       "a depth camera's noise is found with --law count or quadratic; for a lidar, "
       "points are judged where its clouds are in its own coordinates"},
      {"encode millimetres -o d.pcxi",
       "if that is in millimetres, --resolution 10 makes voxels"},
      {"advise millimetres -q",
       "\nIts points are metres apart: if they are in millimetres, so are the "
       "edges.\n"},
      {"encode rings -o e.pcxi --fields ring",
       "fields that are left out: time:gps; --fields keeps fields"},
      {"encode room -o native.mcap -r 0.1", "native.mcap: 2 frames"},
      {"decode native.mcap -o native --remove-outliers", few},
      {"encode room -o none.pcxi -r 0.1 -l none", "none.pcxi: 2 frames"},
      {"decode none.pcxi -o none --remove-outliers", few},
      {"encode room -o f.pcxi -j 2",
       "pcl_ext encode: --jobs 2 is more than there are streams: parts of one are "
       "encoded side by side only if it is in an MCAP file that is complete\n"},
      {"encode " + images + ".pcd " + images + "_moved.pcd -o g.pcxi",
       "image_2x2: the files have different viewpoints"},
      {"encode --colour-bits=8 '" + data + "/clouds/coloured.pcd' -o coloured.pcxi",
       "coloured.pcxi: 1 frame"},
      {"info coloured.pcxi", "colours 8 bits"},
      {"decode --ply coloured.pcxi -o coloured", "1 frame"}};
  for (const auto& [arguments, part] : rows) {
    const ProgramRun result = run(arguments);
    EXPECT_EQ(result.status, 0) << arguments << result.errors;
    EXPECT_TRUE(hasPart(result.output + result.errors, part)) << arguments;
  }
  // Without a reason for a remark there is none.
  expectRun("encode plain -o h.pcxi");
  expectRun("encode room -o i.pcxi -r 0.05 --law count --remove-outliers --quiet");
  const ProgramRun nothing = run("");
  EXPECT_EQ(nothing.status, 2);
  EXPECT_TRUE(hasPart(nothing.output + nothing.errors, "Usage: pcl_ext"));
}

TEST_F(ProgramSentences, OfPointsFarAwayDoNotAskForMillimetres)
{
  // A map of 2 km, and a room with one point that is an error.
  const std::string header =
      "FIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nWIDTH 400\nDATA ascii\n";
  std::string map = header;
  std::string room = header + "4000 2 1\n";
  for (int i = 0; i < 400; ++i) {
    map += std::to_string(512000 + 5 * i) + ' ' + std::to_string(5400000 + i % 20) +
           " 300\n";
    room += i == 0 ? "" : std::to_string(0.1 * i) + " 2 1\n";
  }
  writeText("map.pcd", map);
  writeText("error.pcd", room);
  expectRun("encode map.pcd -o map.mcap");
  expectRun("encode error.pcd -o error.mcap");
}

} // namespace pcl_ext::tools::test

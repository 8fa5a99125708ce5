/** \file
 * \brief Wrong parameters end a node with one line and exit code 1.
 */
#include "stream_scenario.h"

#include <algorithm>
#include <memory>
#include <utility>

namespace pcl_ext_ros1 {
namespace test {

namespace {

/** \brief Parameters and a text that the line must have. Here are one of each type and those
 * of the nodes alone; test/nodes/test_encoding_parameters.cpp and test_node_parameters.cpp
 * have all ranges. */
struct Refusal {
  Parameters parameters;
  std::string message;
};

XmlRpc::XmlRpcValue
withoutTopic()
{
  XmlRpc::XmlRpcValue entry;
  entry["min_intensity"] = 2;
  return entry;
}

/** \brief ~streams with one entry. */
Parameters
streamWith(const std::string& name, const XmlRpc::XmlRpcValue& value)
{
  return {{"streams", listOf({streamEntry("/a", name, value)})}};
}

const std::vector<Refusal> refused_by_compressor{
    {{{"resolution", 0.0}}, "~resolution is 0; it must be"},
    {{{"resolution", "fine"}}, "~resolution is 'fine'; it must be"},
    {{{"reslution", 0.04}}, "Unknown parameter ~reslution"},
    {{{"i_frame_rate", 2.5}}, "~i_frame_rate is 2.5; it must be"},
    {{{"effort", "slow"}}, "~effort is 'slow'; it must be"},
    {{{"effort", 2}}, "~effort is 2; it must be"},
    {{{"intensity", "quadratic"}},
     "Parameter ~sensor is not set; it must be set, by name or by numbers, for "
     "intensity: quadratic"},
    {{{"sensor", "kinect_v2"}, {"sensor_rows", 480}}, "~sensor is 'kinect_v2'"},
    {{{"global_frame", ""}}, "~global_frame is ''; it must be"},
    {{{"crop_box", "all"}}, "~crop_box is 'all'; it must be"},
    {{{"crop_box", listOf({0, 0, 0, 1, 1, "far"})}},
     "~crop_box is [0, 0, 0, 1, 1, 'far']; it must be a list of 6 finite numbers, or "
     "[]"},
    {{{"remove_outliers", true}, {"resolution", 0.5}},
     "Parameter ~resolution is 0.5; it must be a number from 0.001 to 0.2 for"},
    {{{"remove_outliers", 1}}, "~remove_outliers is 1; it must be true or false"},
    {{{"min_log_odds", 1e39}}, "~min_log_odds is 1e+39; it must be"},
    {{{"tf_timeout", -0.1}}, "~tf_timeout is -0.1; it must be"},
    {{{"queue_size", 0}}, "~queue_size is 0; it must be"},
    {{{"statistics", "yes"}}, "~statistics is 'yes'; it must be true or false"},
    {{{"format", "published"}, {"intensity_bits", 4}},
     "Parameter ~intensity_bits is 4; it must be"}};

const std::vector<Refusal> refused_by_decompressor{
    {{{"view_port", -1}}, "~view_port is -1; it must be"},
    {{{"streams", "/a"}}, "~streams is '/a'; it must be a list"},
    {{{"streams", listOf({})}}, "~streams"},
    {{{"streams", listOf({5})}}, "~streams is 5 in one entry"},
    {{{"streams", listOf({"/a", "/a"})}}, "~streams"},
    {{{"streams", listOf({"no name"})}}, "no name"},
    {streamWith("topic", ""), "each topic is a text that is not empty"},
    {{{"streams", listOf({withoutTopic()})}}, "or of maps with a topic"},
    {streamWith("colour", "red"), "not colour"},
    {streamWith("min_intensity", "many"), "each min_intensity is a finite number"},
    {streamWith("sensor_frame", 7), "each sensor_frame is a text"},
    {streamWith("remove_outliers", "yes"),
     "in one entry; it must be a list in which each remove_outliers is true or false"},
    {streamWith("density_unit", "dots"),
     "each density_unit is one of: automatic, faces, points, voxels, rays"},
    {{{"streams", listOf({"/a"})}, {"min_intensity_of/a", "many"}},
     "~min_intensity_of/a is 'many'; it must be"},
    {{{"min_log_odd", 1}}, "Unknown parameter ~min_log_odd; known are: "},
    {{{"min_intensity_of", 2}}, "Unknown parameter ~min_intensity_of"},
    {{{"merge_rate", -1}}, "~merge_rate is -1; it must be"},
    {{{"resolution", 0}}, "~resolution is 0; it must be"},
    {{{"map_path", "no_such_folder/map.ot"}}, "~map_path is 'no_such_folder/map.ot'"},
    {{{"map_path", "/"}}, "~map_path is '/'; it must be"},
    {{{"tf_timeout", 11}}, "~tf_timeout is 11; it must be"},
    {{{"global_frame", ""}}, "~global_frame is ''; it must be"}};

const std::vector<Refusal> refused_by_cell{
    {{{"sensors", listOf({7})}}, "~sensors is [7]; it must be"},
    {{{"sensors", listOf({})}}, "~sensors is an empty list; it must be"},
    {{{"rate", 0}}, "~rate is 0; it must be"},
    {{{"global_frame", ""}}, "~global_frame is ''; it must be"},
    {{{"sensor", 1}}, "Unknown parameter ~sensor;"}};

/** \brief Expects exit code 1 and one line with a text. */
void
expectRefusal(NodeProcess& node, const std::string& message)
{
  SCOPED_TRACE(message);
  EXPECT_EQ(node.waitForExit(), 1);
  const std::string output = node.output();
  EXPECT_NE(output.find(message), std::string::npos) << output;
  EXPECT_EQ(std::count(output.begin(), output.end(), '\n'), 1) << output;
}

/** \brief Starts a node with each set of parameters, several at the same time. */
void
expectRefusals(const std::string& program, const std::vector<Refusal>& refusals)
{
  constexpr std::size_t at_once = 6;
  for (std::size_t begin = 0; begin < refusals.size(); begin += at_once) {
    const std::size_t end = std::min(begin + at_once, refusals.size());
    std::vector<std::unique_ptr<NodeProcess>> nodes;
    for (std::size_t i = begin; i < end; ++i)
      nodes.push_back(std::make_unique<NodeProcess>(program,
                                                    "/wrong_parameters/" + program +
                                                        "_" + std::to_string(i),
                                                    refusals[i].parameters));
    for (std::size_t i = begin; i < end; ++i) {
      expectRefusal(*nodes[i - begin], refusals[i].message);
      nodes[i - begin]->expectOutput("FATAL");
    }
  }
}

TEST(WrongParameters, EndTheCompressor)
{
  expectRefusals("intensity_compressor", refused_by_compressor);
}

TEST(WrongParameters, EndTheDecompressor)
{
  expectRefusals("intensity_decompressor", refused_by_decompressor);
}

TEST(WrongParameters, EndTheCell) { expectRefusals("simulated_cell", refused_by_cell); }

TEST(WrongParameters, OnTheCommandLineEndTheNodes)
{
  NodeProcess compressor("intensity_compressor",
                         "/wrong_parameters/compressor_on_line",
                         {},
                         {"_resolution:=-1"});
  NodeProcess decompressor("intensity_decompressor",
                           "/wrong_parameters/decompressor_on_line",
                           {},
                           {"_merge_rate:=fast"});
  expectRefusal(compressor, "~resolution is -1; it must be");
  expectRefusal(decompressor, "~merge_rate is 'fast'; it must be");
}

TEST(WrongParameters, NamesThatAreInvalidInRosEndTheNodes)
{
  for (const char* const program :
       {"intensity_compressor", "intensity_decompressor", "simulated_cell"}) {
    NodeProcess node(program,
                     std::string("/wrong_parameters/remapped_") + program,
                     {},
                     {"input:=no name"});
    expectRefusal(node, "no name");
  }
}

class RightParameters : public StreamScenario {};

TEST_F(RightParameters, AllAreAccepted)
{
  startBoth({{"resolution", 1},
             {"intensity", "count"},
             {"intensity_field", "intensity"},
             {"sensor", "azure_kinect_nfov"},
             {"effort", "small"},
             {"format", "version1"},
             {"i_frame_rate", 0},
             {"aggregation", "sum"},
             {"intensity_bits", 12},
             {"intensity_range", 4095},
             {"intensity_curve", "linear"},
             {"colour_bits", 4},
             {"keep_point_counts", false},
             {"coarsen_wide_clouds", true},
             {"threads", 2},
             {"remove_outliers", false},
             {"min_log_odds", 1},
             {"temporal_filter", 8},
             {"global_frame", "world"},
             {"queue_size", 7},
             {"statistics", true}},
            {{"global_frame", "world"},
             {"min_intensity", 0},
             {"remove_outliers", false},
             {"min_log_odds", 1},
             {"density_unit", "voxels"},
             {"resolution", 1},
             {"merge_rate", 0},
             {"max_merge_age", 2},
             {"threads", 2},
             {"max_waiting_frames", 3},
             {"map_path", ""},
             {"map_rate", 2},
             {"map_full_intensity", 1},
             {"tf_timeout", 1}});
  pcl_ext::nodes::SensorNodeSettings settings = compressorSettings();
  settings.compression.resolution = 1.0;
  settings.compression.intensity_bits = 12;
  settings.compression.intensity_range = 4095.0f;
  settings.compression.temporal_filter = 8;
  expectVoxels(cloud(0), DirectStream(settings).voxelsOf(cloud(0), pose));
  compressor->expectOutput("bytes per voxel"); // of ~statistics
}

} // namespace

} // namespace test
} // namespace pcl_ext_ros1

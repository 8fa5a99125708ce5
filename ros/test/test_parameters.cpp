/** \file
 * \brief Parameters that a node cannot work with stop it with one line and exit code 1.
 */
#include "stream_scenario.h"

#include <algorithm>
#include <memory>
#include <utility>

namespace pcl_ext_ros {
namespace test {

namespace {

/** \brief Parameters and what the line must say of them. */
struct Refusal {
  Parameters parameters;
  std::string says;
};

XmlRpc::XmlRpcValue
entry(const std::string& key, const XmlRpc::XmlRpcValue& value)
{
  XmlRpc::XmlRpcValue map;
  map[key] = value;
  return map;
}

XmlRpc::XmlRpcValue
streamWith(const std::string& key, const XmlRpc::XmlRpcValue& value)
{
  XmlRpc::XmlRpcValue map = entry("topic", "/a");
  map[key] = value;
  return listOf({map});
}

const std::vector<Refusal> refused_by_compressor{
    {{{"resolution", 0.0}}, "~resolution is 0; it must be"},
    {{{"resolution", -1}}, "~resolution is -1; it must be"},
    {{{"resolution", 1e7}}, "~resolution is 1e+07; it must be"},
    {{{"resolution", "fine"}}, "~resolution is 'fine'; it must be"},
    {{{"reslution", 0.04}}, "~reslution"},
    {{{"i_frame_rate", -1}}, "~i_frame_rate is -1; it must be"},
    {{{"i_frame_rate", 2.5}}, "~i_frame_rate is 2.5; it must be"},
    {{{"effort", "slow"}}, "~effort is 'slow'; it must be"},
    {{{"effort", 2}}, "~effort is 2; it must be"},
    {{{"format", "draco"}}, "~format is 'draco'; it must be"},
    {{{"aggregation", "max"}}, "~aggregation is 'max'; it must be"},
    {{{"intensity", "reflectance"}}, "~intensity is 'reflectance'; it must be"},
    {{{"intensity_curve", "log"}}, "~intensity_curve is 'log'; it must be"},
    {{{"intensity_bits", 17}}, "~intensity_bits is 17; it must be"},
    {{{"intensity_range", -1.0}}, "~intensity_range is -1; it must be"},
    {{{"intensity_field", ""}}, "~intensity_field is ''; it must be"},
    {{{"intensity", "quadratic"}}, "~sensor"},
    {{{"intensity", "linear"}, {"sensor", "kinect_v9"}}, "~sensor is 'kinect_v9'"},
    {{{"intensity", "linear"}, {"sensor_columns", 640}}, "~sensor"},
    {{{"sensor", "kinect_v2"}, {"sensor_rows", 480}}, "~sensor is 'kinect_v2'"},
    {{{"sensor_fov_x_deg", 180}}, "~sensor_fov_x_deg is 180; it must be"},
    {{{"sensor_columns", 0}}, "~sensor_columns is 0; it must be"},
    {{{"global_frame", ""}}, "~global_frame is ''; it must be"},
    {{{"global_frame", 5}}, "~global_frame is 5; it must be"},
    {{{"crop_box", "all"}}, "~crop_box is 'all'; it must be"},
    {{{"crop_box", listOf({0, 0, 0, 1, 1})}}, "~crop_box is [0, 0, 0, 1, 1]"},
    {{{"crop_box", listOf({0, 0, 0, 1, 1, 0})}}, "~crop_box is [0, 0, 0, 1, 1, 0]"},
    {{{"crop_box", listOf({0, 0, 0, 1, 1, "far"})}}, "~crop_box is"},
    {{{"remove_outliers", 1}}, "~remove_outliers is 1; it must be true or false"},
    {{{"min_log_odds", "low"}}, "~min_log_odds is 'low'; it must be"},
    {{{"min_log_odds", 1e39}}, "~min_log_odds is 1e+39; it must be"},
    {{{"tf_timeout", -0.1}}, "~tf_timeout is -0.1; it must be"},
    {{{"queue_size", 0}}, "~queue_size is 0; it must be"},
    {{{"statistics", "yes"}}, "~statistics is 'yes'; it must be true or false"},
    {{{"format", "published"}, {"intensity_bits", 4}}, "intensity_bits"},
    {{{"format", "published"}, {"intensity_curve", "companded"}}, "curve"}};

const std::vector<Refusal> refused_by_decompressor{
    {{{"streams", "/a"}}, "~streams is '/a'; it must be a list"},
    {{{"streams", listOf({})}}, "~streams"},
    {{{"streams", listOf({""})}}, "~streams"},
    {{{"streams", listOf({5})}}, "~streams is 5 in one place"},
    {{{"streams", listOf({"/a", "/a"})}}, "~streams"},
    {{{"streams", listOf({"no name"})}}, "no name"},
    {{{"streams", listOf({entry("min_intensity", 2)})}}, "~streams"},
    {{{"streams", streamWith("colour", "red")}}, "colour"},
    {{{"streams", streamWith("min_intensity", "many")}}, "min_intensit"},
    {{{"streams", streamWith("sensor_frame", 7)}}, "sensor_frame"},
    {{{"streams", streamWith("remove_outliers", "yes")}},
     "in one place; it must be a list whose remove_outliers are true or false"},
    {{{"streams", streamWith("min_log_odds", -1e39)}},
     "it must be a list whose min_log_odds are finite numbers"},
    {{{"remove_outliers", "yes"}},
     "~remove_outliers is 'yes'; it must be true or false"},
    {{{"min_log_odds", true}}, "~min_log_odds is 1; it must be"},
    {{{"min_log_odds", -1e39}}, "~min_log_odds is -1e+39; it must be"},
    {{{"min_log_odd", 1}}, "~min_log_odd is none of this node's"},
    {{{"min_intensity", "many"}}, "~min_intensity is 'many'; it must be"},
    {{{"min_intensities", 2}}, "~min_intensities"},
    {{{"merge_rate", -1}}, "~merge_rate is -1; it must be"},
    {{{"resolution", 0}}, "~resolution is 0; it must be"},
    {{{"threads", 1025}}, "~threads is 1025; it must be"},
    {{{"max_waiting_frames", 0}}, "~max_waiting_frames is 0; it must be"},
    {{{"max_merge_age", 0}}, "~max_merge_age is 0; it must be"},
    {{{"map_path", "no_such_folder/map.ot"}}, "~map_path is 'no_such_folder/map.ot'"},
    {{{"map_path", "/"}}, "~map_path is '/'; it must be"},
    {{{"map_path", 3}}, "~map_path is 3; it must be"},
    {{{"map_rate", 0}}, "~map_rate is 0; it must be"},
    {{{"map_full_intensity", 0}}, "~map_full_intensity is 0; it must be"},
    {{{"tf_timeout", 11}}, "~tf_timeout is 11; it must be"},
    {{{"global_frame", ""}}, "~global_frame is ''; it must be"}};

const std::vector<Refusal> refused_by_cell{
    {{{"sensors", listOf({7})}}, "~sensors is 7 in one place; it must be"},
    {{{"sensors", listOf({})}}, "~sensors is an empty list; it must be"},
    {{{"sensors", 1}}, "~sensors is 1; it must be"},
    {{{"rate", 0}}, "~rate is 0; it must be"},
    {{{"seed", -1}}, "~seed is -1; it must be"},
    {{{"frames", -1}}, "~frames is -1; it must be"},
    {{{"captured_frames", 301}}, "~captured_frames is 301; it must be"},
    {{{"wait_for_subscribers", "maybe"}}, "~wait_for_subscribers is 'maybe'; it must"},
    {{{"global_frame", ""}}, "~global_frame is ''; it must be"},
    {{{"sensor", 1}}, "~sensor"}};

/** \brief Expects one line, with all that somebody needs to mend the mistake. */
void
expectRefusal(NodeProcess& node, const std::string& says)
{
  SCOPED_TRACE(says);
  EXPECT_EQ(node.waitForExit(), 1);
  const std::string output = node.output();
  EXPECT_NE(output.find(says), std::string::npos) << output;
  EXPECT_NE(output.find("FATAL"), std::string::npos) << output;
  EXPECT_EQ(std::count(output.begin(), output.end(), '\n'), 1) << output;
}

class WrongParameters : public ::testing::Test {
protected:
  /** \brief Starts a node with each set of parameters, some at once. */
  static void
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
      for (std::size_t i = begin; i < end; ++i)
        expectRefusal(*nodes[i - begin], refusals[i].says);
    }
  }
};

TEST_F(WrongParameters, StopTheCompressor)
{
  expectRefusals("intensity_compressor", refused_by_compressor);
}

TEST_F(WrongParameters, StopTheDecompressor)
{
  expectRefusals("intensity_decompressor", refused_by_decompressor);
}

TEST_F(WrongParameters, StopTheCell)
{
  expectRefusals("simulated_cell", refused_by_cell);
}

TEST_F(WrongParameters, OfOneStreamStopTheDecompressor)
{
  const std::vector<Refusal> refusals{
      {{{"min_intensity_of/a", "many"}}, "~min_intensity_of/a is 'many'; it must be"},
      {{{"remove_outliers_of/a", 0}},
       "~remove_outliers_of/a is 0; it must be true or false"},
      {{{"min_log_odds_of/a", "2"}}, "~min_log_odds_of/a is '2'; it must be"}};
  for (std::size_t i = 0; i < refusals.size(); ++i) {
    NodeProcess node("intensity_decompressor",
                     "/wrong_parameters/of_one_stream_" + std::to_string(i),
                     Parameters{{"streams", listOf({"/a"})}} + refusals[i].parameters);
    expectRefusal(node, refusals[i].says);
  }
}

TEST_F(WrongParameters, OnTheCommandLineStopTheNodes)
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

TEST_F(WrongParameters, NamesThatRosDoesNotTakeStopTheNodes)
{
  for (const char* const program :
       {"intensity_compressor", "intensity_decompressor", "simulated_cell"}) {
    NodeProcess node(program,
                     std::string("/wrong_parameters/remapped_") + program,
                     {},
                     {"input:=no name"});
    EXPECT_EQ(node.waitForExit(), 1) << program;
    const std::string output = node.output();
    EXPECT_NE(output.find("no name"), std::string::npos) << output;
    EXPECT_EQ(std::count(output.begin(), output.end(), '\n'), 1) << output;
  }
}

class RightParameters : public StreamScenario {};

TEST_F(RightParameters, AllThatTheReadmeNamesAreTaken)
{
  transforms.set(sensor_frame, pose);
  startCompressor(compressorParameters() + Parameters{{"resolution", 1},
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
                                                      {"remove_outliers", false},
                                                      {"min_log_odds", 1},
                                                      {"global_frame", "world"},
                                                      {"queue_size", 7},
                                                      {"statistics", true}});
  startDecompressor(Parameters{{"global_frame", "world"},
                               {"min_intensity", 0},
                               {"remove_outliers", false},
                               {"min_log_odds", 1},
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
  DirectStream direct(settings);
  expectVoxels(cloud(0), direct.voxelsOf(cloud(0), pose));
  // The line of ~statistics.
  EXPECT_TRUE(waitFor([&] {
    return compressor->output().find("bytes per voxel") != std::string::npos;
  })) << compressor->output();
}

} // namespace

} // namespace test
} // namespace pcl_ext_ros

/** \file
 * \brief Each launch file starts, gives voxels, and ends with all of its processes.
 * with_master.py reports processes that are left.
 */
#include "node_process.h"
#include "recorder.h"

#include <gtest/gtest.h>

#include <ros/master.h>
#include <ros/param.h>
#include <sensor_msgs/PointCloud2.h>

#include <algorithm>
#include <filesystem>
#include <memory>

namespace pcl_ext_ros1 {
namespace test {

namespace {

using Voxels = Recorder<sensor_msgs::PointCloud2>;

class LaunchFiles : public ::testing::Test {
protected:
  ~LaunchFiles() override
  {
    roslaunch.reset();
    ros::param::del("/use_sim_time"); // set by replay.launch
  }

  void
  launch(const std::string& file, const std::vector<std::string>& arguments)
  {
    std::vector<std::string> command{
        "roslaunch", "--skip-log-check", "pcl_ext_ros1", file};
    command.insert(command.end(), arguments.begin(), arguments.end());
    roslaunch = std::make_unique<ChildProcess>(command);
  }

  /** \brief Waits for that many clouds with points. */
  void
  expectVoxels(const Voxels& voxels, std::size_t count = 3)
  {
    EXPECT_TRUE(waitFor([&] {
      const auto all = voxels.messages();
      return static_cast<std::size_t>(
                 std::count_if(all.begin(), all.end(), [](const auto& cloud) {
                   return cloud->width > 100 && cloud->header.frame_id == "world";
                 })) >= count;
    })) << voxels.topic()
        << '\n'
        << roslaunch->output();
  }

  /** \brief Ends roslaunch as Ctrl-C does. */
  void
  expectCleanEnd()
  {
    EXPECT_TRUE(roslaunch->isRunning());
    EXPECT_EQ(roslaunch->interrupt(), 0) << roslaunch->output();
    // A node that is killed stays registered.
    std::vector<std::string> names;
    ASSERT_TRUE(ros::master::getNodes(names));
    for (const std::string& name : names)
      EXPECT_TRUE(name.find("compressor") == std::string::npos &&
                  name.find("simulated") == std::string::npos)
          << name;
    EXPECT_EQ(roslaunch->output().find("escalating"), std::string::npos)
        << roslaunch->output();
  }

  /** \brief Records topics of one_sensor.launch for more than a second.
   * \return the file
   */
  std::string
  record(const std::string& name, const std::vector<std::string>& topics)
  {
    const std::string bag = temporaryFolder() + "/" + name + ".bag";
    std::vector<std::string> command{"rosbag", "record", "-O", bag};
    command.insert(command.end(), topics.begin(), topics.end());
    ChildProcess recording(command);
    recording.expectOutput("Subscribing to " + topics.front());
    const Voxels voxels("/kinect_1/points/pcl_ext/voxels");
    launch("one_sensor.launch", {"simulated:=true"});
    expectVoxels(voxels, 25); // 20 a second
    EXPECT_EQ(recording.interrupt(), 0) << recording.output();
    expectCleanEnd();
    return bag;
  }

  std::unique_ptr<ChildProcess> roslaunch;
};

TEST_F(LaunchFiles, OneSensor)
{
  const Voxels voxels("/kinect_1/points/pcl_ext/voxels");
  const Voxels merged("/intensity_decompressor/merged");
  const std::string map = temporaryFolder() + "/one_sensor.ot";
  launch("one_sensor.launch",
         {"simulated:=true",
          "intensity:=quadratic",
          "effort:=fast",
          "min_intensity:=1",
          "crop_box:=[0, 0, 0.1, 10, 10, 4]",
          "map_path:=" + map});
  expectVoxels(voxels);
  expectVoxels(merged);
  expectCleanEnd();
  EXPECT_TRUE(std::filesystem::exists(map));
}

TEST_F(LaunchFiles, OneSensorOnTwoComputers)
{
  const Voxels voxels("/camera/points/pcl_ext/voxels");
  launch("one_sensor.launch",
         {"simulated:=true", "points:=/camera/points", "central_side:=false"});
  ChildProcess central({"roslaunch",
                        "--skip-log-check",
                        "pcl_ext_ros1",
                        "one_sensor.launch",
                        "points:=/camera/points",
                        "sensor_side:=false"});
  expectVoxels(voxels);
  EXPECT_EQ(central.interrupt(), 0) << central.output();
  expectCleanEnd();
}

TEST_F(LaunchFiles, RequiredNodeThatEndsEndsAll)
{
  launch("one_sensor.launch", {"simulated:=true", "effort:=slow", "required:=true"});
  EXPECT_TRUE(roslaunch->waitForExit());
  roslaunch->expectOutput("~effort is 'slow'");
}

TEST_F(LaunchFiles, SixKinects)
{
  std::vector<std::unique_ptr<Voxels>> streams;
  for (int sensor = 1; sensor <= 6; ++sensor)
    streams.push_back(std::make_unique<Voxels>("/kinect_" + std::to_string(sensor) +
                                               "/points/pcl_ext/voxels"));
  const Voxels merged("/intensity_decompressor/merged");
  launch("six_kinects.launch",
         {"captured_frames:=2", "rate:=4", "remove_outliers:=true"});
  for (const auto& stream : streams)
    expectVoxels(*stream);
  expectVoxels(merged);
  bool removes_outliers = false;
  EXPECT_TRUE(
      ros::param::get("/intensity_decompressor/remove_outliers", removes_outliers));
  EXPECT_TRUE(removes_outliers);
  double min_intensity = -1.0;
  EXPECT_TRUE(ros::param::get("/intensity_decompressor/min_intensity", min_intensity));
  EXPECT_EQ(min_intensity, 0.0);
  expectCleanEnd();
}

TEST_F(LaunchFiles, ReplayOfClouds)
{
  const std::string bag = record("clouds", {"/kinect_1/points", "/tf_static"});
  const Voxels voxels("/kinect_1/points/pcl_ext/voxels");
  launch("replay.launch", {"bag:=" + bag});
  expectVoxels(voxels);
  expectCleanEnd();
}

TEST_F(LaunchFiles, ReplayOfFrames)
{
  const std::string bag = record("frames", {"/kinect_1/points/pcl_ext"});
  const Voxels voxels("/kinect_1/points/pcl_ext/voxels");
  launch("replay.launch", {"bag:=" + bag, "compressed:=true", "loop:=true"});
  expectVoxels(voxels);
  expectCleanEnd();
}

} // namespace

} // namespace test
} // namespace pcl_ext_ros1

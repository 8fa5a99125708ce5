/** \file
 * \brief Nodes of the tests, clouds, and what the library makes of them without ROS.
 */
#pragma once

#include <pcl_ext/compression/frame_decoder.h>
#include <pcl_ext/nodes/sensor_node.h>

#include <pcl/PCLPointCloud2.h>

#include <gtest/gtest.h>

#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <point_cloud_interfaces/msg/compressed_point_cloud2.hpp>
#include <point_cloud_transport/point_cloud_transport.hpp>
#include <rclcpp/rclcpp.hpp>
#include <sensor_msgs/msg/point_cloud2.hpp>
#include <std_msgs/msg/empty.hpp>

#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace pcl_ext_point_cloud_transport {
namespace test {

using Cloud = sensor_msgs::msg::PointCloud2;
using Compressed = point_cloud_interfaces::msg::CompressedPointCloud2;
using Stamp = builtin_interfaces::msg::Time;
using Parameters = std::vector<rclcpp::Parameter>;

/** \brief Long, as other processes may keep the computer busy. Only a test that fails waits
 * so long. */
constexpr double seconds_to_wait = 60.0;

/** \brief Waits until a condition holds.
 * \return false if it does not hold in time
 */
template <typename ConditionT>
bool
waitFor(ConditionT&& condition, double seconds = seconds_to_wait)
{
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + std::chrono::duration<double>(seconds);
  while (!condition()) {
    if (Clock::now() >= end)
      return condition();
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return true;
}

/** \brief A namespace of this test and process: nodes of other tests are never met. */
std::string
spaceOfThisTest();

/** \brief A file or folder of this process, which is removed at its end. */
std::string
temporaryPath(const std::string& name);

/** \brief A node in spaceOfThisTest() that is spun by a thread of its own. */
class SpunNode {
public:
  /** \param[in] name of the node
   * \param[in] overrides of parameters; their names begin with the topic's, see points()
   * \param[in] options the rest
   */
  explicit SpunNode(const std::string& name,
                    const Parameters& overrides = {},
                    rclcpp::NodeOptions options = rclcpp::NodeOptions());
  ~SpunNode();
  SpunNode(const SpunNode&) = delete;
  SpunNode&
  operator=(const SpunNode&) = delete;

  const rclcpp::Node::SharedPtr node;

private:
  rclcpp::executors::SingleThreadedExecutor executor_;
  std::thread thread_;
};

/** \brief Reliable, with a queue that is longer than any test. */
rmw_qos_profile_t
reliable();

/** \brief The messages of a topic. Thread-safe. */
template <typename MessageT>
class Recorder {
public:
  using Message = std::shared_ptr<const MessageT>;

  void
  add(const Message& message)
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    messages_.push_back(message);
  }

  std::vector<Message>
  messages() const
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    return messages_;
  }

  std::size_t
  count() const
  {
    return messages().size();
  }

  bool
  waitForCount(std::size_t count, double seconds = seconds_to_wait) const
  {
    return waitFor([&] { return this->count() >= count; }, seconds);
  }

  /** \brief The message of a stamp; null if it did not arrive. */
  Message
  find(const Stamp& stamp) const
  {
    for (const Message& message : messages())
      if (message->header.stamp == stamp)
        return message;
    return nullptr;
  }

  /** \brief Waits for the message of a stamp.
   * \return null if it does not arrive in time
   */
  Message
  waitForStamp(const Stamp& stamp, double seconds = seconds_to_wait) const
  {
    Message found;
    waitFor([&] { return (found = find(stamp)) != nullptr; }, seconds);
    return found;
  }

private:
  mutable std::mutex mutex_;
  std::vector<Message> messages_;
};

/** \brief Full name of a parameter of the topic "points". */
inline std::string
points(const std::string& parameter)
{
  return "points.pcl_ext." + parameter;
}

/** \brief Half the edge of the crop box, metres. */
constexpr double box_edge = 10.0;

/** \brief A node that publishes "points" with this plugin alone, and with a crop box, so
 * that the voxels of a cloud do not depend on the clouds before. */
class Sender {
public:
  explicit Sender(const Parameters& overrides = {},
                  const std::string& name = "sender",
                  const rmw_qos_profile_t& qos = reliable(),
                  rclcpp::NodeOptions options = rclcpp::NodeOptions());

  rclcpp::Node&
  node()
  {
    return *spun.node;
  }

  /** \brief Waits for a number of subscriptions. */
  void
  expectSubscribers(std::size_t count);

  SpunNode spun;
  point_cloud_transport::Publisher publisher;
};

/** \brief A node that subscribes to "points" with this plugin. */
class Receiver {
public:
  explicit Receiver(const Parameters& overrides = {},
                    const std::string& name = "receiver",
                    const std::string& topic = "points",
                    const rmw_qos_profile_t& qos = reliable(),
                    rclcpp::NodeOptions options = rclcpp::NodeOptions());

  rclcpp::Node&
  node()
  {
    return *spun.node;
  }

  void
  expectPublishers(std::size_t count);

  Recorder<Cloud> clouds; // first, as callbacks add to it
  SpunNode spun;
  point_cloud_transport::Subscriber subscriber;
};

/** \brief Subscribes to a topic with any message that has a header. */
template <typename MessageT>
class Listener {
public:
  Listener(rclcpp::Node& node, const std::string& topic)
  : subscription_(node.create_subscription<MessageT>(
        topic,
        rclcpp::QoS(1000),
        [this](const std::shared_ptr<const MessageT>& message) {
          recorder.add(message);
        }))
  {}

  Recorder<MessageT> recorder;

private:
  typename rclcpp::Subscription<MessageT>::SharedPtr subscription_;
};

/** \brief The last entry of a node in /diagnostics whose values and level the test awaits. */
class Diagnostics {
public:
  using Status = diagnostic_msgs::msg::DiagnosticStatus;

  /** \param[in] observer where to subscribe
   * \param[in] node_name of the node in spaceOfThisTest() that reports
   */
  Diagnostics(rclcpp::Node& observer, const std::string& node_name);

  /** \brief All entries of the node until now. */
  std::vector<Status>
  entries() const;

  /** \brief Waits for an entry for which a condition holds. */
  bool
  waitForEntry(const std::function<bool(const Status&)>& condition) const;

private:
  std::string prefix_;
  Listener<diagnostic_msgs::msg::DiagnosticArray> listener_;
};

/** \brief The value of a key; -1 if there is none. */
double
valueOf(const Diagnostics::Status& status, const std::string& key);

/** \brief Layouts of clouds. */
enum class Layout {
  Xyz,        ///< 12 bytes
  XyzPadded,  ///< 16 bytes, as PCL's PointXYZ
  Xyzi,       ///< PCL's PointXYZI: 32 bytes
  XyziPacked, ///< 16 bytes
  XyzRgb,     ///< PCL's PointXYZRGB: 32 bytes
  Lidar,      ///< intensity as UINT16, ring, time as FLOAT64, not aligned
  XyzRgbi,    ///< colours and intensities
  Organized,  ///< Xyz as an image of several rows
  PaddedRows, ///< Xyzi as an image with bytes after each row
};

constexpr std::array<Layout, 9> all_layouts{Layout::Xyz,
                                            Layout::XyzPadded,
                                            Layout::Xyzi,
                                            Layout::XyziPacked,
                                            Layout::XyzRgb,
                                            Layout::Lidar,
                                            Layout::XyzRgbi,
                                            Layout::Organized,
                                            Layout::PaddedRows};

bool
hasIntensity(Layout layout);

Stamp
stampOf(std::uint32_t number);

/** \brief A noisy wall and a ball that moves in front of it, with some points that are not
 * finite and some that are noise. Points and stamp depend on the number only. */
Cloud
makeCloud(std::uint32_t number, Layout layout = Layout::Xyz);

pcl::PCLPointCloud2
toPcl(const Cloud& cloud);

/** \brief Voxels as points x, y, z, intensity, colour (0: none), in their order. */
using Voxels = std::vector<std::array<float, 5>>;

/** \brief The points of a cloud. Its layout must be that of decoded voxels. */
Voxels
voxelsIn(const Cloud& message);

Voxels
voxelsIn(const pcl_ext::io::VoxelFrame& frame);

/** \brief Settings of a Sender without overrides for clouds with or without intensity. */
pcl_ext::nodes::SensorNodeSettings
defaultSettings(Layout layout = Layout::Xyz);

/** \brief The same stream, encoded and decoded by the library alone. */
class DirectStream {
public:
  explicit DirectStream(const pcl_ext::nodes::SensorNodeSettings& settings);

  /** \brief The next cloud, encoded and decoded. */
  pcl_ext::io::VoxelFrame
  frameOf(const Cloud& cloud);

  Voxels
  voxelsOf(const Cloud& cloud)
  {
    return voxelsIn(frameOf(cloud));
  }

private:
  pcl_ext::nodes::SensorNode sensor_node_;
  pcl_ext::io::FrameDecoder decoder_;
};

/** \brief The voxels of a cloud that is the first one of its stream. */
Voxels
directVoxels(const Cloud& cloud, const pcl_ext::nodes::SensorNodeSettings& settings);

/** \brief Publishes a cloud and expects these voxels with its header. */
void
expectVoxels(Sender& sender,
             const Receiver& receiver,
             const Cloud& cloud,
             const Voxels& expected);

/** \brief True if a decoder without history decodes the frame. */
bool
isIFrame(const Compressed& frame);

} // namespace test
} // namespace pcl_ext_point_cloud_transport

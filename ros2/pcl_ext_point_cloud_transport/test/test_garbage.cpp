/** \file
 * \brief Messages and clouds that are invalid.
 */
#include "plugin_test.h"

#include <random>

namespace pcl_ext_point_cloud_transport {
namespace test {

namespace {

/** \brief Frames of a stream with an I-frame each 4, as the plugin sends them. */
std::vector<Compressed>
makeFrames(std::uint32_t count)
{
  auto settings = defaultSettings();
  settings.compression.i_frame_rate = 4;
  pcl_ext::nodes::SensorNode node(settings);
  std::vector<Compressed> frames;
  for (std::uint32_t i = 0; i < count; ++i) {
    const Cloud cloud = makeCloud(i);
    frames.emplace_back();
    frames.back().header = cloud.header;
    frames.back().format = "pcl_ext/version1";
    EXPECT_TRUE(node.encode(toPcl(cloud),
                            pcl_ext::WorldPose(pcl_ext::WorldPose::Identity()),
                            frames.back().compressed_data)
                    .ok());
  }
  return frames;
}

/** \brief A frame with some damage; always another one. */
void
damage(std::mt19937& random, Compressed& frame)
{
  auto& bytes = frame.compressed_data;
  const auto changed = [&random] {
    return static_cast<std::uint8_t>(1 + random() % 255);
  };
  switch (random() % 6) {
  case 0: // garbage
    bytes.resize(random() % 3000);
    for (std::uint8_t& byte : bytes)
      byte = static_cast<std::uint8_t>(random());
    break;
  case 1: // cut
    bytes.resize(random() % bytes.size());
    break;
  case 2: // one byte changed
    bytes[random() % bytes.size()] ^= changed();
    break;
  case 3: // the first bytes, which have the sizes
    bytes[random() % std::min<std::size_t>(64, bytes.size())] ^= changed();
    break;
  case 4: // a part is missing
    bytes.erase(bytes.begin() + static_cast<std::ptrdiff_t>(random() % bytes.size()));
    break;
  default: { // another format
    const char* const formats[] = {"", "draco", "pcl_ext", "pcl_ext/version2", "zlib"};
    frame.format = formats[random() % 5];
  }
  }
  frame.width = static_cast<std::uint32_t>(random());
  frame.height = static_cast<std::uint32_t>(random());
  frame.point_step = static_cast<std::uint32_t>(random());
  frame.row_step = static_cast<std::uint32_t>(random());
  frame.fields.resize(random() % 3);
  frame.is_bigendian = random() % 2 != 0;
}

TEST(Garbage, TenThousandDamagedMessagesGiveNoWrongCloud)
{
  Receiver receiver;
  SpunNode attacker("attacker");
  const auto publisher =
      attacker.node->create_publisher<Compressed>("points/pcl_ext", rclcpp::QoS(20000));
  ASSERT_TRUE(waitFor([&] { return publisher->get_subscription_count() == 1; }));
  receiver.expectPublishers(1);
  const std::vector<Compressed> frames = makeFrames(12);
  std::mt19937 random(7);
  constexpr std::size_t count = 10000;
  Diagnostics health(*attacker.node, "receiver");
  for (std::size_t i = 0; i < count; ++i) {
    Compressed frame = frames[i % frames.size()];
    damage(random, frame);
    publisher->publish(frame);
  }
  // Numbers of frames in the headers may be damaged, too: those of a stream that goes on
  // are above.
  publisher->publish(frames[0]);
  publisher->publish(frames[4]);
  const auto last = receiver.clouds.waitForStamp(frames[4].header.stamp);
  EXPECT_TRUE(last);
  for (const auto& cloud : receiver.clouds.messages()) {
    bool is_right = false;
    for (std::uint32_t i = 0; i < frames.size(); ++i)
      is_right = is_right ||
                 (cloud->header == frames[i].header &&
                  voxelsIn(*cloud) == directVoxels(makeCloud(i), defaultSettings()));
    EXPECT_TRUE(is_right) << cloud->header.stamp.nanosec;
  }
  EXPECT_TRUE(health.waitForEntry([&](const Diagnostics::Status& status) {
    return valueOf(status, "frames received") +
               valueOf(status, "frames of other frame id or format") ==
           count + 2;
  }));
}

TEST(Garbage, WrongLayoutInTheMessageHasNoEffect)
{
  Receiver receiver;
  SpunNode other("other");
  const auto publisher =
      other.node->create_publisher<Compressed>("points/pcl_ext", rclcpp::QoS(100));
  ASSERT_TRUE(waitFor([&] { return publisher->get_subscription_count() == 1; }));
  receiver.expectPublishers(1);
  Compressed frame = makeFrames(1).front();
  frame.width = 4000000000u;
  frame.height = 7;
  frame.point_step = 0;
  frame.row_step = 1;
  frame.is_bigendian = true;
  publisher->publish(frame);
  const auto decoded = receiver.clouds.waitForStamp(frame.header.stamp);
  ASSERT_TRUE(decoded);
  EXPECT_TRUE(voxelsIn(*decoded) == directVoxels(makeCloud(0), defaultSettings()));
}

TEST(Garbage, BrokenCloudsAreRefusedAndReported)
{
  Sender sender;
  Receiver receiver;
  Diagnostics health(receiver.node(), "sender");
  sender.expectSubscribers(1);
  receiver.expectPublishers(1);
  const std::vector<std::function<void(Cloud&)>> breaks{
      [](Cloud& cloud) { cloud.data.clear(); },
      [](Cloud& cloud) { cloud.data.resize(cloud.data.size() / 2); },
      [](Cloud& cloud) { cloud.fields.clear(); },
      [](Cloud& cloud) { cloud.fields[2].name = "depth"; },
      [](Cloud& cloud) { cloud.fields[2].offset = 4000000000u; },
      [](Cloud& cloud) { cloud.fields[0].datatype = 77; },
      [](Cloud& cloud) { cloud.point_step = 0; },
      [](Cloud& cloud) { cloud.point_step = 4294967295u; },
      [](Cloud& cloud) { cloud.width = 4294967295u; },
      [](Cloud& cloud) { cloud.width = cloud.height = 1u << 31; }};
  std::uint32_t number = 0;
  for (const auto& apply : breaks) {
    Cloud broken = makeCloud(number++);
    apply(broken);
    sender.publisher.publish(broken);
    const Cloud good = makeCloud(number++);
    expectVoxels(sender, receiver, good, directVoxels(good, defaultSettings()));
    EXPECT_FALSE(receiver.clouds.find(broken.header.stamp));
  }
  EXPECT_EQ(receiver.clouds.count(), breaks.size());
  EXPECT_TRUE(health.waitForEntry([&](const Diagnostics::Status& status) {
    return valueOf(status, "clouds refused") == static_cast<double>(breaks.size());
  }));
  EXPECT_TRUE(health.waitForEntry([&](const Diagnostics::Status& status) {
    return status.level == Diagnostics::Status::ERROR &&
           status.message == "Clouds are refused";
  }));
}

TEST(Garbage, CloudsWithoutPointsGiveCloudsWithoutPoints)
{
  Sender sender;
  Receiver receiver;
  sender.expectSubscribers(1);
  receiver.expectPublishers(1);
  for (std::uint32_t i = 0; i < 3; ++i) {
    Cloud cloud = makeCloud(i);
    if (i == 0)
      std::fill(cloud.data.begin(), cloud.data.end(), std::uint8_t{0xff}); // all NaN
    if (i == 1) {
      cloud.data.clear();
      cloud.width = 0;
      cloud.row_step = 0;
    }
    sender.publisher.publish(cloud);
    const auto decoded = receiver.clouds.waitForStamp(cloud.header.stamp);
    ASSERT_TRUE(decoded);
    EXPECT_EQ(voxelsIn(*decoded).empty(), i < 2);
  }
}

} // namespace

} // namespace test
} // namespace pcl_ext_point_cloud_transport

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief The plugins without a node: clouds to messages and back.
 */
#include "plugin_test.h"

#include <point_cloud_transport/point_cloud_codec.hpp>
#include <point_cloud_transport/simple_publisher_plugin.hpp>
#include <point_cloud_transport/simple_subscriber_plugin.hpp>

namespace pcl_ext_point_cloud_transport::test {

namespace {

using Encoder = point_cloud_transport::SimplePublisherPlugin<Compressed>;
using Decoder = point_cloud_transport::SimpleSubscriberPlugin<Compressed>;

/** \brief The type in the plugins' manifest; version 5.4 and later read it. */
template <typename PluginT>
auto
messageTypeOf(const PluginT& plugin, int) -> decltype(plugin.getMessageType())
{
  return plugin.getMessageType();
}

template <typename PluginT>
std::string
messageTypeOf(const PluginT& plugin, long)
{
  return plugin.getDataType();
}

class Codec : public ::testing::Test {
protected:
  Codec()
  : encoder(codec.getEncoderByName("pcl_ext"))
  , decoder(codec.getDecoderByName("pcl_ext"))
  {}

  const Encoder&
  typedEncoder() const
  {
    return dynamic_cast<const Encoder&>(*encoder);
  }

  const Decoder&
  typedDecoder() const
  {
    return dynamic_cast<const Decoder&>(*decoder);
  }

  // The grid is that of the first cloud.
  static pcl_ext::nodes::SensorNodeSettings
  settingsOf(Layout layout)
  {
    auto settings = defaultSettings(layout);
    settings.crop_box.reset();
    return settings;
  }

  point_cloud_transport::PointCloudCodec codec; // outlives what it has loaded
  std::shared_ptr<point_cloud_transport::PublisherPlugin> encoder;
  std::shared_ptr<point_cloud_transport::SubscriberPlugin> decoder;
};

TEST_F(Codec, NamesAndTopics)
{
  ASSERT_TRUE(encoder);
  ASSERT_TRUE(decoder);
  EXPECT_EQ(encoder->getTransportName(), "pcl_ext");
  EXPECT_EQ(decoder->getTransportName(), "pcl_ext");
  EXPECT_EQ(encoder->getDataType(), "point_cloud_interfaces/msg/CompressedPointCloud2");
  EXPECT_EQ(decoder->getDataType(), "point_cloud_interfaces/msg/CompressedPointCloud2");
  EXPECT_EQ(messageTypeOf(*encoder, 0), encoder->getDataType());
  EXPECT_EQ(messageTypeOf(*decoder, 0), decoder->getDataType());
  EXPECT_EQ(encoder->getTopicToAdvertise("/a/b"), "/a/b/pcl_ext");
  EXPECT_EQ(decoder->getTopicToSubscribe("/a/b"), "/a/b/pcl_ext");
  EXPECT_EQ(encoder->getTopic(), "");
  EXPECT_EQ(decoder->getTopic(), "");
  EXPECT_EQ(encoder->getNumSubscribers(), 0u);
  EXPECT_EQ(decoder->getNumPublishers(), 0u);
}

TEST_F(Codec, TypedMessagesOfAStream)
{
  for (const Layout layout : {Layout::Lidar, Layout::PaddedRows, Layout::XyzRgbi}) {
    const auto this_encoder = codec.getEncoderByName("pcl_ext");
    const auto this_decoder = codec.getDecoderByName("pcl_ext");
    DirectStream direct(settingsOf(layout));
    for (std::uint32_t i = 0; i < 5; ++i) {
      const Cloud cloud = makeCloud(i, layout);
      const auto encoded =
          dynamic_cast<const Encoder&>(*this_encoder).encodeTyped(cloud);
      ASSERT_TRUE(encoded && encoded.value()) << (encoded ? "" : encoded.error());
      EXPECT_EQ(encoded.value()->header, cloud.header);
      EXPECT_EQ(isIFrame(*encoded.value()), i == 0);
      const auto decoded =
          dynamic_cast<const Decoder&>(*this_decoder).decodeTyped(*encoded.value());
      ASSERT_TRUE(decoded && decoded.value()) << (decoded ? "" : decoded.error());
      EXPECT_EQ((*decoded.value())->header, cloud.header);
      EXPECT_TRUE(voxelsIn(**decoded.value()) == direct.voxelsOf(cloud)) << i;
    }
  }
}

TEST_F(Codec, SerializedMessagesOfAStream)
{
  DirectStream direct(settingsOf(Layout::Xyzi));
  for (std::uint32_t i = 0; i < 5; ++i) {
    const Cloud cloud = makeCloud(i, Layout::Xyzi);
    const auto encoded = encoder->encode(cloud);
    ASSERT_TRUE(encoded && encoded.value());
    const auto decoded = decoder->decode(*encoded.value());
    ASSERT_TRUE(decoded && decoded.value());
    EXPECT_TRUE(voxelsIn(**decoded.value()) == direct.voxelsOf(cloud)) << i;
  }
}

TEST_F(Codec, EachCallOfThePointCloudCodecIsAStreamOfItsOwn)
{
  for (std::uint32_t i = 0; i < 3; ++i) {
    const Cloud cloud = makeCloud(i, Layout::Xyzi);
    rclcpp::SerializedMessage bytes;
    Cloud decoded;
    ASSERT_TRUE(codec.encode("pcl_ext", cloud, bytes));
    ASSERT_TRUE(codec.decode("pcl_ext", bytes, decoded));
    EXPECT_TRUE(voxelsIn(decoded) == directVoxels(cloud, settingsOf(Layout::Xyzi)));
  }
}

TEST_F(Codec, ErrorsAreReturned)
{
  Cloud broken = makeCloud(0);
  broken.data.resize(5);
  const auto encoded = typedEncoder().encodeTyped(broken);
  EXPECT_FALSE(encoded);
  EXPECT_FALSE(encoded.error().empty());
  EXPECT_FALSE(encoder->encode(broken));

  auto good = typedEncoder().encodeTyped(makeCloud(1));
  ASSERT_TRUE(good && good.value());
  const auto lost = typedEncoder().encodeTyped(makeCloud(2));
  const auto next = typedEncoder().encodeTyped(makeCloud(3));
  ASSERT_TRUE(lost && next);
  EXPECT_TRUE(typedDecoder().decodeTyped(*good.value()));
  const auto without_reference = typedDecoder().decodeTyped(*next.value());
  ASSERT_FALSE(without_reference);
  EXPECT_FALSE(without_reference.error().empty());
  good.value()->format = "draco";
  const auto other = typedDecoder().decodeTyped(*good.value());
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error(), "unknown format 'draco'");
  EXPECT_FALSE(decoder->decode(std::make_shared<rclcpp::SerializedMessage>()));
}

} // namespace

} // namespace pcl_ext_point_cloud_transport::test

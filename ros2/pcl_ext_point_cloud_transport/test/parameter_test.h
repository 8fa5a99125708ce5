// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief What tests of parameters have in common.
 */
#pragma once

#include "plugin_test.h"

namespace pcl_ext_point_cloud_transport::test {

/** \brief Both ends; the voxels are compared with those of the settings. */
class ParameterTest : public ::testing::Test {
protected:
  void
  start(const Parameters& of_sender = {}, const Parameters& of_receiver = {})
  {
    sender.emplace(of_sender);
    receiver.emplace(of_receiver);
    sender->expectSubscribers(1);
    receiver->expectPublishers(1);
  }

  /** \brief Sets a parameter of the sender, and expects its effect. */
  template <typename ValueT>
  void
  setAndExpect(const std::string& name, const ValueT& value)
  {
    const auto result =
        sender->node().set_parameter(rclcpp::Parameter(points(name), value));
    EXPECT_TRUE(result.successful) << result.reason;
    expectNext();
  }

  void
  expectNext()
  {
    for (int i = 0; i < 2; ++i, ++number) {
      const Cloud cloud = makeCloud(number, layout);
      expectVoxels(*sender, *receiver, cloud, directVoxels(cloud, settings));
    }
  }

  Layout layout = Layout::XyzRgbi;
  pcl_ext::nodes::SensorNodeSettings settings = defaultSettings(Layout::XyzRgbi);
  std::optional<Sender> sender;
  std::optional<Receiver> receiver;
  std::uint32_t number = 0;
};

} // namespace pcl_ext_point_cloud_transport::test

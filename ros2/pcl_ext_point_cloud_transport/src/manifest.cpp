// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "pcl_ext_point_cloud_transport/publisher.hpp"
#include "pcl_ext_point_cloud_transport/subscriber.hpp"

#include <pluginlib/class_list_macros.hpp>

PLUGINLIB_EXPORT_CLASS(pcl_ext_point_cloud_transport::Publisher,
                       point_cloud_transport::PublisherPlugin)
PLUGINLIB_EXPORT_CLASS(pcl_ext_point_cloud_transport::Subscriber,
                       point_cloud_transport::SubscriberPlugin)

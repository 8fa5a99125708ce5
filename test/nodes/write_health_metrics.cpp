// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * Writes the metrics of streams that have the names given as arguments, decoded, encoded
 * and received, for test_metrics.py.
 */
#include <pcl_ext/nodes/impl/health_metrics.h>

#include "link/link_metrics.h"

#include <iostream>

int
main(int argc, char** argv)
{
  using namespace pcl_ext::nodes;
  std::vector<StreamHealth> streams;
  std::vector<std::pair<std::string, SenderHealth>> senders;
  pcl_ext::link::SubscriberStatistics link;
  for (int i = 1; i < argc; ++i) {
    StreamHealth stream;
    stream.name = argv[i];
    stream.frames_decoded = static_cast<std::size_t>(i);
    stream.rates.mean_latency_seconds = 0.25;
    stream.decode_times.add(0.002);
    streams.push_back(stream);
    pcl_ext::link::LinkStreamStatistics received;
    received.name = argv[i];
    received.frames = static_cast<std::uint64_t>(i);
    received.age = std::chrono::seconds(i);
    link.streams.push_back(received);
    SenderHealth sender;
    sender.clouds = static_cast<std::size_t>(i);
    sender.last_arrival = std::chrono::seconds(4);
    sender.node.rates.mean_latency_seconds = 0.25;
    senders.emplace_back(argv[i], sender);
  }
  pcl_ext::link::PublisherStatistics sent;
  sent.age = std::chrono::seconds(1);
  const MetricLabels labels{{"site", "a \"b\"\n\\"}};
  const Time now = std::chrono::seconds(5);
  std::cout << streamMetrics(streams, now, labels)
            << senderMetrics(senders, now, labels) << mergeMetrics({3, 1}, labels)
            << mapMetrics({4, 2}, labels) << pcl_ext::link::linkMetrics(link, labels)
            << pcl_ext::link::linkMetrics(sent, labels);
}

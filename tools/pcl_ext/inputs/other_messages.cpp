// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "inputs/other_messages.h"

#include "recording/rosbag2_folder.h"

#include <algorithm>
#include <string>

namespace pcl_ext::tools {

std::size_t
latchedMessages(const recording::McapChannel& channel)
{
  // Any number of nodes publish on it, and old bags do not tell its QoS.
  constexpr std::size_t most = 1000;
  const std::string transforms = "/tf_static";
  if (channel.topic.size() >= transforms.size() &&
      channel.topic.compare(
          channel.topic.size() - transforms.size(), transforms.size(), transforms) == 0)
    return most;
  std::size_t messages = 0;
  for (const auto& [name, value] : channel.metadata) {
    if (name == "latching" && value == "1")
      ++messages;
    if (name != recording::qos_metadata)
      continue;
    // An entry for each publisher.
    for (const std::string local : {"durability: 1", "durability: transient_local"})
      for (std::size_t i = value.find(local); i != std::string::npos;
           i = value.find(local, i + 1))
        ++messages;
  }
  return std::min(messages, most);
}

std::vector<std::size_t>
othersOfPart(const recording::BagReader& bag,
             const std::vector<std::size_t>& others,
             recording::Time from,
             recording::Time to)
{
  const auto indexOf = [&](recording::Time time) {
    return std::lower_bound(others.begin(),
                            others.end(),
                            time,
                            [&bag](std::size_t message, recording::Time bound) {
                              return bag.index()[message].log_time < bound;
                            });
  };
  const auto begin = indexOf(from);
  std::vector<std::size_t> latched; // how many of each channel
  for (const recording::McapChannel& channel : bag.channels())
    latched.push_back(latchedMessages(channel));
  std::vector<std::size_t> chosen;
  for (auto message = begin; message != others.begin();)
    if (std::size_t& more = latched[bag.index()[*--message].channel]; more > 0) {
      --more;
      chosen.push_back(*message);
    }
  std::reverse(chosen.begin(), chosen.end());
  chosen.insert(chosen.end(), begin, std::max(begin, indexOf(to)));
  return chosen;
}

} // namespace pcl_ext::tools

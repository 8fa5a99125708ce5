// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "inputs/cloud_input.h"
#include "recording/point_cloud_messages.h"

#include <cstddef>
#include <string>
#include <vector>

namespace pcl_ext::tools {

/** \brief The clouds among the messages of bags. */
class BagInput : public CloudInput {
public:
  explicit BagInput(const InputOptions& options) : options_(options) {}

  const std::vector<std::string>&
  streams() const override
  {
    return streams_;
  }

  bool
  isBag() const override
  {
    return true;
  }

protected:
  static constexpr std::size_t none = ~std::size_t{0};

  /** \brief Makes streams of the channels with clouds that are wanted. Channels of one
   * topic, as of two publishers, are one stream.
   * \param[in] channels that were known before come first
   */
  void
  addChannels(const std::vector<recording::McapChannel>& channels);

  /** \brief Counts a message of a stream.
   * \param[out] cloud its number and names
   * \return false if it is not wanted
   */
  bool
  count(std::size_t stream, InputCloud& cloud);

  /** \brief Sets a cloud by its message, after those of its stream before it. */
  void
  readNext(const recording::McapChannel& channel, InputCloud& cloud);

  /** \brief True if a stream may have clouds that are wanted, of those that are known
   * or named by --topics. */
  bool
  wantsMore() const;

  /** \brief Whether a type has a name that drivers give to points and packets of them. */
  static bool
  mayBeClouds(const recording::McapChannel& channel);

  /** \brief What there is in place of clouds.
   * \param[in] name of the input
   */
  static std::string
  whyNoClouds(const std::string& name,
              const std::vector<recording::McapChannel>& channels);

  InputOptions options_;
  std::vector<std::string> topics_; // with clouds
  std::vector<std::string> streams_;
  std::vector<std::size_t> stream_of_channel_; // or none
  std::vector<std::size_t> clouds_;            // of each stream that were met

private:
  /** \brief What tells how colours of a stream are read. */
  struct Colours {
    clouds::ColourScale scale;
    bool is_known = false; // as there was a cloud with points
  };

  std::vector<Colours> colours_;         // of each stream
  recording::PointCloudMessage message_; // a member so that its memory is reused
};

} // namespace pcl_ext::tools

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/link/frame_subscriber.h>

#include "inputs/stream_metadata.h"

#include <map>
#include <string>
#include <utility>

namespace pcl_ext::tools {

/** \brief What is done with the frames of a site. Failures throw std::runtime_error. */
class FrameTaker {
public:
  virtual ~FrameTaker() = default;

  /** \brief Takes the next frame of a stream. */
  virtual void
  take(const link::LinkFrame& frame) = 0;

  /** \brief Why frames may be missing, one sentence; empty: that is over. */
  virtual void
  setProblem(const std::string& /* problem */)
  {}

  /** \brief Does what is due; called at least 20 times a second. */
  virtual void
  work()
  {}

  /** \brief No frames will follow. */
  virtual void
  finish()
  {}

  /** \brief Whether frames were left out, which was told. */
  virtual bool
  hasLeftOut() const
  {
    return false;
  }
};

/** \brief Finds where a stream goes on with other metadata, as with another pose of its
 * sensor, when its sender began anew. */
class MetadataChanges {
public:
  /** \brief True if a frame has other metadata than the I-frame of its stream before. */
  bool
  take(const link::LinkFrame& frame)
  {
    if (!frame.is_i_frame)
      return false;
    const auto [known, is_new] = metadata_.emplace(frame.stream, frame.metadata);
    return !is_new && std::exchange(known->second, frame.metadata) != frame.metadata;
  }

private:
  std::map<std::string, StreamMetadata> metadata_; // by stream
};

} // namespace pcl_ext::tools

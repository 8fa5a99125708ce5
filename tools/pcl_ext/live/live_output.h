// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "inputs/stream_metadata.h"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace pcl_ext::tools {

/** \brief Where frames go as they are made. Members but addStream() may be called by
 * several threads. */
class LiveOutput {
public:
  virtual ~LiveOutput() = default;

  /** \brief Adds a stream.
   * \return its number, from 0
   * \throws std::runtime_error
   */
  virtual std::size_t
  addStream(const std::string& name, const StreamMetadata& metadata) = 0;

  /** \brief Takes the next frame of a stream.
   * \param[in] time of the cloud
   * \throws std::runtime_error
   */
  virtual void
  publish(std::size_t stream,
          std::chrono::nanoseconds time,
          std::vector<std::uint8_t> frame) = 0;

  /** \brief False while nobody takes frames, which need not be made then. */
  virtual bool
  isWanted() const
  {
    return true;
  }

  /** \brief No frames will follow. */
  virtual void
  end()
  {}
};

} // namespace pcl_ext::tools

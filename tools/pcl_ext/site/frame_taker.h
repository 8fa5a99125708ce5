// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/link/frame_subscriber.h>

#include <string>

namespace pcl_ext {
namespace tools {

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

} // namespace tools
} // namespace pcl_ext

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/view/view_server.h>

#include "console/throw_unless_ok.h"
#include "live/live_output.h"

#include <utility>

namespace pcl_ext::tools {

/** \brief Shows frames in browsers. */
class ViewOutput : public LiveOutput {
public:
  /** \param[in] server must outlive this */
  explicit ViewOutput(view::ViewServer& server) : server_(server) {}

  std::size_t
  addStream(const std::string& name, const StreamMetadata& metadata) override
  {
    std::size_t stream = 0;
    throwUnlessOk(server_.addStream(name, metadata, stream));
    return stream;
  }

  void
  publish(std::size_t stream,
          std::chrono::nanoseconds time,
          std::vector<std::uint8_t> frame) override
  {
    throwUnlessOk(server_.publish(stream, time, std::move(frame)));
  }

  bool
  isWanted() const override
  {
    return server_.statistics().viewers > 0;
  }

  void
  end() override
  {
    server_.end();
  }

private:
  view::ViewServer& server_;
};

} // namespace pcl_ext::tools

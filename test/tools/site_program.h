// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include <pcl_ext/link/frame_publisher.h>

#include "support/nats_server.h"
#include "tools/background_program.h"
#include "view/clients.h"

#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <string>
#include <vector>

namespace pcl_ext::tools::test {

using link::test::NatsServer;

inline std::string
at(const NatsServer& server, const std::string& site = "cell")
{
  return " --server " + server.url() + " --site " + site + " ";
}

/** \brief The files of a recording part.mcap that is rotated. */
inline std::vector<std::filesystem::path>
partsIn(const TestFolder& folder)
{
  std::vector<std::filesystem::path> parts;
  for (const auto& entry : std::filesystem::directory_iterator(folder / ""))
    if (entry.path().filename().string().rfind("part_", 0) == 0)
      parts.push_back(entry.path());
  return parts;
}

inline std::string
metricsAt(std::uint16_t port)
{
  return view::test::request(port, "/metrics").body;
}

/** \brief A test with a server that keeps nothing. */
class SiteTest : public ProgramTest {
protected:
  NatsServer server;
};

/** \brief Starts a receiver, and returns when frames that are sent arrive. */
class Receiving : public BackgroundProgram {
public:
  /** \param[in] line of a shell before the arguments */
  Receiving(const TestFolder& folder,
            const std::string& arguments,
            const std::string& line = "exec $P receive ")
  : BackgroundProgram(folder, line + arguments)
  {
    waitForError("receiving from site");
  }
};

class SitePublisher {
public:
  explicit SitePublisher(const NatsServer& server,
                         const std::string& stream = "/sensor",
                         const link::StreamMetadata& metadata = {})
  : publisher_(settingsOf(server), [this](std::size_t) { wants_i_frame_ = true; })
  {
    EXPECT_TRUE(publisher_.connect().ok());
    EXPECT_TRUE(publisher_.addStream(stream, metadata, stream_).ok());
  }

  /** \param[in] flushes whether it waits until the server has the frame */
  void
  publish(recording::Time time, const Bytes& frame, bool flushes = true)
  {
    const auto status = publisher_.publish(stream_, time, frame.data(), frame.size());
    EXPECT_TRUE(status.ok()) << status.message();
    if (flushes) {
      EXPECT_TRUE(publisher_.flush(std::chrono::seconds(20)));
    }
  }

  bool
  takeRequest()
  {
    return wants_i_frame_.exchange(false);
  }

  static link::LinkSettings
  settingsOf(const NatsServer& server)
  {
    link::LinkSettings settings;
    settings.servers = server.url();
    settings.site = "cell";
    return settings;
  }

private:
  std::atomic<bool> wants_i_frame_{false};
  std::size_t stream_ = 0;
  link::FramePublisher publisher_;
};

} // namespace pcl_ext::tools::test

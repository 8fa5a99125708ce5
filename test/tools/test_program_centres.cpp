// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include <pcl_ext/link/frame_publisher.h>

#include "support/world_voxels.h"
#include "tools/site_program.h"

#include <gtest/gtest.h>

#include <atomic>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

namespace pcl_ext::tools::test {

using recording::Time;
using std::chrono::milliseconds;
using view::test::LiveSource;

namespace {

constexpr std::size_t stream_count = 20;
constexpr milliseconds period{100};

/** \brief Twenty sensors that publish ten frames a second each, with a clock of their
 * own: time 0 is the first frame's. */
class Sensors {
public:
  explicit Sensors(const NatsServer& server)
  : publisher_(SitePublisher::settingsOf(server),
               [this](std::size_t stream) { wanted_[stream] = true; })
  {
    EXPECT_TRUE(publisher_.connect().ok());
    for (std::size_t i = 0; i < stream_count; ++i) {
      sources_.emplace_back(1000, 20, i);
      std::size_t number = 0;
      EXPECT_TRUE(
          publisher_.addStream("/sensor_" + std::to_string(i), {}, number).ok());
      EXPECT_EQ(number, i);
    }
    thread_ = std::thread([this] { run(); });
  }

  ~Sensors()
  {
    has_ended_ = true;
    thread_.join();
  }

  Sensors(const Sensors&) = delete;
  Sensors&
  operator=(const Sensors&) = delete;

  Time
  now() const
  {
    return Time(period) * frames_.load();
  }

  void
  waitFor(Time time) const
  {
    const Time end = now() + time;
    while (now() < end)
      std::this_thread::sleep_for(milliseconds(5));
  }

private:
  void
  run()
  {
    auto next = std::chrono::steady_clock::now();
    for (int frame = 0; !has_ended_; ++frame) {
      frames_ = frame;
      for (std::size_t i = 0; i < stream_count; ++i) {
        if (wanted_[i].exchange(false))
          sources_[i].requestIFrame();
        const Bytes bytes = sources_[i].next();
        EXPECT_TRUE(
            publisher_.publish(i, Time(period) * frame, bytes.data(), bytes.size())
                .ok());
      }
      std::this_thread::sleep_until(next += period);
    }
  }

  std::array<std::atomic<bool>, stream_count> wanted_{};
  link::FramePublisher publisher_;
  std::deque<LiveSource> sources_;
  std::atomic<int> frames_{0};
  std::atomic<bool> has_ended_{false};
  std::thread thread_;
};

using Merged = std::map<Time, pcl_ext::test::WorldVoxels>;

/** \brief The voxels of a recorded stream by the times of its frames. */
Merged
mergedOf(const std::string& path, const std::string& stream)
{
  Merged merged;
  for (const DecodedStream& one : decode(path))
    if (one.name == stream)
      for (std::size_t i = 0; i < one.frames.size(); ++i)
        merged[one.frames[i].time] = pcl_ext::test::worldVoxels(one.voxels[i]);
  return merged;
}

/** \brief Adds the latest merged frame of a zone that is not later than a time. */
void
addLatest(const Merged& zone, Time time, pcl_ext::test::WorldVoxels& voxels)
{
  const auto after = zone.upper_bound(time);
  if (after != zone.begin())
    for (const auto& [index, intensity] : std::prev(after)->second)
      voxels[index] += intensity;
}

} // namespace

using ProgramCentres = ProgramTest;

TEST_F(ProgramCentres, ThreeAreOneAlsoAfterOneWasKilled)
{
  const NatsServer server("mappings = { \"cell.*.frames\": "
                          "\"cell.{{wildcard(1)}}.frames.{{partition(3,1)}}\" }");
  const std::string common =
      " --resolution 0.04 --merge-wait 1s --merge-age 1s --server " + server.url();
  const auto centre = [&](const std::string& part) {
    return std::make_unique<Receiving>(
        folder, "--site cell --partition " + part + " --merge zone_" + part + common);
  };
  std::vector<std::unique_ptr<BackgroundProgram>> programs;
  const std::string to = " --server " + server.url();
  for (const std::string& arguments :
       {"--site one -o one.mcap" + to,
        "--site top -o top.mcap" + to,
        "--site cell-merged -o zones.mcap" + to,
        "--site cell --merge all --merged-site one" + common,
        "--site cell-merged --merge all --merged-site top" + common})
    programs.push_back(std::make_unique<Receiving>(folder, arguments));
  std::vector<std::unique_ptr<BackgroundProgram>> zones;
  for (const std::string part : {"0", "1", "2"})
    zones.push_back(centre(part));

  Time killed;
  Time restarted;
  Time ended;
  {
    Sensors sensors(server);
    sensors.waitFor(std::chrono::seconds(2));
    killed = sensors.now();
    zones[1]->end(SIGKILL);
    sensors.waitFor(milliseconds(1500));
    restarted = sensors.now();
    zones[1] = centre("1");
    sensors.waitFor(std::chrono::seconds(4));
    ended = sensors.now();
  }
  for (auto* const group : {&zones, &programs})
    for (auto program = group->rbegin(); program != group->rend(); ++program)
      EXPECT_EQ((*program)->end(SIGINT), 0) << (*program)->errors();

  const Merged one = mergedOf(folder / "one.mcap", "all");
  const Merged top = mergedOf(folder / "top.mcap", "all");
  std::vector<Merged> parts;
  for (const std::string name : {"zone_0", "zone_2", "zone_1"})
    parts.push_back(mergedOf(folder / "zones.mcap", name));
  std::size_t before = 0;
  std::size_t without = 0; // that centre
  std::size_t after = 0;
  // The streams of the killed centre are back within two seconds of its restart.
  const Time back = restarted + std::chrono::seconds(2);
  for (const auto& [time, voxels] : one) {
    const auto found = top.find(time);
    if (time < milliseconds(500) || time > ended - milliseconds(500) ||
        found == top.end())
      continue;
    // Never a cloud that is wrong: at most one without what the killed centre had last.
    pcl_ext::test::WorldVoxels expected;
    addLatest(parts[0], time, expected);
    addLatest(parts[1], time, expected);
    const bool is_without = found->second == expected;
    addLatest(parts[2], time, expected);
    EXPECT_TRUE(is_without || found->second == expected) << time.count();
    const bool is_whole = found->second == voxels;
    before += time < killed && is_whole ? 1 : 0;
    without += is_without ? 1 : 0;
    after += time > back && is_whole ? 1 : 0;
    EXPECT_TRUE(is_whole || (time >= killed && time <= back)) << time.count();
  }
  EXPECT_GT(before, 10u);
  EXPECT_GT(without, 0u);
  EXPECT_GT(after, 5u);
  EXPECT_GT(parts[2].size(), 30u);
  EXPECT_TRUE(
      hasPart(programs[2]->errors(), "zone_1: its publisher began anew 1 time,"));
}

} // namespace pcl_ext::tools::test

/** \file
 * \brief Centres whose streams are those of sensors or of other centres; to be run under
 * ThreadSanitizer, too.
 */
#include <pcl_ext/nodes/merged_frame_encoder.h>
#include <pcl_ext/nodes/merging_centre.h>

#include "support/central_streams.h"
#include "support/world_voxels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <thread>

namespace {

namespace merging_centre {

using namespace pcl_ext::nodes;
using namespace pcl_ext::nodes::test;
using namespace std::chrono_literals;
using pcl_ext::test::worldVoxels;
using Voxels = pcl_ext::test::WorldVoxels;

constexpr Time begin = 1000s; // stamp of the first clouds
constexpr std::size_t sensors = 6;
constexpr std::size_t zones = 3;

/** \brief Threads that decode read it, too. */
using TestTime = std::atomic<Time>;

std::string
nameOf(std::size_t number)
{
  return "/" + std::to_string(number);
}

/** \brief A centre without a thread, and what it merges. */
class Centre {
public:
  explicit Centre(const TestTime& now, bool has_thread = false)
  : encoder_(0.04, {})
  , centre_(settingsOf(now, has_thread), {}, [this](const auto& frame) { take(frame); })
  {
    EXPECT_TRUE(centre_.settingsStatus().ok());
    centre_.setMerging(true);
  }

  MergingCentre&
  operator*()
  {
    return centre_;
  }

  MergingCentre*
  operator->()
  {
    return &centre_;
  }

  /** \brief A merged frame, as another centre receives it. */
  struct Sent {
    Time time;
    Bytes bytes;
    std::vector<MergedSource> sources;
  };

  std::vector<Sent>
  takeSent()
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    return std::exchange(sent_, {});
  }

  std::map<Time, Voxels> merged;

private:
  static MergingCentreSettings
  settingsOf(const TestTime& now, bool has_thread)
  {
    MergingCentreSettings settings;
    settings.node = centralSettings();
    settings.has_thread = has_thread;
    settings.arrival_clock = [&now] { return now.load(); };
    settings.node.clock = [&now] { return begin + now.load(); };
    settings.schedule.max_age = 500ms;
    settings.node.max_merge_age = 500ms;
    return settings;
  }

  void
  take(const MergedFrame& frame)
  {
    ASSERT_TRUE(frame.status.ok());
    const std::lock_guard<std::mutex> lock(mutex_);
    merged[frame.time] = worldVoxels(frame.voxels);
    Sent sent{frame.time, {}, frame.sources};
    ASSERT_TRUE(encoder_.encode(frame.voxels, frame.time, "world", sent.bytes).ok());
    sent_.push_back(std::move(sent));
  }

  std::mutex mutex_; // guards what it has merged
  std::vector<Sent> sent_;
  MergedFrameEncoder encoder_;
  MergingCentre centre_;
};

/** \brief Six sensors, three zones, a centre above them, and one centre of all sensors. */
class Site {
public:
  Site()
  {
    for (std::size_t zone = 0; zone < zones; ++zone) {
      zones_.push_back(std::make_unique<Centre>(now_));
      EXPECT_TRUE(top_->addStream(zoneOf(zone)).ok());
    }
    for (std::size_t sensor = 0; sensor < sensors; ++sensor) {
      CodedStream::Settings settings;
      settings.seed = 1 + sensor;
      settings.frames = 40;
      streams_.emplace_back(settings);
      EXPECT_TRUE(one_->addStream(nameOf(sensor)).ok());
      EXPECT_TRUE((*zones_[sensor % zones])->addStream(nameOf(sensor)).ok());
      send(sensor);
    }
  }

  static std::string
  zoneOf(std::size_t zone)
  {
    return "/zone_" + std::to_string(zone);
  }

  /** \brief The next frame of a sensor arrives at its centres. */
  void
  send(std::size_t sensor)
  {
    const std::size_t number = sent_[sensor]++;
    const Time stamp = begin + 50ms * number + 3ms * sensor;
    for (Centre* const centre : {&one_, zones_[sensor % zones].get()})
      EXPECT_TRUE((*centre)
                      ->receive(nameOf(sensor), streams_[sensor].frames[number], stamp)
                      .ok());
  }

  /** \brief Time passes: each sensor sends a frame 50 ms after the other, late by up to 90
   * ms; each zone's merged frames arrive above after 20 ms.
   * \param[in] dead sensor that does not; none: sensors
   */
  void
  run(Time duration, std::size_t dead = sensors)
  {
    for (const Time end = now_.load() + duration; now_.load() < end;
         now_ = now_.load() + 5ms) {
      const Time now = now_;
      for (std::size_t sensor = 0; sensor < sensors; ++sensor)
        if (sensor != dead && now >= 50ms * sent_[sensor] + lateness_[sensor]) {
          send(sensor);
          lateness_[sensor] = Time(1ms) * static_cast<int>(random_() % 40);
        }
      for (; !above_.empty() && above_.begin()->first <= now;
           above_.erase(above_.begin())) {
        auto& [zone, frame] = above_.begin()->second;
        top_->setSources(zoneOf(zone), frame.time, frame.sources);
        EXPECT_TRUE(top_->receive(zoneOf(zone), frame.bytes, frame.time).ok());
      }
      one_->work();
      top_->work();
      for (std::size_t zone = 0; zone < zones; ++zone) {
        (*zones_[zone])->work();
        for (auto& frame : zones_[zone]->takeSent())
          above_.emplace(now + 20ms, std::make_pair(zone, std::move(frame)));
      }
    }
  }

  Centre&
  one()
  {
    return one_;
  }

  Centre&
  top()
  {
    return top_;
  }

  Centre&
  zone(std::size_t number)
  {
    return *zones_[number];
  }

private:
  TestTime now_{Time(0)};
  std::mt19937 random_{3};
  std::vector<CodedStream> streams_;
  std::array<std::size_t, sensors> sent_{};
  std::array<Time, sensors> lateness_{};
  std::multimap<Time, std::pair<std::size_t, Centre::Sent>> above_;
  Centre one_{now_};
  Centre top_{now_};
  std::vector<std::unique_ptr<Centre>> zones_;
};

/** \brief The last description of a stream. */
HealthReport
reportOf(Centre& centre, const std::string& name)
{
  for (auto& [stream, report] : centre->describeHealth(0))
    if (stream == name)
      return report;
  ADD_FAILURE() << name;
  return {};
}

TEST(MergingCentre, ZonesAreOneCentreOnMovingScenes)
{
  Site site;
  site.run(1500ms);
  std::size_t compared = 0;
  for (const auto& [time, voxels] : site.top().merged) {
    if (time < begin + 200ms) // until all streams are known everywhere
      continue;
    EXPECT_EQ(voxels, site.one().merged.at(time)) << time.count();
    ++compared;
  }
  EXPECT_GE(compared, 10u);
  // The scenes move.
  EXPECT_NE(site.one().merged.at(begin + 600ms), site.one().merged.at(begin + 700ms));
}

TEST(MergingCentre, KnowsADeadSensorOfACentreBelow)
{
  Site site;
  site.run(400ms);
  EXPECT_EQ(reportOf(site.top(), "/zone_1").message(), "OK");
  site.top().takeSent();
  site.run(1300ms, 4);
  const HealthReport report = reportOf(site.top(), "/zone_1");
  EXPECT_EQ(report.level(), HealthLevel::Warning);
  EXPECT_EQ(report.message(), "Sources are missing: /4");
  EXPECT_EQ(reportOf(site.top(), "/zone_2").message(), "OK");
  EXPECT_EQ(reportOf(site.top(), "all streams").message(), "Not all streams are OK");
  const auto sent = site.top().takeSent();
  ASSERT_FALSE(sent.empty());
  std::vector<std::string> names;
  for (const MergedSource& source : sent.back().sources) {
    names.push_back(source.name);
    EXPECT_EQ(source.stamp.has_value(), source.name != "/zone_1: /4") << source.name;
    if (source.stamp) {
      EXPECT_LE(*source.stamp, sent.back().time);
      EXPECT_GT(*source.stamp, sent.back().time - 200ms);
    }
  }
  EXPECT_EQ(names,
            (std::vector<std::string>{"/zone_0",
                                      "/zone_0: /0",
                                      "/zone_0: /3",
                                      "/zone_1",
                                      "/zone_1: /1",
                                      "/zone_1: /4",
                                      "/zone_2",
                                      "/zone_2: /2",
                                      "/zone_2: /5"}));
}

TEST(MergingCentre, TakesAnySources)
{
  const CodedStream stream({});
  TestTime now{Time(0)};
  Centre centre(now);
  ASSERT_TRUE(centre->addStream("zone").ok());
  const std::vector<MergedSource> many(
      10000, MergedSource{std::string(5000, 'x'), Time::max(), ~std::size_t{0}});
  for (int i = 0; i < 100; ++i)
    centre->setSources("zone", i % 2 == 0 ? Time::max() : Time::min() + Time(i), many);
  centre->setSources("unknown", Time(0), many);
  ASSERT_TRUE(centre->receive("zone", stream.frames[0], begin).ok());
  centre->work();
  const auto sent = centre.takeSent();
  ASSERT_EQ(sent.size(), 1u);
  ASSERT_EQ(sent[0].sources.size(), 1u + 4096u);
  EXPECT_EQ(sent[0].sources[1].name, "zone: " + std::string(1024, 'x'));
  describeMerged(sent[0].sources, begin);
  // The last one counts, whatever its time.
  centre->setSources(
      "zone", begin, std::vector<MergedSource>(7, {"a", std::nullopt, 0}));
  EXPECT_EQ(reportOf(centre, "zone").message(),
            "Sources are missing: a, a, a, a, a and 2 more");
}

TEST(MergingCentre, CountsDroppedFramesWhereTheyWereDropped)
{
  Site site;
  site.run(200ms);
  EXPECT_TRUE(site.zone(0)->receive("/3", Bytes(7), begin + 200ms).ok());
  site.zone(0)->countLeftOut("/0");
  site.run(300ms);
  EXPECT_TRUE(site.top()->receive("/zone_2", Bytes(9), begin + 400ms).ok());
  site.top().takeSent();
  site.run(300ms);
  const auto sent = site.top().takeSent();
  ASSERT_FALSE(sent.empty());
  std::map<std::string, std::size_t> dropped;
  for (const MergedSource& source : sent.back().sources)
    if (source.frames_dropped > 0)
      dropped[source.name] = source.frames_dropped;
  EXPECT_EQ(dropped,
            (std::map<std::string, std::size_t>{
                {"/zone_0: /0", 1}, {"/zone_0: /3", 1}, {"/zone_2", 1}}));
}

TEST(MergingCentre, ForgetsStreamsThatAreRemoved)
{
  const CodedStream stream({});
  TestTime now{Time(0)};
  Centre centre(now);
  for (const char* const name : {"a", "b"}) {
    ASSERT_TRUE(centre->addStream(name).ok());
    ASSERT_TRUE(centre->receive(name, stream.frames[0], begin).ok());
  }
  expectCode(centre->addStream("a"), CentralNodeCode::StreamExists);
  centre->work();
  const Voxels both = centre.merged.at(begin);
  ASSERT_TRUE(centre->removeStream("a").ok());
  expectCode(centre->removeStream("a"), CentralNodeCode::UnknownStream);
  expectCode(centre->receive("a", stream.frames[1], begin),
             CentralNodeCode::UnknownStream);
  now = 100ms;
  ASSERT_TRUE(centre->receive("b", stream.frames[1], begin + 100ms).ok());
  centre->work(); // does not wait for it
  ASSERT_EQ(centre.merged.count(begin + 100ms), 1u);
  EXPECT_EQ(centre.merged.at(begin + 100ms).size(), stream.decoded[1].size());
  EXPECT_EQ(centre->describeHealth(0).size(), 2u); // and all streams
  // It may come back, and begins anew.
  ASSERT_TRUE(centre->addStream("a").ok());
  EXPECT_EQ(reportOf(centre, "a").message(), "No frames have arrived yet");
}

TEST(MergingCentre, HasNoiseOfAllStreamsAndOfOne)
{
  const CodedStream stream({});
  TestTime now{Time(0)};
  Centre centre(now);
  centre->setMerging(false);
  centre->setNoise({{"min_intensity", 2.0}});
  ASSERT_TRUE(centre->addStream("a").ok());
  ASSERT_TRUE(centre->addStream("b").ok());
  centre->setNoise("b", {{"min_intensity", 4.0}});
  const auto kept = [&](const std::string& name, std::size_t number) {
    EXPECT_TRUE(centre->receive(name, stream.frames[number], begin).ok());
    centre->node().waitUntilDecoded();
    VoxelFrame voxels;
    EXPECT_TRUE(centre->node().latestVoxels(name, voxels));
    return voxels.size();
  };
  const auto expected = [&](std::size_t number, float least) {
    std::size_t count = 0;
    pcl_ext::io::forEachVoxelCentre(
        stream.decoded[number],
        [&](float, float, float, float intensity) { count += intensity >= least; });
    return count;
  };
  ASSERT_GT(expected(0, 2.0f), expected(0, 4.0f));
  ASSERT_GT(expected(1, 3.0f), expected(1, 4.0f));
  EXPECT_EQ(kept("a", 0), expected(0, 2.0f));
  EXPECT_EQ(kept("b", 0), expected(0, 4.0f));
  centre->setNoise({{"min_intensity", 3.0}});
  EXPECT_EQ(kept("a", 1), expected(1, 3.0f));
  EXPECT_EQ(kept("b", 1), expected(1, 4.0f));
  centre->setNoise("b", {});
  EXPECT_EQ(kept("b", 2), expected(2, 3.0f));
}

TEST(MergingCentre, DecodesAtOnceWhatNobodyWantsMerged)
{
  const CodedStream stream({});
  TestTime now{Time(0)};
  Centre centre(now);
  ASSERT_TRUE(centre->addStream("a").ok());
  ASSERT_TRUE(centre->addStream("behind").ok());
  ASSERT_TRUE(centre->receive("behind", stream.frames[0], begin).ok());
  for (std::size_t i = 0; i < 4; ++i)
    ASSERT_TRUE(centre->receive("a", stream.frames[i], begin + 100ms * i).ok());
  centre->work();
  centre->node().waitUntilDecoded();
  EXPECT_EQ(centre->node().health()[0].frames_decoded, 2u);
  // What was held back comes first, in its order.
  centre->setMerging(false);
  ASSERT_TRUE(centre->receive("a", stream.frames[4], begin + 400ms).ok());
  centre->node().waitUntilDecoded();
  EXPECT_EQ(centre->node().health()[0].frames_decoded, 5u);
  EXPECT_EQ(centre->node().health()[0].frames_lost, 0u);
}

TEST(MergingCentre, MergesByItself)
{
  const CodedStream stream({});
  TestTime now{Time(0)};
  Centre centre(now, true);
  ASSERT_TRUE(centre->addStream("a").ok());
  ASSERT_TRUE(centre->receive("a", stream.frames[0], begin).ok());
  std::vector<Centre::Sent> sent;
  while (sent.empty()) // ctest ends it
    sent = centre.takeSent();
  EXPECT_EQ(sent[0].time, begin);
}

TEST(MergingCentre, StreamsComeAndGoWhileFramesArrive)
{
  const CodedStream stream = streamOf(30, 5);
  std::atomic<std::size_t> merged{0};
  MergingCentreSettings settings;
  settings.node = centralSettings();
  settings.schedule.period = 10ms;
  MergingCentre centre(settings, {}, [&](const MergedFrame& frame) {
    merged += frame.status.ok() ? 1 : 0;
  });
  centre.setMerging(true);
  ASSERT_TRUE(centre.addStream("stays").ok());
  std::atomic<bool> is_over{false};
  std::vector<std::thread> threads;
  for (const char* const name : {"stays", "a", "b"})
    threads.emplace_back([&, name] {
      for (std::size_t i = 0; merged < 20 || i < stream.frames.size(); ++i) {
        const std::size_t number = i % stream.frames.size();
        centre.receive(name, stream.frames[number], begin + 10ms * i); // or unknown
        std::this_thread::sleep_for(1ms);
      }
    });
  std::thread others([&] {
    while (!is_over)
      for (const char* const name : {"a", "b"}) {
        centre.addStream(name);
        centre.setNoise(name, {{"min_intensity", 2.0}});
        centre.setSources(name, begin, {{"source", begin, 1}});
        centre.describeHealth(0);
        centre.setMerging(false);
        centre.setMerging(true);
        centre.removeStream(name);
      }
  });
  for (std::thread& thread : threads)
    thread.join();
  is_over = true;
  others.join();
  EXPECT_GE(merged, 20u);
}

TEST(MergingCentre, TellsWhichSettingIsWrong)
{
  MergingCentreSettings settings;
  settings.schedule.period = 0ms;
  MergingCentre wrong(settings, {}, {});
  expectCode(wrong.settingsStatus(), CentralNodeCode::InvalidSettings);
  EXPECT_EQ(wrong.settingsStatus().message(),
            "period is 0 ms; it must be 1 ms to 1 hour");
  expectCode(wrong.addStream("a"), CentralNodeCode::InvalidSettings);
  settings.schedule.period = 1s;
  settings.node.resolution = 0.0;
  EXPECT_EQ(MergingCentre(settings, {}, {}).settingsStatus().message(),
            "resolution is 0; it must be 1e-6 to 1e6 metres");
}

TEST(MergedSources, AreReadAsTheyWereDescribed)
{
  const std::vector<MergedSource> sources = {
      {"a", 10s, 0}, {"b: c", 9s, 7}, {"silent", std::nullopt, 3}};
  const auto reports = describeMerged(sources, 10250ms);
  ASSERT_EQ(reports.size(), 4u);
  EXPECT_EQ(reports[0].second.message(), "OK");
  const auto valueOf = [&](std::size_t report, const std::string& key) {
    for (const auto& [known, value] : reports[report].second.values())
      if (known == key)
        return value;
    return std::string("none");
  };
  EXPECT_EQ(valueOf(0, "stamp, ns"), "10000000000");
  EXPECT_EQ(valueOf(0, "age, ms"), "250");
  EXPECT_EQ(valueOf(1, "frames dropped"), "7");
  EXPECT_EQ(reports[2].second.level(), HealthLevel::Stale);
  EXPECT_EQ(reports[2].second.message(), "Not merged: no frame within max_merge_age");
  EXPECT_EQ(reports[3].first, "all streams");
  EXPECT_EQ(valueOf(3, "stamp, ns"), "9000000000");
  EXPECT_EQ(valueOf(3, "age, ms"), "1250");
  std::vector<std::pair<std::string, std::vector<std::pair<std::string, std::string>>>>
      described;
  for (const auto& [name, report] : reports)
    described.emplace_back(name, report.values());
  const auto read = readMergedSources(described);
  ASSERT_EQ(read.size(), sources.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    EXPECT_EQ(read[i].name, sources[i].name);
    EXPECT_EQ(read[i].stamp, sources[i].stamp);
    EXPECT_EQ(read[i].frames_dropped, sources[i].frames_dropped);
  }
  // Of another program.
  const auto other = readMergedSources({{"x", {{"stamp, ns", "1e9"}, {"z", ""}}}});
  ASSERT_EQ(other.size(), 1u);
  EXPECT_FALSE(other[0].stamp);
}

} // namespace merging_centre

} // namespace

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief A site of zones, each with a centre, and one above them; to be run under
 * ThreadSanitizer, too.
 */
#include "support/tested_centre.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <random>
#include <string>

namespace {

namespace centres_of_centres {

using namespace pcl_ext::nodes;
using namespace pcl_ext::nodes::test;
using namespace std::chrono_literals;

constexpr std::size_t sensors = 6;
constexpr std::size_t zones = 3;

std::string
nameOf(std::size_t number)
{
  return "/" + std::to_string(number);
}

/** \brief Six sensors, three zones, a centre above them, and one centre of all sensors.
 */
class Site {
public:
  Site()
  {
    for (std::size_t zone = 0; zone < zones; ++zone) {
      zones_.push_back(std::make_unique<TestedCentre>(now_));
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
    const Time stamp = first_stamp + 50ms * number + 3ms * sensor;
    for (TestedCentre* const centre : {&one_, zones_[sensor % zones].get()})
      EXPECT_TRUE((*centre)
                      ->receive(nameOf(sensor), streams_[sensor].frames[number], stamp)
                      .ok());
  }

  /** \brief Time passes: each sensor sends a frame 50 ms after the other, late by up to
   * 90 ms; each zone's merged frames arrive above after 20 ms.
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

  TestedCentre&
  one()
  {
    return one_;
  }

  TestedCentre&
  top()
  {
    return top_;
  }

  TestedCentre&
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
  std::multimap<Time, std::pair<std::size_t, TestedCentre::Sent>> above_;
  TestedCentre one_{now_};
  TestedCentre top_{now_, false, 500ms}; // longer than its zones, see doc/site.md
  std::vector<std::unique_ptr<TestedCentre>> zones_;
};

/** \brief Expects that the top has merged what one centre has, of some times.
 * \return how many frames were compared */
std::size_t
compareTopWithOne(Site& site, Time from, Time to)
{
  std::size_t compared = 0;
  for (const auto& [time, voxels] : site.top().merged) {
    if (time < first_stamp + from || time >= first_stamp + to)
      continue;
    EXPECT_EQ(voxels, site.one().merged.at(time)) << time.count();
    ++compared;
  }
  return compared;
}

constexpr Time all_known = 200ms; // by then all streams are, everywhere

TEST(CentresOfCentres, ZonesAreOneCentreAndTellOfADeadSensor)
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
  site.run(300ms, 4);
  EXPECT_GE(compareTopWithOne(site, all_known, 800ms), 6u);
  // The scenes move.
  EXPECT_NE(site.one().merged.at(first_stamp + 600ms),
            site.one().merged.at(first_stamp + 700ms));
  // When its last frame is too old depends on when that was decoded.
  EXPECT_GE(compareTopWithOne(site, 1200ms, 2000ms), 6u);
}

TEST(CentresOfCentres, CountsDroppedFramesWhereTheyWereDropped)
{
  Site site;
  site.run(200ms);
  EXPECT_TRUE(site.zone(0)->receive("/3", Bytes(7), first_stamp + 200ms).ok());
  site.zone(0)->countLeftOut("/0");
  site.run(300ms);
  EXPECT_TRUE(site.top()->receive("/zone_2", Bytes(9), first_stamp + 400ms).ok());
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

TEST(CentresOfCentres, TakesAnySources)
{
  const CodedStream stream({});
  TestTime now{Time(0)};
  TestedCentre centre(now);
  ASSERT_TRUE(centre->addStream("zone").ok());
  const std::vector<MergedSource> many(
      4100, MergedSource{std::string(1100, 'x'), Time::max(), ~std::size_t{0}});
  for (int i = 0; i < 20; ++i)
    centre->setSources("zone", i % 2 == 0 ? Time::max() : Time::min() + Time(i), many);
  centre->setSources("unknown", Time(0), many);
  ASSERT_TRUE(centre->receive("zone", stream.frames[0], first_stamp).ok());
  centre->work();
  const auto sent = centre.takeSent();
  ASSERT_EQ(sent.size(), 1u);
  ASSERT_EQ(sent[0].sources.size(), 1u + 4096u);
  EXPECT_EQ(sent[0].sources[1].name, "zone: " + std::string(1024, 'x'));
  describeMerged(sent[0].sources, first_stamp);
  // The last one counts, whatever its time.
  centre->setSources(
      "zone", first_stamp, std::vector<MergedSource>(7, {"a", std::nullopt, 0}));
  EXPECT_EQ(reportOf(centre, "zone").message(),
            "Sources are missing: a, a, a, a, a and 2 more");
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

} // namespace centres_of_centres

} // namespace

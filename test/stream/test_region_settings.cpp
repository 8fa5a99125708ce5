#include <pcl_ext/compression/compression_settings.h>

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace {

using namespace pcl_ext::io;

EncoderSettings
validSettings()
{
  EncoderSettings settings;
  settings.resolution = 0.05;
  settings.regions.boxes = {{{{-1.0, -1.0, 0.0}, {1.0, 1.0, 2.0}}, 0},
                            {{{-3.0, -3.0, 0.0}, {3.0, 3.0, 3.0}}, 2}};
  return settings;
}

TEST(RegionSettings, MessagesNameTheValueAndTheRemedy)
{
  using Change = std::function<void(EncoderSettings&)>;
  const std::vector<std::pair<Change, std::string>> refused = {
      {[](auto& s) { s.regions.boxes[1].box.min[2] = 3.0; },
       "region 2 is 3.000000 to 3.000000; it must be finite, with min below max on "
       "each "
       "axis"},
      {[](auto& s) {
         s.regions.boxes[0].box.max[0] = std::numeric_limits<double>::infinity();
       },
       "region 1 is -1.000000 to inf; it must be finite, with min below max on each "
       "axis"},
      {[](auto& s) { s.regions.boxes[0].box.max[2] = 0.04; },
       "region 1 is 0.040000 m wide; it must be at least as wide as the resolution on "
       "each axis"},
      {[](auto& s) { s.regions.boxes[1].doublings = 6; },
       "region 2: doublings is 6; it must be 0 to 5"},
      {[](auto& s) { s.regions.boxes[0].frame = static_cast<RegionFrame>(2); },
       "region 1: frame is 2; it must be World or Sensor"},
      {[](auto& s) { s.regions.boxes.resize(65, s.regions.boxes[0]); },
       "number of regions is 65; it must be 64 at most"},
      {[](auto& s) { s.regions.coarser_beyond = 0.04; },
       "coarser_beyond is 0.04; it must be 0 for off, or metres from the resolution to "
       "2^22 times it"},
      {[](auto& s) {
         s.regions.coarser_beyond = std::numeric_limits<double>::quiet_NaN();
       },
       "coarser_beyond is nan; it must be 0 for off, or metres from the resolution to "
       "2^22 times it"},
      {[](auto& s) { s.regions.coarser_beyond = 0.05 * (1 << 22) + 0.01; },
       "coarser_beyond is 209715; it must be 0 for off, or metres from the resolution "
       "to 2^22 times it"},
      {[](auto& s) {
         s.regions.coarser_beyond = 10.0;
         s.regions.most_doublings = 0;
       },
       "most_doublings is 0; it must be 1 to 5"},
      {[](auto& s) {
         s.regions.coarser_beyond = 10.0;
         s.regions.most_doublings = 6;
       },
       "most_doublings is 6; it must be 1 to 5"},
      {[](auto& s) { s.regions.outside = static_cast<OutsideRegions>(2); },
       "outside of regions is 2; it must be Coarsest or LeftOut"},
      {[](auto& s) {
         s.regions.boxes.clear();
         s.regions.outside = OutsideRegions::LeftOut;
       },
       "outside of regions is left-out; it must be coarsest without a region"},
      {[](auto& s) {
         s.regions.coarser_beyond = 10.0;
         s.regions.outside = OutsideRegions::LeftOut;
       },
       "outside of regions is left-out; it must be coarsest with coarser_beyond"},
      {[](auto& s) { s.format = StreamFormat::Published; },
       "regions is set; it must be empty in the published layout"},
      {[](auto& s) { s.keep_point_counts = true; },
       "keep_point_counts is on; it must be off with regions"},
      {[](auto& s) { s.fields = {{"ring"}}; },
       "fields is set; it must be empty with regions"}};
  for (const auto& [change, message] : refused) {
    EncoderSettings settings = validSettings();
    change(settings);
    const CompressionStatus status = checkSettings(settings);
    EXPECT_EQ(status.code(), CompressionCode::InvalidSettings);
    EXPECT_EQ(status.message(), message);
  }
}

TEST(RegionSettings, LimitsAreAccepted)
{
  using Change = std::function<void(EncoderSettings&)>;
  const std::vector<Change> accepted = {
      [](auto&) {},
      [](auto& s) { s.regions.outside = OutsideRegions::LeftOut; },
      [](auto& s) { s.regions.boxes.resize(64, s.regions.boxes[0]); },
      [](auto& s) { s.regions.boxes[0].doublings = 5; },
      [](auto& s) {
        s.regions.boxes[0].box = {{-1e300, -1.0, 0.0}, {1e300, 1.0, 1.0}};
      },
      [](auto& s) { s.regions.coarser_beyond = 0.05; },
      [](auto& s) { s.regions.coarser_beyond = 0.05 * (1 << 22); },
      [](auto& s) {
        s.regions = {};
        s.regions.coarser_beyond = 10.0;
        s.regions.most_doublings = 5;
      }};
  for (const Change& change : accepted) {
    EncoderSettings settings = validSettings();
    change(settings);
    const CompressionStatus status = checkSettings(settings);
    EXPECT_TRUE(status.ok()) << status.message();
  }
}

} // namespace

#include "support/outlier_frames.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace {

using namespace pcl_ext;

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();

/** \brief Settings that are refused, and why. */
std::vector<std::pair<VoxelOutlierRemovalSettings, std::string>>
refusedSettings()
{
  std::vector<std::pair<VoxelOutlierRemovalSettings, std::string>> refused;
  for (const auto& [number, text] : {std::pair(infinity, "inf"),
                                     std::pair(-infinity, "-inf"),
                                     std::pair(not_a_number, "nan")}) {
    VoxelOutlierRemovalSettings settings;
    settings.min_log_odds = number;
    refused.emplace_back(settings,
                         std::string("min_log_odds is ") + text +
                             "; it must be a finite number");
  }
  for (const auto& [number, text] : {std::pair(0.0f, "0.000000"),
                                     std::pair(-1.0f, "-1.000000"),
                                     std::pair(infinity, "inf"),
                                     std::pair(not_a_number, "nan")}) {
    VoxelOutlierRemovalSettings settings;
    settings.full_intensity = number;
    refused.emplace_back(settings,
                         std::string("full_intensity is ") + text +
                             "; it must be a finite number above 0");
  }
  VoxelOutlierRemovalSettings settings;
  settings.unit = static_cast<DensityUnit>(7);
  refused.emplace_back(settings, "unit is 7; it must be Automatic, Faces or Points");
  return refused;
}

TEST(VoxelOutlierRemovalSettings, OutOfRangeIsRefused)
{
  for (const auto& [settings, message] : refusedSettings()) {
    const OutlierRemovalStatus status = checkSettings(settings);
    EXPECT_EQ(status.code(), OutlierRemovalCode::InvalidSettings);
    EXPECT_EQ(status.message(), message);
  }
}

TEST(VoxelOutlierRemovalSettings, EndsOfTheRangesAreValid)
{
  VoxelOutlierRemovalSettings settings;
  EXPECT_TRUE(checkSettings(settings).ok());
  settings.use_history = false;
  settings.max_blocks = 0;
  for (const float number :
       {std::numeric_limits<float>::lowest(), -1.0f, std::numeric_limits<float>::max()})
    for (const float full :
         {std::numeric_limits<float>::denorm_min(), std::numeric_limits<float>::max()})
      for (const DensityUnit unit :
           {DensityUnit::Automatic, DensityUnit::Faces, DensityUnit::Points}) {
        settings.min_log_odds = number;
        settings.full_intensity = full;
        settings.unit = unit;
        EXPECT_TRUE(checkSettings(settings).ok());
        EXPECT_EQ(checkSettings(settings).message(), "");
      }
}

TEST(VoxelOutlierRemovalSettings, UnsupportedVoxelEdgesRemoveNothing)
{
  std::mt19937_64 random(16);
  io::VoxelFrame frame = frameOf(wall(random, 15), gridAt(0, 0, 0));
  // At the ends less than a millionth is rounding.
  for (const auto& [edge, is_made_for] : {std::pair(0.001, false),
                                          std::pair(0.01999, false),
                                          std::pair(0.019999999, true),
                                          std::pair(0.02, true),
                                          std::pair(0.2, true),
                                          std::pair(0.20000001, true),
                                          std::pair(0.2001, false),
                                          std::pair(1e6, false)}) {
    SCOPED_TRACE(edge);
    EXPECT_EQ(VoxelOutlierRemoval::isMadeFor(edge), is_made_for);
    frame.grid.resolution = edge;
    VoxelOutlierRemovalSettings settings;
    settings.min_log_odds = 1000.0f;
    VoxelOutlierRemoval removal(settings);
    io::VoxelFrame filtered = frame;
    EXPECT_EQ(removal.filter(filtered), is_made_for ? frame.size() : 0u);
    EXPECT_EQ(filtered.size(), is_made_for ? 0u : frame.size());
    std::vector<float> log_odds;
    removal.score(frame, log_odds);
    for (const float score : log_odds)
      EXPECT_EQ(score == infinity, !is_made_for);
    EXPECT_EQ(removal.rememberedBlocks() == 0, !is_made_for);
  }
}

TEST(VoxelOutlierRemovalSettings, InvalidSettingsRemoveNothing)
{
  std::mt19937_64 random(15);
  const io::VoxelFrame frame = frameOf(wall(random, 15), gridAt(0, 0, 0));
  for (const auto& [settings, message] : refusedSettings()) {
    VoxelOutlierRemoval removal(settings);
    for (int i = 0; i < 2; ++i) {
      io::VoxelFrame filtered = frame;
      EXPECT_EQ(removal.filter(filtered), 0u);
      EXPECT_EQ(filtered.keys, frame.keys);
      EXPECT_EQ(filtered.intensities, frame.intensities);
      std::vector<float> log_odds = {1.0f};
      removal.score(frame, log_odds);
      EXPECT_EQ(log_odds, std::vector<float>(frame.size(), infinity));
      EXPECT_EQ(removal.rememberedBlocks(), 0u);
    }
  }
}

} // namespace

/** \file
 * \brief What the nodes tell about their health. Times are not what is tested here, so
 * that limits are wide.
 */
#include "diagnostics.h"
#include "stream_scenario.h"

namespace pcl_ext_ros {
namespace test {

namespace {

using diagnostic_msgs::DiagnosticStatus;

class Health : public StreamScenario {
protected:
  Health() : of_compressor(full("compressor")), of_decompressor(full("decompressor")) {}

  /** \brief Sends some ten clouds a second, with stamps of now, until a node tells of so
   * many frames. */
  void
  sendUntil(const Diagnostics& diagnostics, const std::string& key, double count)
  {
    std::uint32_t number = 0;
    EXPECT_TRUE(waitFor([&] {
      sensor_msgs::PointCloud2 sent = cloud(number++ % 4);
      sent.header.stamp = ros::Time::now();
      show(sent);
      ros::WallDuration(0.08).sleep();
      return diagnostics.value(key).value_or(0.0) >= count;
    })) << diagnostics.text();
  }

  /** \brief Expects a value within limits, both included. */
  static void
  expectWithin(const Diagnostics& diagnostics,
               const std::string& key,
               double lowest,
               double highest)
  {
    const std::optional<double> value = diagnostics.value(key);
    ASSERT_TRUE(value) << key << " is missing\n" << diagnostics.text();
    EXPECT_GE(*value, lowest) << key;
    EXPECT_LE(*value, highest) << key;
  }

  /** \brief What both nodes tell of a stream of some ten frames a second. */
  void
  expectPlausibleRates(const Diagnostics& diagnostics) const
  {
    const double bytes = static_cast<double>(frames.last()->compressed_data.size());
    expectWithin(diagnostics, "frames per second", 1.0, 13.0);
    const double rate = diagnostics.value("frames per second").value_or(0.0);
    expectWithin(diagnostics, "bytes per second", 0.3 * rate * bytes, 3 * rate * bytes);
    expectWithin(diagnostics, "mean cycle time, ms", 0.01, 500.0);
    const double mean = diagnostics.value("mean cycle time, ms").value_or(0.0);
    expectWithin(diagnostics, "max cycle time, ms", mean, 1000.0);
    expectWithin(diagnostics, "mean latency, ms", 0.1, 2000.0);
    const double latency = diagnostics.value("mean latency, ms").value_or(0.0);
    expectWithin(diagnostics, "max latency, ms", latency, 5000.0);
    const double voxels_now = static_cast<double>(frames.last()->width);
    expectWithin(diagnostics, "voxels", 0.9 * voxels_now, 1.1 * voxels_now);
  }

  const Diagnostics of_compressor;
  const Diagnostics of_decompressor;
};

TEST_F(Health, CompressorTellsRatesAndRatio)
{
  startBoth();
  sendUntil(of_compressor, "frames", 35);
  expectPlausibleRates(of_compressor);
  const double cloud_bytes = static_cast<double>(cloud(0).data.size());
  const double frame_bytes = static_cast<double>(frames.last()->compressed_data.size());
  const double ratio = cloud_bytes / frame_bytes;
  expectWithin(of_compressor, "compression ratio", 0.3 * ratio, 3 * ratio);
  expectWithin(of_compressor, "bytes per voxel", 0.01, 5.0);
  EXPECT_EQ(of_compressor.value("clouds"), of_compressor.value("frames"));
  EXPECT_EQ(of_compressor.value("points"), 6000);
  EXPECT_EQ(of_compressor.value("points not finite"), 6000 / 97);
  EXPECT_EQ(of_compressor.value("clouds refused"), 0);
  EXPECT_EQ(of_compressor.value("clouds without transform"), 0);
  EXPECT_EQ(of_compressor.entries().back().level, DiagnosticStatus::OK)
      << of_compressor.text();
}

TEST_F(Health, DecompressorTellsRatesAndLosses)
{
  startBoth();
  sendUntil(of_decompressor, "frames decoded", 35);
  expectPlausibleRates(of_decompressor);
  expectWithin(of_decompressor, "compression ratio", 3.0, 1000.0);
  EXPECT_EQ(of_decompressor.value("frames received"),
            of_decompressor.value("frames decoded"));
  for (const char* const key : {"frames failed",
                                "frames dropped",
                                "frames refused",
                                "frames lost",
                                "I-frame requests"})
    EXPECT_EQ(of_decompressor.value(key), 0) << key;
  EXPECT_EQ(of_decompressor.value("kept voxels"), of_decompressor.value("voxels"));
  EXPECT_EQ(of_decompressor.entries().back().level, DiagnosticStatus::OK)
      << of_decompressor.text();
  const Diagnostics of_all(full("decompressor"), "all streams");
  EXPECT_TRUE(of_all.waitForValue("streams", 1));
  EXPECT_EQ(of_all.value("streams in sync"), 1);
}

TEST_F(Health, ReportsComeAboutOnceASecondAndTellOfSilence)
{
  startBoth();
  EXPECT_TRUE(of_compressor.waitForLevel(DiagnosticStatus::STALE));
  EXPECT_TRUE(of_decompressor.waitForLevel(DiagnosticStatus::STALE));
  ASSERT_TRUE(show(cloud(0)));
  const ros::WallTime start = ros::WallTime::now();
  const std::size_t before = of_compressor.entries().size();
  EXPECT_TRUE(of_compressor.waitForLevel(DiagnosticStatus::ERROR));
  EXPECT_TRUE(of_decompressor.waitForLevel(DiagnosticStatus::ERROR));
  const double seconds = (ros::WallTime::now() - start).toSec();
  const double reports = static_cast<double>(of_compressor.entries().size() - before);
  EXPECT_GE(reports, 2.0);
  EXPECT_LE(reports, 2.0 * seconds + 2.0);
  // And it is over when clouds arrive again.
  sendUntil(of_compressor, "frames", 5);
  EXPECT_TRUE(waitFor(
      [&] { return of_compressor.entries().back().level == DiagnosticStatus::OK; }));
}

} // namespace

} // namespace test
} // namespace pcl_ext_ros

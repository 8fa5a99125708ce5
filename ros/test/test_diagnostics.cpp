/** \file
 * \brief The reports of the nodes on /diagnostics. Limits of times are wide, as they
 * depend on the computer.
 */
#include "stream_scenario.h"

namespace pcl_ext_ros1 {
namespace test {

namespace {

class Health : public StreamScenario {
protected:
  /** \brief Publishes about ten clouds a second, stamped with the time now, until a
   * value is reached. */
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

  /** \brief Expects a value within [lowest, highest]. */
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

  /** \brief Expects the values of a stream of about ten frames a second. */
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
};

TEST_F(Health, CompressorReportsRatesAndRatio)
{
  startBoth();
  sendUntil(compressor_health, "frames", 35);
  expectPlausibleRates(compressor_health);
  const double cloud_bytes = static_cast<double>(cloud(0).data.size());
  const double frame_bytes = static_cast<double>(frames.last()->compressed_data.size());
  const double ratio = cloud_bytes / frame_bytes;
  expectWithin(compressor_health, "compression ratio", 0.3 * ratio, 3 * ratio);
  expectWithin(compressor_health, "bytes per voxel", 0.01, 5.0);
  EXPECT_EQ(compressor_health.value("clouds"), compressor_health.value("frames"));
  EXPECT_EQ(compressor_health.value("points"), 6000);
  EXPECT_EQ(compressor_health.value("points not finite"), 6000 / 97);
  EXPECT_EQ(compressor_health.value("clouds refused"), 0);
  EXPECT_EQ(compressor_health.value("clouds without transform"), 0);
  EXPECT_EQ(compressor_health.entries().back().level, DiagnosticStatus::OK)
      << compressor_health.text();
}

TEST_F(Health, DecompressorReportsRatesAndLosses)
{
  startBoth();
  sendUntil(decompressor_health, "frames decoded", 35);
  expectPlausibleRates(decompressor_health);
  expectWithin(decompressor_health, "compression ratio", 3.0, 1000.0);
  EXPECT_EQ(decompressor_health.value("frames received"),
            decompressor_health.value("frames decoded"));
  for (const char* const key : {"frames failed",
                                "frames dropped",
                                "frames refused",
                                "frames lost",
                                "I-frame requests"})
    EXPECT_EQ(decompressor_health.value(key), 0) << key;
  EXPECT_EQ(decompressor_health.value("kept voxels"),
            decompressor_health.value("voxels"));
  EXPECT_EQ(decompressor_health.entries().back().level, DiagnosticStatus::OK)
      << decompressor_health.text();
  const Diagnostics of_all(full("decompressor"), "all streams");
  of_all.expectValue("streams", 1);
  EXPECT_EQ(of_all.value("streams in sync"), 1);
}

TEST_F(Health, ReportsComeOnceASecondAndShowSilence)
{
  startBoth();
  compressor_health.expectLevel(DiagnosticStatus::STALE);
  decompressor_health.expectLevel(DiagnosticStatus::STALE);
  ASSERT_TRUE(show(cloud(0)));
  const ros::WallTime start = ros::WallTime::now();
  const std::size_t before = compressor_health.entries().size();
  compressor_health.expectLevel(DiagnosticStatus::ERROR);
  decompressor_health.expectLevel(DiagnosticStatus::ERROR);
  const double seconds = (ros::WallTime::now() - start).toSec();
  const double reports =
      static_cast<double>(compressor_health.entries().size() - before);
  EXPECT_GE(reports, 2.0);
  EXPECT_LE(reports, 2.0 * seconds + 2.0);
  // The level is OK again when clouds arrive.
  sendUntil(compressor_health, "frames", 5);
  EXPECT_TRUE(waitFor([&] {
    return compressor_health.entries().back().level == DiagnosticStatus::OK;
  }));
}

} // namespace

} // namespace test
} // namespace pcl_ext_ros1

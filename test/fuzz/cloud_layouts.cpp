/** \file
 * Fuzz target: SensorPreprocessor on any PCLPointCloud2 does what its header says, which a
 * reference does once more, one point and one field at a time: the same points, or a refusal
 * for a reason that is there; and no byte outside the cloud's data is read.
 *
 * The input describes a valid layout, then changes of it, then the bytes of the points.
 */
#include <pcl_ext/filters/sensor_preprocessor.h>
#include <pcl_ext/intensity/intensity_model.h>
#include <pcl_ext/point_types.h>

#include "cloud_message.h"
#include "cloud_reference.h"
#include "fuzz_input.h"

#include <pcl/PCLPointCloud2.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace {

using namespace pcl_ext;
using namespace pcl_ext::fuzz;

using Output = pcl::PointCloud<PointXYZRGBI>;
using QuadraticIntensity = IntensityModel<KinectV2, QuadraticLaw>;

constexpr double resolution = 0.04;

template <typename ModelT>
void
requireSamePoints(const pcl::PCLPointCloud2& cloud,
                  const Fields& fields,
                  const PreprocessorSettings& settings,
                  const ModelT& model,
                  const Output& output,
                  const PreprocessingStatistics& statistics)
{
  std::size_t kept = 0;
  std::size_t not_finite = 0;
  // Rows without points may be billions.
  const std::size_t rows = cloud.width == 0 ? 0 : cloud.height;
  for (std::size_t row = 0; row < rows; ++row)
    for (std::size_t column = 0; column < cloud.width; ++column) {
      const std::uint8_t* const point =
          cloud.data.data() + row * cloud.row_step + column * cloud.point_step;
      std::array<float, 3> place{};
      std::array<float, 3> moved{};
      for (std::size_t axis = 0; axis < 3; ++axis)
        place[axis] = readField(point, *fields[axis]);
      bool is_finite = true;
      bool is_within = true;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        moved[axis] = settings.pose.sign[axis] * place[settings.pose.source[axis]] +
                      settings.pose.translation[axis];
        is_finite =
            is_finite && std::isfinite(place[axis]) && std::isfinite(moved[axis]);
        if (settings.crop_box)
          is_within = is_within && moved[axis] >= (*settings.crop_box)[0][axis] &&
                      moved[axis] <= (*settings.crop_box)[1][axis];
      }
      not_finite += is_finite ? 0 : 1;
      if (!is_finite || !is_within)
        continue;
      require(kept < output.size());
      const PointXYZRGBI& result = output[kept++];
      require(result.x == moved[0] && result.y == moved[1] && result.z == moved[2]);
      const float native = fields[3] != nullptr ? readField(point, *fields[3]) : 0.0f;
      require(isNear(result.intensity,
                     expectedIntensity(model, place[2], native),
                     settings.scale));
      const std::uint32_t colour =
          fields[4] != nullptr ? numberAt<std::uint32_t>(point + fields[4]->offset)
                               : 0xff000000u;
      require(result.rgba == colour);
    }
  require(output.size() == kept && output.width == kept && output.height == 1);
  const std::size_t points = std::size_t{cloud.width} * cloud.height;
  require(statistics.points == points);
  require(statistics.points_not_finite == not_finite);
  require(statistics.points_cropped == points - kept - not_finite);
  require(output.is_dense && output.header.frame_id == cloud.header.frame_id &&
          output.header.stamp == cloud.header.stamp);
}

template <typename ModelT>
void
requireSame(const pcl::PCLPointCloud2& cloud, const PreprocessorSettings& settings)
{
  const ModelT model(resolution);
  SensorPreprocessor<ModelT, PointXYZRGBI> preprocessor(model);
  preprocessor.setReadsColours(settings.reads_colours);
  preprocessor.setIntensityField(settings.intensity_field);
  preprocessor.setIntensityScale(settings.scale);
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear().setZero();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto row = static_cast<Eigen::Index>(axis);
    pose.linear()(row, static_cast<Eigen::Index>(settings.pose.source[axis])) =
        static_cast<double>(settings.pose.sign[axis]);
    pose.translation()[row] = static_cast<double>(settings.pose.translation[axis]);
  }
  preprocessor.setSensorPose(pose);
  if (settings.crop_box) {
    const auto& [min, max] = *settings.crop_box;
    preprocessor.setCropBox(Eigen::Vector3f(min.data()), Eigen::Vector3f(max.data()));
  }
  Output output;
  output.resize(3); // of an earlier call
  const PreprocessingStatus status = preprocessor.process(cloud, output);

  Fields fields;
  const Faults faults = findFaults(cloud,
                                   settings.intensity_field,
                                   ModelT::uses_native,
                                   settings.reads_colours,
                                   fields);
  if (status.ok()) {
    require(settings.areValid() && faults.empty());
    requireSamePoints(
        cloud, fields, settings, model, output, preprocessor.getStatistics());
    return;
  }
  require(!status.message().empty());
  require(output.empty() && output.width == 0);
  require(preprocessor.getStatistics().points == 0);
  require(status.code() == PreprocessingCode::InvalidSettings
              ? !settings.areValid()
              : faults.count(status.code()) == 1);
}

} // namespace

extern "C" int
LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  FuzzInput input(data, size);
  const std::uint8_t choices = input.byte();
  const PreprocessorSettings settings = settingsOf(input);
  pcl::PCLPointCloud2 cloud = layoutOf(input);
  for (int changes = choices / 4 % 4; changes > 0; --changes)
    falsify(cloud, input);
  fillData(cloud, input);
  // Ends where the memory ends, so that a sanitizer sees the first byte too many.
  cloud.data.shrink_to_fit();
  switch (choices % 4) {
  case 0:
    requireSame<CountIntensity>(cloud, settings);
    break;
  case 1:
    requireSame<QuadraticIntensity>(cloud, settings);
    break;
  default:
    requireSame<NativeIntensity>(cloud, settings);
  }
  return 0;
}

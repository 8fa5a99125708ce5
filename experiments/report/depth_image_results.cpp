#include "depth_image_results.h"

#include "coding_costs.h"
#include "depth_image_coders.h"
#include "measuring/samples.h"

#include <pcl/conversions.h>

#include <cmath>

namespace pcl_ext {
namespace report {

namespace {

using measuring::MeanAndDeviation;
using measuring::timeOf;

constexpr double wrong_mm = 100.0;

/** \brief How far a decoded image is from what was encoded. */
struct DepthErrors {
  double root_mean_square_mm = 0.0;
  double wrong_percent = 0.0;
};

DepthErrors
errorsOf(const DepthImage& before, const DepthImage& after)
{
  double squares = 0.0;
  double both = 0.0;
  double either = 0.0;
  double wrong = 0.0;
  for (std::size_t i = 0; i < before.depth.size(); ++i) {
    const bool was = before.depth[i] != 0;
    const bool is = after.depth[i] != 0;
    const double error = static_cast<double>(after.depth[i]) - before.depth[i];
    either += was || is ? 1.0 : 0.0;
    both += was && is ? 1.0 : 0.0;
    squares += was && is ? error * error : 0.0;
    wrong += was != is || std::abs(error) > wrong_mm ? 1.0 : 0.0;
  }
  if (both == 0.0)
    return {};
  return {std::sqrt(squares / both), 100.0 * wrong / either};
}

/** \brief One coder at work on the images of a stream. */
class ImageRun {
public:
  ImageRun(std::unique_ptr<DepthImageCoder> coder,
           const std::string& suffix,
           double frame_rate)
  : coder_(std::move(coder)), suffix_(suffix), costs_(frame_rate)
  {}

  void
  code(const DepthImage& image, double cropped_points)
  {
    const double encode_ms = timeOf([&] { coder_->encode(image, bytes_); });
    decoded_.columns = image.columns;
    decoded_.rows = image.rows;
    const double decode_ms = timeOf([&] { coder_->decode(bytes_, decoded_); });
    costs_.add(bytes_.size(), cropped_points, encode_ms, decode_ms);
    const DepthErrors errors = errorsOf(image, decoded_);
    error_mm_.add(errors.root_mean_square_mm);
    wrong_percent_.add(errors.wrong_percent);
  }

  void
  write(const std::string& sensor, ResultFile& results) const
  {
    const Subject subject{"depth_image", sensor, coder_->name() + suffix_, 0.0};
    costs_.write(subject, results);
    results.add(subject, "error_mm", error_mm_);
    results.add(subject, "wrong_percent", wrong_percent_);
  }

private:
  std::unique_ptr<DepthImageCoder> coder_;
  std::string suffix_;
  std::vector<std::uint8_t> bytes_;
  DepthImage decoded_;

  CodingCosts costs_;
  MeanAndDeviation error_mm_;
  MeanAndDeviation wrong_percent_;
};

std::vector<ImageRun>
makeRuns(const std::string& suffix, double frame_rate)
{
  // Just beyond the farthest wall that a sensor of the cell sees.
  constexpr unsigned int farthest_mm = 13000;
  std::vector<ImageRun> runs;
  runs.emplace_back(makePngCoder(/* fast */ false), suffix, frame_rate);
  runs.emplace_back(makePngCoder(/* fast */ true), suffix, frame_rate);
  for (const int quality : {95, 80})
    runs.emplace_back(makeJpegCoder(quality, farthest_mm), suffix, frame_rate);
  return runs;
}

/** \brief Forgets the pixels outside of the crop box.
 * \return how many pixels are left with a return
 */
double
cropImage(const pcl::PCLPointCloud2& cloud,
          const measuring::InputStream& stream,
          DepthImage& image)
{
  pcl::PointCloud<pcl::PointXYZ> points;
  pcl::fromPCLPointCloud2(cloud, points);
  const Eigen::Isometry3d to_world = stream.clouds->sensorPose();
  const Eigen::Map<const Eigen::Array3d> min(stream.crop_box->min.data());
  const Eigen::Map<const Eigen::Array3d> max(stream.crop_box->max.data());
  double left = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d moved = to_world * points[i].getVector3fMap().cast<double>();
    const bool is_inside = (moved.array() >= min).all() && (moved.array() <= max).all();
    if (is_inside) // never true of NaN
      left += 1.0;
    else
      image.depth[i] = 0;
  }
  return left;
}

} // namespace

void
measureDepthImages(const measuring::InputStream& stream,
                   double frame_rate,
                   ResultFile& results)
{
  std::vector<ImageRun> whole = makeRuns("", frame_rate);
  std::vector<ImageRun> cropped = makeRuns(" cropped", frame_rate);
  pcl::PCLPointCloud2 cloud;
  for (std::size_t i = 0; i < stream.clouds->size(); ++i) {
    stream.clouds->read(i, cloud);
    const DepthImage image = depthImageOf(cloud);
    DepthImage cropped_image = image;
    const double cropped_points = cropImage(cloud, stream, cropped_image);
    for (ImageRun& run : whole)
      run.code(image, cropped_points);
    for (ImageRun& run : cropped)
      run.code(cropped_image, cropped_points);
  }
  for (const std::vector<ImageRun>* runs : {&whole, &cropped})
    for (const ImageRun& run : *runs)
      run.write("1", results);
}

} // namespace report
} // namespace pcl_ext

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "depth_images.h"

#include "clouds/cloud_sequence.h"
#include "measuring/results.h"
#include "measuring/samples.h"

#include <pcl/conversions.h>

#include <png.h>
#include <turbojpeg.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace pcl_ext {
namespace paper {

namespace {

using measuring::Samples;
using measuring::timeOf;
using Bytes = std::vector<std::uint8_t>;

constexpr double wrong_mm = 100.0;
/** \brief Just beyond the farthest wall that a sensor of the cell sees. */
constexpr double farthest_mm = 13000.0;
constexpr double jpeg_step_mm = farthest_mm / 255.0;

/** \brief The output of a depth camera's driver: millimetres, 0 without a return. */
struct DepthImage {
  std::size_t columns = 0;
  std::size_t rows = 0;
  std::vector<std::uint16_t> depth; ///< row by row
};

/** \brief Encodes depth images as files in memory, and decodes them into an image of
 * the same size. */
struct ImageCoder {
  std::string name;
  void (*encode)(const DepthImage&, Bytes&);
  void (*decode)(const Bytes&, DepthImage&);
};

void
copyRaw(const DepthImage& image, Bytes& bytes)
{
  bytes.resize(2 * image.depth.size());
  std::memcpy(bytes.data(), image.depth.data(), bytes.size());
}

void
readRaw(const Bytes& bytes, DepthImage& image)
{
  std::memcpy(image.depth.data(), bytes.data(), bytes.size());
}

void
checkPng(int result, const png_image& file)
{
  if (result == 0)
    throw std::runtime_error(std::string("libpng: ") + file.message);
}

void
writePng(const DepthImage& image, png_uint_32 flags, Bytes& bytes)
{
  png_image file{};
  file.version = PNG_IMAGE_VERSION;
  file.width = static_cast<png_uint_32>(image.columns);
  file.height = static_cast<png_uint_32>(image.rows);
  // 16 bits of grey, stored unchanged.
  file.format = PNG_FORMAT_LINEAR_Y;
  file.flags = flags;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(file);
  bytes.resize(size);
  checkPng(png_image_write_to_memory(
               &file, bytes.data(), &size, 0, image.depth.data(), 0, nullptr),
           file);
  bytes.resize(size);
}

void
readPng(const Bytes& bytes, DepthImage& image)
{
  png_image file{};
  file.version = PNG_IMAGE_VERSION;
  checkPng(png_image_begin_read_from_memory(&file, bytes.data(), bytes.size()), file);
  file.format = PNG_FORMAT_LINEAR_Y;
  checkPng(png_image_finish_read(&file, nullptr, image.depth.data(), 0, nullptr), file);
}

void
checkJpeg(int result, tjhandle handle)
{
  if (result != 0)
    throw std::runtime_error(std::string("libjpeg-turbo: ") + tjGetErrorStr2(handle));
}

void
writeJpeg(const DepthImage& image, Bytes& bytes)
{
  constexpr int quality = 90; // the default of IAI Kinect2's driver
  static const std::unique_ptr<void, decltype(&tjDestroy)> jpeg(tjInitCompress(),
                                                                tjDestroy);
  Bytes grey(image.depth.size());
  for (std::size_t i = 0; i < grey.size(); ++i)
    grey[i] =
        static_cast<std::uint8_t>(std::min(255.0, image.depth[i] / jpeg_step_mm + 0.5));
  const int columns = static_cast<int>(image.columns);
  const int rows = static_cast<int>(image.rows);
  unsigned long size = tjBufSize(columns, rows, TJSAMP_GRAY);
  bytes.resize(size);
  unsigned char* begin = bytes.data();
  checkJpeg(tjCompress2(jpeg.get(),
                        grey.data(),
                        columns,
                        0,
                        rows,
                        TJPF_GRAY,
                        &begin,
                        &size,
                        TJSAMP_GRAY,
                        quality,
                        TJFLAG_NOREALLOC),
            jpeg.get());
  bytes.resize(size);
}

void
readJpeg(const Bytes& bytes, DepthImage& image)
{
  static const std::unique_ptr<void, decltype(&tjDestroy)> jpeg(tjInitDecompress(),
                                                                tjDestroy);
  Bytes grey(image.depth.size());
  checkJpeg(tjDecompress2(jpeg.get(),
                          bytes.data(),
                          static_cast<unsigned long>(bytes.size()),
                          grey.data(),
                          static_cast<int>(image.columns),
                          0,
                          static_cast<int>(image.rows),
                          TJPF_GRAY,
                          0),
            jpeg.get());
  for (std::size_t i = 0; i < grey.size(); ++i)
    image.depth[i] = static_cast<std::uint16_t>(std::lround(grey[i] * jpeg_step_mm));
}

/** \brief The first one is raw. */
const std::vector<ImageCoder> coders = {
    {"raw 16 bits", copyRaw, readRaw},
    {"PNG 16 bits",
     [](const DepthImage& image, Bytes& bytes) { writePng(image, 0, bytes); },
     readPng},
    {"PNG 16 bits fast",
     [](const DepthImage& image, Bytes& bytes) {
       writePng(image, PNG_IMAGE_FLAG_FAST, bytes);
     },
     readPng},
    {"JPEG 8 bits quality 90", writeJpeg, readJpeg}};

/** \brief One coder's results over the images of a stream. */
class ImageRun {
public:
  explicit ImageRun(const ImageCoder& coder) : coder_(coder) {}

  void
  code(const DepthImage& image)
  {
    encode_ms_.add(timeOf([&] { coder_.encode(image, bytes_); }));
    decoded_ = image;
    decode_ms_.add(timeOf([&] { coder_.decode(bytes_, decoded_); }));
    sizes_.add(static_cast<double>(bytes_.size()));
    addErrors(image);
  }

  void
  write(measuring::Results& results) const
  {
    const measuring::Subject subject{"depth_image", "1", coder_.name, 0.0};
    results.add(subject, "bytes", sizes_);
    results.add(subject, "encode_ms", encode_ms_);
    results.add(subject, "decode_ms", decode_ms_);
    results.add(subject, "error_mm", error_mm_);
    results.add(subject, "wrong_percent", wrong_percent_);
  }

private:
  void
  addErrors(const DepthImage& image)
  {
    double squares = 0.0;
    double both = 0.0;
    double either = 0.0;
    double wrong = 0.0;
    for (std::size_t i = 0; i < image.depth.size(); ++i) {
      const bool was = image.depth[i] != 0;
      const bool is = decoded_.depth[i] != 0;
      const double error = static_cast<double>(decoded_.depth[i]) - image.depth[i];
      either += was || is ? 1.0 : 0.0;
      both += was && is ? 1.0 : 0.0;
      squares += was && is ? error * error : 0.0;
      wrong += was != is || std::abs(error) > wrong_mm ? 1.0 : 0.0;
    }
    error_mm_.add(both > 0.0 ? std::sqrt(squares / both) : 0.0);
    wrong_percent_.add(both > 0.0 ? 100.0 * wrong / either : 0.0);
  }

  const ImageCoder& coder_;
  Bytes bytes_;
  DepthImage decoded_;

  Samples sizes_;
  Samples encode_ms_;
  Samples decode_ms_;
  Samples error_mm_;
  Samples wrong_percent_;
};

DepthImage
depthImageOf(const pcl::PointCloud<pcl::PointXYZ>& points)
{
  if (points.height < 2)
    throw std::runtime_error("a depth image needs an organised cloud");
  DepthImage image;
  image.columns = points.width;
  image.rows = points.height;
  for (const pcl::PointXYZ& point : points) {
    const float millimetres = std::isfinite(point.z) ? 1000.0f * point.z : 0.0f;
    if (!(millimetres >= 0.0f && millimetres < 65535.0f))
      throw std::runtime_error("a depth of " + std::to_string(point.z) +
                               " m does not fit into 16 bits of millimetres");
    image.depth.push_back(static_cast<std::uint16_t>(std::lround(millimetres)));
  }
  return image;
}

} // namespace

void
measureDepthImages(clouds::CloudSequence& clouds, measuring::Results& results)
{
  std::vector<ImageRun> runs(coders.begin(), coders.end());
  pcl::PCLPointCloud2 cloud;
  pcl::PointCloud<pcl::PointXYZ> points;
  for (std::size_t i = 0; i < clouds.size(); ++i) {
    clouds.read(i, cloud);
    pcl::fromPCLPointCloud2(cloud, points);
    const DepthImage image = depthImageOf(points);
    for (ImageRun& run : runs)
      run.code(image);
  }
  for (const ImageRun& run : runs)
    run.write(results);
}

} // namespace paper
} // namespace pcl_ext

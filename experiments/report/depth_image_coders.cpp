#include "depth_image_coders.h"

#include <pcl/conversions.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <png.h>
#include <turbojpeg.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace pcl_ext {
namespace report {

namespace {

class PngCoder : public DepthImageCoder {
public:
  explicit PngCoder(bool fast) : fast_(fast) {}

  std::string
  name() const override
  {
    return fast_ ? "PNG 16 bits fast" : "PNG 16 bits";
  }

  void
  encode(const DepthImage& image, std::vector<std::uint8_t>& bytes) override
  {
    png_image file = emptyFile();
    file.width = static_cast<png_uint_32>(image.columns);
    file.height = static_cast<png_uint_32>(image.rows);
    // libpng's name for 16 bits of grey, which it then leaves as they are.
    file.format = PNG_FORMAT_LINEAR_Y;
    file.flags = fast_ ? PNG_IMAGE_FLAG_FAST : 0u;
    png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(file);
    bytes.resize(size);
    if (png_image_write_to_memory(
            &file, bytes.data(), &size, 0, image.depth.data(), 0, nullptr) == 0)
      throw std::runtime_error(std::string("libpng: ") + file.message);
    bytes.resize(size);
  }

  void
  decode(const std::vector<std::uint8_t>& bytes, DepthImage& image) override
  {
    png_image file = emptyFile();
    if (png_image_begin_read_from_memory(&file, bytes.data(), bytes.size()) == 0)
      throw std::runtime_error(std::string("libpng: ") + file.message);
    file.format = PNG_FORMAT_LINEAR_Y;
    image.depth.resize(std::size_t{file.width} * file.height);
    if (png_image_finish_read(&file, nullptr, image.depth.data(), 0, nullptr) == 0)
      throw std::runtime_error(std::string("libpng: ") + file.message);
  }

private:
  static png_image
  emptyFile()
  {
    png_image file{};
    file.version = PNG_IMAGE_VERSION;
    return file;
  }

  bool fast_;
};

class JpegCoder : public DepthImageCoder {
public:
  JpegCoder(int quality, unsigned int farthest)
  : quality_(quality)
  , step_(farthest / 255.0)
  , compressor_(tjInitCompress(), tjDestroy)
  , decompressor_(tjInitDecompress(), tjDestroy)
  {
    if (!compressor_ || !decompressor_)
      throw std::runtime_error("libjpeg-turbo does not start");
  }

  std::string
  name() const override
  {
    return "JPEG 8 bits quality " + std::to_string(quality_);
  }

  void
  encode(const DepthImage& image, std::vector<std::uint8_t>& bytes) override
  {
    grey_.resize(image.depth.size());
    for (std::size_t i = 0; i < grey_.size(); ++i)
      grey_[i] =
          static_cast<std::uint8_t>(std::min(255.0, image.depth[i] / step_ + 0.5));
    const int columns = static_cast<int>(image.columns);
    const int rows = static_cast<int>(image.rows);
    unsigned long size = tjBufSize(columns, rows, TJSAMP_GRAY);
    bytes.resize(size);
    unsigned char* begin = bytes.data();
    check(tjCompress2(compressor_.get(),
                      grey_.data(),
                      columns,
                      0,
                      rows,
                      TJPF_GRAY,
                      &begin,
                      &size,
                      TJSAMP_GRAY,
                      quality_,
                      TJFLAG_NOREALLOC),
          compressor_.get());
    bytes.resize(size);
  }

  void
  decode(const std::vector<std::uint8_t>& bytes, DepthImage& image) override
  {
    grey_.resize(image.columns * image.rows);
    check(tjDecompress2(decompressor_.get(),
                        bytes.data(),
                        static_cast<unsigned long>(bytes.size()),
                        grey_.data(),
                        static_cast<int>(image.columns),
                        0,
                        static_cast<int>(image.rows),
                        TJPF_GRAY,
                        0),
          decompressor_.get());
    image.depth.resize(grey_.size());
    for (std::size_t i = 0; i < grey_.size(); ++i)
      image.depth[i] = static_cast<std::uint16_t>(std::lround(grey_[i] * step_));
  }

private:
  static void
  check(int result, tjhandle handle)
  {
    if (result != 0)
      throw std::runtime_error(std::string("libjpeg-turbo: ") + tjGetErrorStr2(handle));
  }

  int quality_;
  double step_; ///< millimetres of one grey value
  std::vector<std::uint8_t> grey_;
  std::unique_ptr<void, decltype(&tjDestroy)> compressor_;
  std::unique_ptr<void, decltype(&tjDestroy)> decompressor_;
};

} // namespace

DepthImage
depthImageOf(const pcl::PCLPointCloud2& cloud)
{
  pcl::PointCloud<pcl::PointXYZ> points;
  pcl::fromPCLPointCloud2(cloud, points);
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

std::unique_ptr<DepthImageCoder>
makePngCoder(bool fast)
{
  return std::make_unique<PngCoder>(fast);
}

std::unique_ptr<DepthImageCoder>
makeJpegCoder(int quality, unsigned int farthest)
{
  return std::make_unique<JpegCoder>(quality, farthest);
}

} // namespace report
} // namespace pcl_ext

/** \file
 * \brief Depth images through PNG and JPEG, the comparison of the paper's section 3.2.
 */
#pragma once

#include <pcl/PCLPointCloud2.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace pcl_ext {
namespace report {

/** \brief What a depth camera's driver hands over: millimetres, 0 without a return. */
struct DepthImage {
  std::size_t columns = 0;
  std::size_t rows = 0;
  std::vector<std::uint16_t> depth; ///< row by row
};

/** \brief The depth image that an organised cloud in the sensor's frame was made of.
 * \throws std::runtime_error if the cloud is not organised, or a depth is beyond 65 m
 */
DepthImage
depthImageOf(const pcl::PCLPointCloud2& cloud);

/** \brief Encodes depth images as files in memory. */
class DepthImageCoder {
public:
  virtual ~DepthImageCoder() = default;

  virtual std::string
  name() const = 0;

  /** \throws std::runtime_error with the library's message */
  virtual void
  encode(const DepthImage& image, std::vector<std::uint8_t>& bytes) = 0;

  /** \brief Decodes an image of the size that \a image has.
   * \throws std::runtime_error with the library's message
   */
  virtual void
  decode(const std::vector<std::uint8_t>& bytes, DepthImage& image) = 0;
};

/** \brief 16-bit PNG by libpng, which loses nothing.
 * \param[in] fast without filters and with little compression, as libpng offers it
 */
std::unique_ptr<DepthImageCoder>
makePngCoder(bool fast);

/** \brief 8-bit JPEG by libjpeg-turbo; baseline JPEG knows no more bits.
 * \param[in] quality 1..100
 * \param[in] farthest depth that the 255 steps reach, millimetres; those beyond are held
 */
std::unique_ptr<DepthImageCoder>
makeJpegCoder(int quality, unsigned int farthest);

} // namespace report
} // namespace pcl_ext

/** \file
 * \brief Labels of points: files as SemanticKITTI's, and the field `label` of PCD files.
 */
#pragma once

#include <pcl/PCLPointCloud2.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace pcl_ext {
namespace clouds {

/** \brief A file of a cloud and that of its labels. */
struct LabelledFile {
  std::string cloud;
  std::string labels; ///< empty: the cloud's own field `label`
};

/** \brief Finds the clouds of a folder that have labels, in the order of their names:
 *
 * - .bin files of KITTI's lidar with .label files of the same names, in this folder, in
 *   its folders `velodyne` and `labels` as in SemanticKITTI, or in `snow_velodyne` and
 *   `snow_labels` as in 4DenoiseNet's SnowyKITTI;
 * - else the folder's PCD files.
 *
 * \throws std::runtime_error if there are none, or if a .bin file has no labels
 */
std::vector<LabelledFile>
findLabelledFiles(const std::string& folder);

/** \brief Reads labels as SemanticKITTI's: a little-endian uint32 for each point, whose
 * lower 16 bits are the class and the upper ones an instance, which is left out.
 * \param[in] points number of points of the cloud
 * \throws std::runtime_error with the file and both numbers if it has not as many labels
 */
std::vector<std::uint16_t>
readLabels(const std::string& path, std::size_t points);

/** \brief The classes in the field `label` of a cloud: of integers the lower 16 bits.
 * \throws std::runtime_error if it has no such field of whole numbers
 */
std::vector<std::uint16_t>
labelsOf(const pcl::PCLPointCloud2& cloud);

} // namespace clouds
} // namespace pcl_ext

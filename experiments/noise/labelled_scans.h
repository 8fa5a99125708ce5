/** \file
 * \brief Scans of lidars with the truth of each point: of files, or simulated.
 */
#pragma once

#include "clouds/label_files.h"
#include "point_filters.h"
#include "simulator/robot_cell.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace pcl_ext {
namespace noise {

/** \brief What a point is. */
enum class PointClass : std::uint8_t {
  Missing, ///< no return
  Ignored, ///< may be anything: it is a neighbour, but not judged
  Noise,
  Surface, ///< but of a person or a pole
  Person,
  Pole
};

/** \brief A scan with its truth. */
struct LabelledScan {
  std::string name; ///< of the file, without its folder and extension
  /** \brief In the sensor's frame, metres, in the order of the file, with its rows and
   * columns if it has them; NaN where there is no return. */
  pcl::PointCloud<pcl::PointXYZI> cloud;
  std::vector<PointClass> classes; ///< of each point
  /** \brief The points with a return alone, for methods that need no order. */
  Centres::Ptr returns{new Centres};
  std::vector<std::size_t> index_of_return; ///< in the cloud

  /** \brief Sets `returns` and `index_of_return` from cloud and classes. */
  void
  collectReturns();
};

/** \brief Scans of one sensor in time order. */
class LabelledScans {
public:
  virtual ~LabelledScans() = default;

  virtual std::size_t
  size() const = 0;

  /** \brief Reads a scan.
   * \throws std::runtime_error with the file's name if it cannot be read
   */
  virtual void
  read(std::size_t index, LabelledScan& scan) = 0;
};

/** \brief What labels mean. A label that is in none of the lists is a surface. */
struct LabelMeanings {
  /** \brief 1 is snow in 4DenoiseNet's SnowyKITTI and `outlier` in SemanticKITTI, 110
   * is falling snow in WADS. */
  std::vector<std::uint16_t> noise = {1, 110};

  /** \brief 30 and 254 are persons in SemanticKITTI, 254 those that move. */
  std::vector<std::uint16_t> persons = {30, 254};

  std::vector<std::uint16_t> poles = {80}; ///< as in SemanticKITTI

  /** \brief Empty, as 0 is `unlabelled` in SemanticKITTI, but all surfaces in
   * SnowyKITTI. */
  std::vector<std::uint16_t> ignored;

  /** \brief What a point with a return is. The first list that has its label
   * decides, in the order ignored, noise, persons, poles. */
  PointClass
  classOf(std::uint16_t label) const;
};

/** \brief Scans of a folder; see clouds::findLabelledFiles().
 *
 * A point is missing if its coordinates are not finite or all 0, or if x, y, z and the
 * intensity are all -1, as in SnowyKITTI, whose scans are images.
 */
class ScansOfFolder : public LabelledScans {
public:
  /** \param[in] folder of the scans
   * \param[in] meanings of their labels
   * \param[in] rows of the image that each file is, row by row; 1: they are none. Those
   * of SnowyKITTI have 64, a ring each, whose columns are not all in the order of their
   * azimuths
   * \throws std::runtime_error if there are none
   */
  ScansOfFolder(const std::string& folder,
                LabelMeanings meanings,
                std::uint32_t rows = 1);

  std::size_t
  size() const override
  {
    return files_.size();
  }

  void
  read(std::size_t index, LabelledScan& scan) override;

private:
  std::vector<clouds::LabelledFile> files_;
  LabelMeanings meanings_;
  std::uint32_t rows_;
};

/** \brief The robot cell's lidar; poles are not marked. */
class ScansOfCell : public LabelledScans {
public:
  explicit ScansOfCell(cell::RobotCell cell) : cell_(std::move(cell)) {}

  /** \brief As many as one wants. */
  std::size_t
  size() const override
  {
    return std::size_t{1} << 31;
  }

  void
  read(std::size_t index, LabelledScan& scan) override;

private:
  cell::RobotCell cell_;
  cell::LidarFrame captured_;
};

} // namespace noise
} // namespace pcl_ext

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Clouds with fields that are made of those of another one.
 */
#pragma once

#include "clouds/file_text.h"
#include "clouds/point_fields.h"

#include <pcl/PCLPointCloud2.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace pcl_ext {
namespace clouds {

/** \brief Reads numbers of a field, the first one of each point. */
class NumberReader {
public:
  /** \param[in] field of numbers that PCL has */
  explicit NumberReader(const pcl::PCLPointField& field)
  : file_field_(fileFieldOf(field)), offset_(field.offset)
  {}

  double
  operator()(const std::uint8_t* point) const;

  const FileField&
  fileField() const
  {
    return file_field_;
  }

private:
  FileField file_field_;
  std::size_t offset_;
};

/** \brief A field of a cloud that is made of another one's points. */
struct MadeField {
  pcl::PCLPointField field; ///< name, datatype and count
  std::size_t bytes = 0;    ///< of a point
  /** \brief Makes its bytes of those of a point; none: it is copied from the offset. */
  std::function<void(const std::uint8_t* point, std::uint8_t* made)> make;
};

/** \brief The field of one number with a name; null: there is none. */
const pcl::PCLPointField*
findField(const pcl::PCLPointCloud2& cloud, const std::string& name);

/** \brief A field that is copied. */
MadeField
copyOf(const pcl::PCLPointField& field);

/** \brief Gives a cloud other fields, one after the other. */
void
setFields(std::vector<MadeField>& fields, pcl::PCLPointCloud2& cloud);

} // namespace clouds
} // namespace pcl_ext

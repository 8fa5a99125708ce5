// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/point_view.h>
#include <pcl_ext/compression/voxel_frame.h>
#include <pcl_ext/export.h>

#include <pcl/PCLPointField.h>
#include <pcl/type_traits.h>

#include <boost/mpl/begin_end.hpp>
#include <boost/mpl/deref.hpp>
#include <boost/mpl/next.hpp>

#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::io::detail {

/** \brief The registered fields of a point type but x, y and z, with their offsets. */
class PCL_EXT_EXPORT PointFields {
public:
  /** \brief Adds a field, unless it is x, y or z, or has no datatype of PCL's. */
  void
  add(const char* name, std::size_t offset, std::uint8_t datatype, std::uint32_t count);

  /** \brief Views of the fields of points.
   * \param[in] points the first one
   * \param[in] stride bytes from one point to the next
   */
  std::vector<FieldView>
  viewsOf(const void* points, std::size_t stride) const;

  /** \brief Sets those fields of points that a frame has, by name; values of other
   * datatypes are converted.
   * \param[out] points the first one of the frame's
   * \param[in] stride bytes from one point to the next
   */
  void
  set(const VoxelFrame& frame, void* points, std::size_t stride) const;

private:
  std::vector<pcl::PCLPointField> fields_;
};

/** \brief Adds the registered fields of a point type to a list, from one on.
 *
 * As pcl::for_each_type, whose header takes the compiler more time than this. */
template <typename PointT, typename IteratorT, typename EndT>
void
addFields([[maybe_unused]] PointFields& fields)
{
  if constexpr (!std::is_same<IteratorT, EndT>::value) {
    using Tag = typename boost::mpl::deref<IteratorT>::type;
    fields.add(pcl::traits::name<PointT, Tag>::value,
               pcl::traits::offset<PointT, Tag>::value,
               pcl::traits::datatype<PointT, Tag>::value,
               pcl::traits::datatype<PointT, Tag>::size);
    addFields<PointT, typename boost::mpl::next<IteratorT>::type, EndT>(fields);
  }
}

template <typename PointT>
PointFields
pointFieldsOf()
{
  using Tags = typename pcl::traits::fieldList<PointT>::type;
  PointFields fields;
  addFields<PointT,
            typename boost::mpl::begin<Tags>::type,
            typename boost::mpl::end<Tags>::type>(fields);
  return fields;
}

} // namespace pcl_ext::PCL_EXT_ABI::io::detail

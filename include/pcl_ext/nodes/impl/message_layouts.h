// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Messages in the layout of those that a stream was made of.
 */
#pragma once

#include <pcl_ext/compression/message_layout.h>
#include <pcl_ext/export.h>

#include <pcl/PCLPointCloud2.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::nodes {

/** \brief The layout of a cloud's message. Coordinates that are whole numbers, or of
 * several types, are behind the other bytes of a point, as real numbers, as decoded ones
 * are no whole numbers.
 * \return it may be none by io::isLayout()
 */
PCL_EXT_EXPORT io::MessageLayout
messageLayoutOf(const pcl::PCLPointCloud2& cloud);

/** \brief Gives points another layout.
 *
 * Numbers are converted to the types of the layout: rounded to whole ones and limited to
 * their range. rgb and rgba are the same colour. Fields that the layout does not have
 * follow its last byte. Fields that the points do not have are not listed; their bytes
 * are 0, as is padding.
 */
class PCL_EXT_EXPORT Arrangement {
public:
  /** \param[in] layout as io::isLayout() demands
   * \param[in] fields of the points
   * \param[in] point_step bytes of a point; points follow each other without gaps
   */
  Arrangement(const io::MessageLayout& layout,
              const std::vector<io::PlacedField>& fields,
              std::uint32_t point_step,
              std::uint32_t width,
              std::uint32_t height);

  /** \brief Why the points stay as they are; empty if they need not. */
  const std::string&
  refusal() const
  {
    return refusal_;
  }

  const std::vector<io::PlacedField>&
  fields() const
  {
    return fields_;
  }

  std::uint32_t
  pointStep() const
  {
    return point_step_;
  }

  std::uint32_t
  rowStep() const
  {
    return row_step_;
  }

  /** \brief Bytes of all points. */
  std::size_t
  size() const
  {
    return std::size_t{height_} * row_step_;
  }

  /** \brief Copies the points.
   * \param[out] to size() bytes of 0
   * \return how many numbers were outside of their type, and limited
   */
  std::size_t
  apply(const std::uint8_t* from, std::uint8_t* to) const;

private:
  /** \brief What is copied of a point: bytes, or numbers that are converted. */
  struct Copy {
    io::PlacedField from;
    io::PlacedField to;
    std::size_t bytes; ///< 0: numbers
  };

  void
  add(const io::PlacedField& from, const io::PlacedField& to);

  std::vector<Copy> copies_;
  std::vector<io::PlacedField> fields_;
  std::size_t from_step_;
  std::uint32_t point_step_;
  std::uint32_t row_step_ = 0;
  std::uint32_t width_;
  std::uint32_t height_;
  std::string refusal_;
};

/** \brief The arrangement of the points of a message, which are without gaps. */
template <typename MessageT>
Arrangement
arrangementOf(const io::MessageLayout& layout, const MessageT& message)
{
  std::vector<io::PlacedField> fields;
  for (const auto& field : message.fields) {
    io::PlacedField& placed = fields.emplace_back();
    placed.name = field.name;
    placed.type = static_cast<io::FieldType>(field.datatype);
    placed.count = field.count;
    placed.offset = field.offset;
  }
  return Arrangement(layout, fields, message.point_step, message.width, message.height);
}

/** \brief Describes points that were arranged. */
template <typename MessageT>
void
describeArranged(const Arrangement& arrangement, MessageT& message)
{
  message.fields.resize(arrangement.fields().size());
  for (std::size_t i = 0; i < message.fields.size(); ++i) {
    const io::PlacedField& field = arrangement.fields()[i];
    message.fields[i].name = field.name;
    message.fields[i].datatype = static_cast<std::uint8_t>(field.type);
    message.fields[i].count = field.count;
    message.fields[i].offset = field.offset;
  }
  message.point_step = arrangement.pointStep();
  message.row_step = arrangement.rowStep();
}

/** \brief Gives the points of a message, which are without gaps, a layout.
 * \param[out] limited see Arrangement::apply(); may be null
 * \return why nothing was done; empty if it has the layout
 */
template <typename MessageT>
std::string
arrange(const io::MessageLayout& layout,
        MessageT& message,
        std::size_t* limited = nullptr)
{
  const Arrangement arrangement = arrangementOf(layout, message);
  if (!arrangement.refusal().empty())
    return arrangement.refusal();
  decltype(message.data) data(arrangement.size());
  const std::size_t limited_now = arrangement.apply(message.data.data(), data.data());
  if (limited != nullptr)
    *limited = limited_now;
  message.data.swap(data);
  describeArranged(arrangement, message);
  return {};
}

} // namespace pcl_ext::PCL_EXT_ABI::nodes

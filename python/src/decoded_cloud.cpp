#include "decoded_cloud.h"

#include <array>
#include <cstring>

namespace pcl_ext {
namespace python {

DecodedCloud::DecodedCloud(const io::VoxelFrame& frame)
: has_intensities_(frame.hasIntensities())
, has_colours_(frame.colour_bits > 0)
, coordinate_bytes_(frame.grid.needsDoubles() ? sizeof(double) : sizeof(float))
, count_(frame.pointCount())
{
  const std::size_t colour_offset =
      3 * coordinate_bytes_ + (has_intensities_ ? sizeof(float) : 0);
  const std::size_t used_bytes = colour_offset + (has_colours_ ? sizeof(float) : 0);
  // Whole coordinates, so that those of all points are aligned.
  point_bytes_ =
      (used_bytes + coordinate_bytes_ - 1) / coordinate_bytes_ * coordinate_bytes_;
  points_.reset(new unsigned char[count_ * point_bytes_]);
  unsigned char* next = points_.get();
  std::size_t voxel = 0;
  io::forEachPreciseCentre(frame, [&](auto x, auto y, auto z, float intensity) {
    const unsigned char* const first = next;
    const std::array<decltype(x), 3> place = {x, y, z};
    std::memcpy(next, place.data(), sizeof(place));
    if (has_intensities_)
      std::memcpy(next + sizeof(place), &intensity, sizeof(intensity));
    std::memset(next + used_bytes, 0, point_bytes_ - used_bytes);
    if (has_colours_) {
      const io::VoxelColour colour = frame.fullColour(voxel);
      const std::array<unsigned char, 4> channels = {colour.r, colour.g, colour.b, 0};
      std::memcpy(next + colour_offset, channels.data(), channels.size());
    }
    next += point_bytes_;
    const std::size_t points = frame.has_point_counts ? frame.point_counts[voxel] : 1;
    for (std::size_t copy = 1; copy < points; ++copy, next += point_bytes_)
      std::memcpy(next, first, point_bytes_);
    ++voxel;
  });
}

py::array
DecodedCloud::intoArray()
{
  py::list names;
  py::list formats;
  py::list offsets;
  std::size_t offset = 0;
  const auto add = [&](const char* name, const char* format, std::size_t bytes) {
    names.append(name);
    formats.append(format);
    offsets.append(offset);
    offset += bytes;
  };
  for (const char* name : {"x", "y", "z"})
    add(name, coordinate_bytes_ == sizeof(double) ? "f8" : "f4", coordinate_bytes_);
  if (has_intensities_)
    add("intensity", "f4", sizeof(float));
  if (has_colours_)
    for (const char* name : {"r", "g", "b"})
      add(name, "u1", 1);
  const py::dtype type(names, formats, offsets, static_cast<py::ssize_t>(point_bytes_));
  unsigned char* const points = points_.get();
  const py::capsule owner(
      points, [](void* memory) { delete[] static_cast<unsigned char*>(memory); });
  points_.release();
  return py::array(type,
                   {static_cast<py::ssize_t>(count_)},
                   {static_cast<py::ssize_t>(point_bytes_)},
                   points,
                   owner);
}

} // namespace python
} // namespace pcl_ext

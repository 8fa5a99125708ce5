// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief What the parts of the module share.
 */
#pragma once

#include <pcl_ext/filters/temporal_voxel_filter.h>
#include <pcl_ext/filters/voxel_outlier_removal.h>
#include <pcl_ext/recording/recording_status.h>
#include <pcl_ext/status.h>

#include <pybind11/pybind11.h>

#include <cstddef>
#include <cstdint>
#include <string>

namespace pcl_ext::python {

namespace py = pybind11;

/** \brief Calls a function without the GIL, so that other threads run meanwhile. */
template <typename FunctionT>
auto
withoutGil(const FunctionT& function)
{
  const py::gil_scoped_release released;
  return function();
}

/** \brief For functions that are called without the GIL. */
using WithoutGil = py::call_guard<py::gil_scoped_release>;

/** \brief Bytes that a caller gave, which stay valid and are not copied. */
class ByteView {
public:
  explicit ByteView(const py::object& object);

  const std::uint8_t*
  data() const
  {
    return static_cast<const std::uint8_t*>(view_.ptr);
  }

  std::size_t
  size() const
  {
    return static_cast<std::size_t>(view_.size);
  }

private:
  py::buffer_info view_;
};

/** \brief A text of the library. What is not UTF-8 in it, as a name in forged bytes,
 * becomes a replacement character. */
py::str
text(const std::string& bytes);

/** \brief The name of a code, as in the library. */
const char*
codeName(io::CompressionCode code);
const char*
codeName(OutlierRemovalCode code);
const char*
codeName(TemporalFilterCode code);
const char*
codeName(recording::RecordingCode code);

/** \brief The name of the code of a status, and its message. */
template <typename StatusT>
py::tuple
outcome(const StatusT& status)
{
  return py::make_tuple(codeName(status.code()), text(status.message()));
}

/** \brief A result, and as the above. */
template <typename StatusT>
py::tuple
outcome(const py::object& result, const StatusT& status)
{
  return py::make_tuple(result, codeName(status.code()), text(status.message()));
}

void
addCodec(py::module_& module);

void
addRecordings(py::module_& module);

} // namespace pcl_ext::python

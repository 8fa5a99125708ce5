// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "bindings.h"

#include <string>

namespace pcl_ext::python {

namespace {

[[noreturn]] void
refuseBytes(const py::object& object)
{
  throw py::type_error(
      "data is a '" +
      py::str(py::type::of(object).attr("__name__")).cast<std::string>() +
      "'; it must be bytes, bytearray, memoryview or a uint8 array, of one dimension "
      "and without gaps");
}

} // namespace

ByteView::ByteView(const py::object& object)
{
  if (PyObject_CheckBuffer(object.ptr()) == 0)
    refuseBytes(object);
  view_ = py::reinterpret_borrow<py::buffer>(object).request();
  if (view_.ndim != 1 || view_.itemsize != 1 ||
      (view_.strides[0] != 1 && view_.shape[0] > 1))
    refuseBytes(object);
}

py::str
text(const std::string& bytes)
{
  return py::reinterpret_steal<py::str>(PyUnicode_DecodeUTF8(
      bytes.data(), static_cast<py::ssize_t>(bytes.size()), "replace"));
}

} // namespace pcl_ext::python

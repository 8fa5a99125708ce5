// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "keywords.h"

#include <cmath>
#include <limits>
#include <optional>

namespace pcl_ext::python {

namespace {

std::string
shown(const py::handle& object)
{
  return py::module_::import("pcl_ext._texts")
      .attr("shown")(object)
      .cast<std::string>();
}

/** \brief The number that an object is; none if it is no number, infinity if it is too
 * large for a double. float() of Python takes texts, too. */
std::optional<double>
asNumber(const py::handle& object)
{
  if (PyNumber_Check(object.ptr()) == 0 || PyBool_Check(object.ptr()) ||
      PyComplex_Check(object.ptr()) || PyUnicode_Check(object.ptr()))
    return std::nullopt;
  if (py::hasattr(object, "dtype")) {
    const auto kind = py::str(object.attr("dtype").attr("kind")).cast<std::string>();
    if (kind != "f" && kind != "i" && kind != "u")
      return std::nullopt;
  }
  try {
    return py::float_(py::reinterpret_borrow<py::object>(object));
  }
  catch (py::error_already_set& error) {
    if (error.matches(PyExc_OverflowError))
      return std::numeric_limits<double>::infinity();
    if (error.matches(PyExc_TypeError) || error.matches(PyExc_ValueError))
      return std::nullopt;
    throw;
  }
}

} // namespace

bool
hasBytes(const py::str& text)
{
  if (PyUnicode_AsUTF8AndSize(text.ptr(), nullptr) != nullptr)
    return true;
  PyErr_Clear();
  return false;
}

double
numberOf(const std::string& name, const py::object& object)
{
  const std::optional<double> number = asNumber(object);
  if (!number)
    throw py::type_error(name + " is " + shown(object) + "; it must be a number");
  if (std::isinf(*number) && PyLong_Check(object.ptr()) != 0)
    throw py::value_error(name + " is " + shown(object) +
                          "; it must be a number of at most 1e308");
  return *number;
}

std::vector<double>
numbersOf(const char* name, const py::object& object, std::size_t count)
{
  const auto refuse = [&] {
    throw py::value_error(std::string(name) + " is " + shown(object) + "; it must be " +
                          std::to_string(count) + " numbers");
  };
  std::vector<double> numbers;
  try {
    for (const py::handle& element : object)
      if (const std::optional<double> number = asNumber(element))
        numbers.push_back(*number);
      else
        refuse();
  }
  catch (const py::error_already_set&) {
    refuse(); // as it has no elements
  }
  if (numbers.size() != count)
    refuse();
  return numbers;
}

void
Keywords::refuse(const char* name, const std::string& demand) const
{
  throw py::value_error(std::string(name) + " is " + shown(at(name)) + "; it must be " +
                        demand);
}

void
Keywords::refuseType(const char* name, const std::string& demand) const
{
  throw py::type_error(std::string(name) + " is " + shown(at(name)) + "; it must be " +
                       demand);
}

double
Keywords::number(const char* name) const
{
  return numberOf(name, at(name));
}

std::size_t
Keywords::count(const char* name, std::size_t lowest, std::size_t highest) const
{
  const py::object value = at(name);
  if (PyIndex_Check(value.ptr()) == 0 || PyBool_Check(value.ptr()))
    refuseType(name, "a whole number");
  // Clamped to the range of the type.
  const py::ssize_t number = PyNumber_AsSsize_t(value.ptr(), nullptr);
  if (number == -1 && PyErr_Occurred() != nullptr) { // as of an array of some numbers
    PyErr_Clear();
    refuseType(name, "a whole number");
  }
  if (number < 0 || static_cast<std::size_t>(number) < lowest ||
      static_cast<std::size_t>(number) > highest)
    refuse(name,
           "a whole number of " + std::to_string(lowest) + " to " +
               std::to_string(highest));
  return static_cast<std::size_t>(number);
}

bool
Keywords::flag(const char* name) const
{
  // Also those of numpy, but nothing that is only true in a condition.
  py::detail::make_caster<bool> flag;
  if (!flag.load(at(name), false))
    refuseType(name, "True or False");
  return flag;
}

std::string
Keywords::text(const char* name) const
{
  const py::object value = at(name);
  if (!py::isinstance<py::str>(value))
    refuseType(name, "a text");
  if (!hasBytes(value))
    refuse(name, "a text that UTF-8 has");
  return value.cast<std::string>();
}

std::vector<double>
Keywords::numbers(const char* name, std::size_t count) const
{
  return numbersOf(name, at(name), count);
}

} // namespace pcl_ext::python

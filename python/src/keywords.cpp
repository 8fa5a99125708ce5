// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "keywords.h"

#include <limits>

namespace pcl_ext {
namespace python {

namespace {

bool
isNumber(const py::object& object)
{
  return PyNumber_Check(object.ptr()) != 0 && !PyBool_Check(object.ptr()) &&
         !PyComplex_Check(object.ptr());
}

std::string
shown(const py::object& object)
{
  return py::repr(object).cast<std::string>();
}

} // namespace

double
numberOf(const std::string& name, const py::object& object)
{
  if (!isNumber(object))
    throw py::type_error(name + " is " + shown(object) + "; it must be a number");
  return py::float_(object);
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
    for (const py::handle& number : object)
      numbers.push_back(number.cast<double>());
  }
  catch (const py::error_already_set&) {
    refuse();
  }
  catch (const py::cast_error&) {
    refuse();
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
Keywords::count(const char* name, std::size_t highest) const
{
  const py::object value = at(name);
  if (PyIndex_Check(value.ptr()) == 0 || PyBool_Check(value.ptr()))
    refuseType(name, "a whole number");
  // Clamped to the range of the type.
  const py::ssize_t number = PyNumber_AsSsize_t(value.ptr(), nullptr);
  if (number < 0 || static_cast<std::size_t>(number) > highest)
    refuse(name, "a whole number of 0 to " + std::to_string(highest));
  return static_cast<std::size_t>(number);
}

unsigned int
Keywords::smallCount(const char* name) const
{
  constexpr unsigned int highest = std::numeric_limits<std::int32_t>::max();
  return static_cast<unsigned int>(count(name, highest));
}

bool
Keywords::flag(const char* name) const
{
  const py::object value = at(name);
  if (!PyBool_Check(value.ptr()))
    refuseType(name, "True or False");
  return value.cast<bool>();
}

std::string
Keywords::text(const char* name) const
{
  const py::object value = at(name);
  if (!py::isinstance<py::str>(value))
    refuseType(name, "a text");
  return value.cast<std::string>();
}

std::vector<double>
Keywords::numbers(const char* name, std::size_t count) const
{
  return numbersOf(name, at(name), count);
}

} // namespace python
} // namespace pcl_ext

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/impl/named_value.h>

#include <pybind11/pybind11.h>

#include <cstddef>
#include <string>
#include <vector>

namespace pcl_ext::python {

namespace py = pybind11;

/** \brief Settings by name, as Python gives them. Every function throws py::type_error
 * or py::value_error with the name, the value and what is allowed. */
class Keywords {
public:
  explicit Keywords(const py::dict& values) : values_(values) {}

  /** \brief The value itself, which must be there. */
  py::object
  at(const char* name) const
  {
    return values_[name];
  }

  bool
  isSet(const char* name) const
  {
    return !at(name).is_none();
  }

  double
  number(const char* name) const;

  /** \brief A whole number of lowest to highest. */
  std::size_t
  count(const char* name, std::size_t lowest, std::size_t highest) const;

  bool
  flag(const char* name) const;

  std::string
  text(const char* name) const;

  /** \brief As many numbers as said. */
  std::vector<double>
  numbers(const char* name, std::size_t count) const;

  /** \brief The value that a word names in a table of NamedValue. */
  template <typename TableT>
  auto
  choice(const char* name, const TableT& choices) const
  {
    const auto value = valueNamed(choices, text(name));
    if (!value)
      refuse(name, "one of " + namesOf(choices));
    return *value;
  }

  /** \brief Throws py::value_error. */
  [[noreturn]] void
  refuse(const char* name, const std::string& demand) const;

  /** \brief Throws py::type_error. */
  [[noreturn]] void
  refuseType(const char* name, const std::string& demand) const;

private:
  py::dict values_;
};

/** \brief False for a text that UTF-8 does not have, as a lone surrogate. */
bool
hasBytes(const py::str& text);

/** \brief A number.
 * \param[in] name for messages
 * \param[in] object what a caller gave
 */
double
numberOf(const std::string& name, const py::object& object);

/** \brief Numbers in a sequence or an array.
 * \param[in] name for messages
 * \param[in] object what a caller gave
 * \param[in] count how many they must be
 */
std::vector<double>
numbersOf(const char* name, const py::object& object, std::size_t count);

} // namespace pcl_ext::python

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "bytes/utf8.h"

#include <charconv>
#include <cmath>
#include <cstdio>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace pcl_ext {

/** \brief Figures as text in Prometheus' exposition format, version 0.0.4. */
class MetricsText {
public:
  /** \brief Names and values of labels. */
  using Labels = std::vector<std::pair<std::string, std::string>>;

  /** \param[in] labels of all samples, with names of [a-zA-Z_][a-zA-Z0-9_]* */
  explicit MetricsText(const Labels& labels = {})
  {
    for (const auto& [name, value] : labels)
      common_labels_ += labelOf(name, value) + ',';
  }

  /** \brief Begins a family, whose samples follow.
   * \param[in] type counter, gauge or histogram
   * \param[in] help one line without backslashes
   */
  void
  beginFamily(const std::string& name, const std::string& type, const std::string& help)
  {
    family_ = name;
    text_ += "# HELP " + name + ' ' + help + "\n# TYPE " + name + ' ' + type + '\n';
  }

  /** \brief Adds a sample of the family, unless its value is not finite.
   * \param[in] labels of labelOf(), with commas between them; may be empty
   * \param[in] suffix of the name, for those of histograms
   */
  void
  add(double value, const std::string& labels = {}, const std::string& suffix = {})
  {
    if (!std::isfinite(value))
      return;
    text_ += family_ + suffix;
    if (!common_labels_.empty() || !labels.empty())
      text_ += '{' + common_labels_ + labels + '}';
    text_ += ' ' + numberOf(value) + '\n';
  }

  /** \brief Text of a label. Whatever the bytes of its value are, readers take the
   * text: bytes that are no UTF-8, and those of value 0, become \\x1b and so on, and a
   * backslash before an x \\x5c, so that different values have different texts. */
  static std::string
  labelOf(const std::string& name, std::string_view value)
  {
    std::string label = name + "=\"";
    for (std::size_t at = 0; at < value.size();) {
      const bool is_escaped = value[at] == 0 || value.substr(at, 2) == "\\x";
      const std::size_t length = is_escaped ? 0 : utf8CharacterLength(value, at);
      if (length == 0) {
        char escaped[6];
        std::snprintf(escaped,
                      sizeof(escaped),
                      "\\\\x%02x",
                      static_cast<unsigned char>(value[at]));
        label += escaped;
      }
      else if (value[at] == '\n')
        label += "\\n";
      else {
        if (value[at] == '"' || value[at] == '\\')
          label += '\\';
        label += value.substr(at, length);
      }
      at += length == 0 ? 1 : length;
    }
    return label + '"';
  }

  /** \brief A finite number, the same in all locales. */
  static std::string
  numberOf(double value)
  {
    constexpr double least_fixed = 1e-6;
    constexpr double most_fixed = 1e15;
    const double size = std::abs(value);
    const bool is_fixed = size == 0.0 || (size >= least_fixed && size < most_fixed);
    char digits[64];
    const auto result = std::to_chars(digits,
                                      digits + sizeof(digits),
                                      value,
                                      is_fixed ? std::chars_format::fixed
                                               : std::chars_format::scientific);
    return {digits, result.ptr};
  }

  const std::string&
  text() const
  {
    return text_;
  }

private:
  std::string common_labels_; // with a comma behind each
  std::string family_;
  std::string text_;
};

} // namespace pcl_ext

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include <string>
#include <vector>

namespace pcl_ext::tools {

/** \brief Help in lines that fit a terminal: descriptions are wrapped. */
class HelpFormat : public CLI::Formatter {
public:
  static constexpr std::size_t width = 100;

  HelpFormat();

  std::string
  make_option(const CLI::Option* option, bool is_positional) const override;
};

/** \brief The names of an option and what follows them, such as "-o,--output OUT". */
std::string
synopsisOf(const CLI::Option& option);

/** \brief Divides a text into lines at its spaces. */
std::vector<std::string>
wrapped(const std::string& text, std::size_t width);

} // namespace pcl_ext::tools

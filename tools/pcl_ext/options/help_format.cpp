// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "options/help_format.h"

#include <sstream>

namespace pcl_ext::tools {

HelpFormat::HelpFormat()
{
  constexpr std::size_t names_width = 36;
  column_width(names_width);
}

std::string
synopsisOf(const CLI::Option& option)
{
  if (option.get_positional()) {
    const bool is_list = option.get_expected_max() > 1;
    return option.get_name(true) + (is_list ? "..." : "");
  }
  std::string text = option.get_name(false, true);
  // CLI11 shows the value of an option whose number may be left out.
  if (const std::size_t usual_value = text.find('{'); usual_value != std::string::npos)
    return text.substr(0, usual_value) + "[=" + option.get_type_name() + "]";
  if (option.get_type_size() != 0 && !option.get_type_name().empty())
    text += " " + option.get_type_name();
  return text;
}

std::vector<std::string>
wrapped(const std::string& text, std::size_t width)
{
  std::vector<std::string> lines;
  std::istringstream stream(text);
  std::string word;
  while (stream >> word) {
    if (lines.empty() || lines.back().size() + 1 + word.size() > width)
      lines.push_back(word);
    else
      lines.back() += " " + word;
  }
  return lines;
}

std::string
HelpFormat::make_option(const CLI::Option* option, bool /* is_positional */) const
{
  const std::size_t column = get_column_width();
  std::string text = "  " + synopsisOf(*option);
  text += text.size() + 1 < column ? std::string(column - text.size(), ' ')
                                   : "\n" + std::string(column, ' ');
  const std::vector<std::string> lines =
      wrapped(option->get_description(), width - column);
  for (std::size_t i = 0; i < lines.size(); ++i)
    text += (i == 0 ? "" : "\n" + std::string(column, ' ')) + lines[i];
  return text + "\n";
}

} // namespace pcl_ext::tools

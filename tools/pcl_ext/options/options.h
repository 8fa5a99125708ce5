// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Kinds of options that all commands share. Descriptions end with the default in
 * parentheses.
 */
#pragma once

#include <pcl_ext/impl/named_value.h>

#include "console/exit_status.h"
#include "outputs/output_path.h"

#include <CLI/App.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <string>
#include <type_traits>
#include <vector>

namespace pcl_ext::tools {

/** \brief True if the user gave an option. */
inline bool
isGiven(const CLI::App& app, const std::string& name)
{
  const CLI::Option* const option = app.get_option_no_throw(name);
  return option != nullptr && option->count() > 0;
}

/** \brief Refuses options that have no effect.
 * \param[in] why and what to do, after the name of the option
 * \throws UsageError if one of them is given
 */
inline void
refuseOptions(const CLI::App& app,
              const std::vector<std::string>& names,
              const std::string& why)
{
  for (const std::string& name : names)
    if (isGiven(app, name))
      throw UsageError(name + " " + why);
}

/** \brief Adds an option that is one of a few words.
 * \param[in] name as CLI11 takes it
 * \param[in] take is called with the word that is given
 */
template <typename TakeT>
CLI::Option*
addWords(CLI::App& app,
         const std::string& name,
         const std::vector<std::string>& words,
         const std::string& default_word,
         const std::string& description,
         TakeT take)
{
  std::string joined;
  for (const std::string& word : words)
    joined += (joined.empty() ? "" : "|") + word;
  return app
      .add_option_function<std::string>(
          name, take, description + " (" + default_word + ")")
      ->check(CLI::IsMember(words).description(""))
      ->type_name(joined);
}

/** \brief Adds an option with a few named values.
 * \param[in] name as CLI11 takes it
 * \param[in] choices all values, a table of NamedValue
 * \param[in,out] value the default; is set if the option is given
 */
template <typename TableT, typename ValueT>
CLI::Option*
addChoice(CLI::App& app,
          const std::string& name,
          const TableT& choices,
          ValueT& value,
          const std::string& description)
{
  std::vector<std::string> words;
  for (const auto& choice : choices)
    words.emplace_back(choice.name);
  return addWords(app,
                  name,
                  words,
                  nameOf(choices, value),
                  description,
                  [choices, &value](const std::string& given) {
                    value = valueNamed(choices, given).value_or(value);
                  });
}

/** \brief Refuses what is no number, such as 5cm, and nan, which CLI11 finds in any
 * range. */
inline std::string
refuseNan(const std::string& text)
{
  char* end = nullptr;
  const bool is_number = !std::isnan(std::strtod(text.c_str(), &end)) &&
                         end != text.c_str() && *end == '\0';
  return is_number ? std::string() : "'" + text + "' is no number";
}

/** \brief Refuses what is no number in a range. */
template <typename NumberT>
std::string
refuseOutside(const std::string& text, NumberT lowest, NumberT highest)
{
  if (refuseNan(text).empty() && CLI::Range(lowest, highest)(text).empty())
    return {};
  std::ostringstream fault;
  fault << '\'' << text << "' is no " << (std::is_integral_v<NumberT> ? "whole " : "")
        << "number from " << lowest << " to " << highest;
  return fault.str();
}

/** \brief Adds an option that is a number in a range.
 * \param[in,out] value the default; is set if the option is given
 * \param[in] type what stands for the number, such as METRES
 */
template <typename NumberT>
CLI::Option*
addNumber(CLI::App& app,
          const std::string& name,
          NumberT& value,
          NumberT lowest,
          NumberT highest,
          const std::string& type,
          const std::string& description)
{
  std::ostringstream default_value;
  default_value << value;
  const auto refuse = [=](const std::string& text) {
    const std::string fault = refuseOutside(text, lowest, highest);
    return refuseNan(text).empty() ? fault : fault + ": " + description;
  };
  return app.add_option(name, value, description + " (" + default_value.str() + ")")
      ->check(refuse)
      ->type_name(type);
}

/** \brief Adds an option whose number may be left out, --name or --name=NUMBER. A word
 * after it is not its number, as it may be an input.
 * \param[in,out] value is set if the option is given
 * \param[in] usual the number if none is given
 * \param[in] type what stands for the number, such as FRAMES
 */
inline CLI::Option*
addOptionalNumber(CLI::App& app,
                  const std::string& name,
                  unsigned int& value,
                  unsigned int usual,
                  unsigned int lowest,
                  unsigned int highest,
                  const std::string& type,
                  const std::string& description)
{
  const auto refuse = [lowest, highest](const std::string& text) {
    // Flags take hexadecimal numbers as 0.
    const bool is_decimal = text.find_first_not_of("0123456789") == std::string::npos;
    if (is_decimal && (text == "0" || refuseOutside(text, lowest, highest).empty()))
      return std::string();
    return "'" + text + "' is no whole number from " + std::to_string(lowest) + " to " +
           std::to_string(highest) + ", or 0";
  };
  app.parse_complete_callback([&app, name] {
    const CLI::Option* const inputs = app.get_option_no_throw("IN");
    if (inputs == nullptr || !isGiven(app, name))
      return;
    for (const std::string& input : inputs->results())
      if (input.find_first_not_of("0123456789") == std::string::npos &&
          !std::filesystem::exists(input))
        throw UsageError("there is no '" + input + "'; as the number of " + name +
                         " it is given as " + name + "=" + input);
  });
  return app
      .add_flag_function(
          name + "{" + std::to_string(usual) + "}",
          // 0 comes as -1.
          [&value](std::int64_t number) {
            value = static_cast<unsigned int>(std::max<std::int64_t>(number, 0));
          },
          description + " (off; alone " + std::to_string(usual) + ")")
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeLast)
      ->check(refuse)
      ->type_name(type);
}

/** \brief Adds an option whose text is parsed by a function, which throws
 * UsageError. */
template <typename ParseT>
CLI::Option*
addParsed(CLI::App& app,
          const std::string& name,
          const std::string& type,
          const std::string& description,
          ParseT parse)
{
  return app
      .add_option_function<std::string>(
          name, [parse](const std::string& text) { parse(text); }, description)
      ->type_name(type);
}

/** \brief Adds an option that takes names with commas between them, none of them empty.
 * It does not take the words after them, which may be inputs. */
inline CLI::Option*
addNames(CLI::App& app,
         const std::string& name,
         std::vector<std::string>& names,
         const std::string& description)
{
  return addParsed(
      app, name, "NAMES", description, [=, &names](const std::string& text) {
        std::istringstream stream(text + ','); // so that the last name may be empty
        for (std::string one; std::getline(stream, one, ',');) {
          one.erase(0, std::min(one.find_first_not_of(' '), one.size()));
          one.erase(one.find_last_not_of(' ') + 1);
          if (one.empty())
            throw UsageError(name + " is '" + text + "', where a name is empty");
          names.push_back(one);
        }
      });
}

inline CLI::Option*
addOverwrite(CLI::App& app, bool& may_replace)
{
  return app.add_flag("--overwrite",
                      may_replace,
                      "replace OUT, if it is a file, or an earlier run's clouds in it");
}

/** \brief Adds the input of a command, and the output, which are required. */
template <typename InputT>
void
addInput(CLI::App& app, InputT& input, const std::string& description)
{
  app.add_option("IN", input, description)->required()->type_name("");
}
inline void
addOutput(CLI::App& app, Output& output, const std::string& description)
{
  app.add_option("-o,--output", output.path, description)->required()->type_name("OUT");
  addOverwrite(app, output.may_replace);
}

inline void
addQuiet(CLI::App& app, bool& is_quiet)
{
  app.add_flag("-q,--quiet",
               is_quiet,
               "no progress and no remarks; errors and the last line stay");
}

} // namespace pcl_ext::tools

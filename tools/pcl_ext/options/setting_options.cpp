// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "options/setting_options.h"

#include "options/options.h"
#include "options/text_values.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <sstream>
#include <type_traits>
#include <utility>

namespace pcl_ext::tools {

namespace {

/** \brief Options of settings that are in no table of an encoder. */
constexpr std::pair<const char*, const char*> other_options[] = {
    {"law", "--law"},
    {"sensor", "--sensor"},
    {"sensor_pose", "--pose"},
    {"crop_box", "--crop"},
    {"global_frame", "--frame-id"},
    {"outlier_removal", "--remove-outliers"},
    {"outlier_removal.unit", "--unit"},
    {"decoder_limits.max_voxels", "--max-voxels"},
    {"site", "--site"},
    {"servers", "--server"},
    {"ca_file", "--ca"},
    {"certificate_file", "--certificate"},
    {"key_file", "--key"}};

/** \brief The long name of an option: "--resolution". */
std::string
longName(const std::string& names)
{
  return names.substr(names.find("--"));
}

/** \brief Sets a setting to a value, or throws UsageError. */
void
setOrRefuse(const io::EncoderSetting& setting,
            const io::SettingValue& value,
            io::EncoderSettings& settings)
{
  const io::CompressionStatus status = setValue(setting, value, settings);
  if (!status.ok())
    throw UsageError(messageOf(status));
}

/** \brief Adds the options of a setting, by the type of its value. */
struct OptionAdder {
  CLI::App& app;
  const io::EncoderSetting& setting;
  io::EncoderSettings& settings;
  std::string help;

  void
  operator()(bool io::EncoderSettings::*member)
  {
    app.add_flag(setting.option.names, settings.*member, help);
  }

  void
  operator()(unsigned int io::EncoderSettings::*member)
  {
    if (setting.option.alone == 0)
      return addRange(member);
    addOptionalNumber(app,
                      setting.option.names,
                      settings.*member,
                      setting.option.alone,
                      static_cast<unsigned int>(setting.range.lowest),
                      static_cast<unsigned int>(setting.range.highest),
                      setting.option.value_name,
                      help);
  }

  void
  operator()(float io::EncoderSettings::*member)
  {
    addRange(member);
  }

  void
  operator()(double io::EncoderSettings::*member)
  {
    const std::string name = longName(setting.option.names);
    const auto add = [&](const std::string& text, auto parse) {
      addParsed(app,
                setting.option.names,
                setting.option.value_name,
                text,
                [member, parse, &to = settings](const std::string& given) {
                  to.*member = parse(given);
                });
    };
    if (setting.range.unit == "bit/s")
      add(help, parseRate);
    else if (setting.range.unit == "s") {
      std::ostringstream usual;
      usual << " (" << settings.*member << ')';
      add(helpOfRange() + usual.str(),
          [name](const std::string& given) { return parseSeconds(name, given); });
    }
    else
      addRange(member);
  }

  void
  operator()(const io::SettingAccess& access)
  {
    const auto set = [row = setting, &to = settings](const std::string& text) {
      const std::string name = longName(row.option.names).substr(2);
      if (const std::size_t size = listSizeOf(row); size != 0)
        setOrRefuse(row, parseNumbers(name, text, size), to);
      else
        setOrRefuse(row, text, to);
    };
    if (access.words.empty())
      addParsed(app, setting.option.names, setting.option.value_name, help, set);
    else
      addWords(app,
               setting.option.names,
               access.words,
               std::get<std::string>(access.get(settings)),
               help,
               set);
  }

private:
  /** \brief The help with what 0 stands for. */
  std::string
  helpOfRange() const
  {
    const std::string& zero = setting.range.zero;
    return help + (zero.empty() ? "" : "; 0: " + zero);
  }

  /** \brief The numbers of the range and 0 if it stands for something; what lies between
   * is refused where all settings are checked. */
  template <typename NumberT>
  void
  addRange(NumberT io::EncoderSettings::*member)
  {
    const auto& [lowest, highest, unit, zero] = setting.range;
    constexpr double most = std::numeric_limits<std::int32_t>::max();
    const bool is_whole = std::is_integral_v<NumberT>;
    addNumber(app,
              setting.option.names,
              settings.*member,
              static_cast<NumberT>(zero.empty() ? lowest : 0.0),
              static_cast<NumberT>(is_whole ? std::min(highest, most) : highest),
              setting.option.value_name,
              helpOfRange());
  }
};

} // namespace

void
addSettingOptions(CLI::App& app,
                  const io::EncoderSettingTable& table,
                  io::OptionGroup group,
                  io::EncoderSettings& settings)
{
  for (const io::EncoderSetting& setting : table)
    if (setting.not_offered.option.empty() && setting.option.group == group)
      std::visit(
          OptionAdder{
              app, setting, settings, SettingText{setting.option.help}.with(optionOf)},
          setting.member);
}

std::string
optionOf(const std::string& id)
{
  for (const io::EncoderSetting& setting : io::encoderSettingTable())
    if (setting.id == id && !setting.option.names.empty())
      return longName(setting.option.names);
  for (const auto& [other, option] : other_options)
    if (id == other)
      return option;
  return id;
}

std::string
parameterNameOf(const std::string& option)
{
  for (const io::EncoderSetting& setting : io::encoderSettingTable())
    if (!setting.option.names.empty() && longName(setting.option.names) == option)
      return setting.id;
  for (const auto& [other, name] : other_options)
    if (option == name && option != "--remove-outliers") // a flag, not a setting
      return other;
  std::string name = option.substr(2);
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

} // namespace pcl_ext::tools

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "console/exit_status.h"
#include "options/help_format.h"
#include "options/setting_options.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

namespace pcl_ext::tools {
namespace {

using io::EncoderSettings;
using io::OptionGroup;

struct Program {
  explicit Program(const io::EncoderSettingTable& table)
  {
    app.formatter(std::make_shared<HelpFormat>());
    for (const OptionGroup group :
         {OptionGroup::Codec, OptionGroup::Cloud, OptionGroup::Budget})
      addSettingOptions(app, table, group, settings);
  }

  EncoderSettings
  parse(std::vector<std::string> arguments)
  {
    std::reverse(arguments.begin(), arguments.end()); // as CLI11 takes them
    app.parse(arguments);
    return settings;
  }

  CLI::App app;
  EncoderSettings settings;
};

TEST(SettingOptions, ARowOfTheTableIsAnOption)
{
  const io::EncoderSettingTable table = {
      {"brightness",
       &EncoderSettings::i_frame_rate,
       {2.0, 64.0, "lux", "dark"},
       "How bright it is.",
       {"-b,--bright", "LUX", "beside {keep_points}"},
       {}},
      {"glow",
       &EncoderSettings::keep_points,
       {},
       "Whether it glows.",
       {"--glow", "", "whether it does", OptionGroup::Budget},
       {}},
      {"secret",
       &EncoderSettings::coarsen_wide_clouds,
       {},
       "Nothing.",
       {},
       {"", "the program does not have it", ""}}};
  Program program(table);
  EXPECT_NE(program.app.help().find(
                "  -b,--bright LUX                   beside --keep-points; 0: dark "
                "(30)\n  --glow                            whether it does\n"),
            std::string::npos)
      << program.app.help();
  EXPECT_EQ(program.app.help().find("secret"), std::string::npos);
  const EncoderSettings settings = program.parse({"-b", "0", "--glow"});
  EXPECT_EQ(settings.i_frame_rate, 0u);
  EXPECT_TRUE(settings.keep_points);
  for (const std::string wrong : {"65", "-1", "bright"})
    EXPECT_THROW(Program(table).parse({"--bright", wrong}), CLI::ValidationError);
}

std::string
otherValue(const io::EncoderSetting& setting)
{
  const std::vector<std::string> words = wordsOf(setting);
  if (!words.empty())
    return words.back();
  if (listSizeOf(setting) != 0)
    return listSizeOf(setting) == 3 ? "-1.5,-0.5,0.5" : "-1.5,-0.5,0.5,1.5,2.5,3.5";
  if (std::holds_alternative<io::SettingAccess>(setting.member))
    return "ring,time:1e-06";
  return setting.range.unit == "bit/s" ? "2kbit/s"
         : setting.id == "rate_buffer" ? "0.5"
         : setting.range.lowest > 1.0  ? "64"
                                       : "1";
}

TEST(SettingOptions, EachSetsTheSettingOfItsRowAlone)
{
  const io::EncoderSettingTable& table = io::encoderSettingTable();
  for (const io::EncoderSetting& setting : table) {
    SCOPED_TRACE(setting.id);
    if (!setting.not_offered.option.empty()) {
      EXPECT_EQ(optionOf(setting.id), setting.id);
      continue;
    }
    const std::string name = optionOf(setting.id);
    EXPECT_EQ(parameterNameOf(name), setting.id);
    Program program(table);
    const CLI::Option* const option = program.app.get_option(name);
    const bool is_flag =
        std::holds_alternative<bool EncoderSettings::*>(setting.member);
    const std::string value = setting.id == "threads" || setting.id == "colour_bits"
                                  ? "3"
                                  : otherValue(setting);
    const EncoderSettings settings =
        program.parse({is_flag ? name : name + "=" + value});
    EXPECT_EQ(option->count(), 1u);
    for (const io::EncoderSetting& other : table)
      EXPECT_EQ(valueOf(other, settings) == valueOf(other, EncoderSettings()),
                other.id != setting.id)
          << other.id;
    EXPECT_TRUE(checkSettings(settings).ok()) << checkSettings(settings);
  }
}

TEST(SettingOptions, MessagesHaveTheirNames)
{
  EncoderSettings settings;
  settings.temporal_filter = 8;
  settings.fields = {{"resolution"}};
  EXPECT_EQ(messageOf(checkSettings(settings)),
            "--fields is set; it must be empty with --temporal-filter");
  const io::CompressionStatus of_others(
      io::CompressionCode::InvalidSettings,
      SettingText{"{crop_box} and {speed} are in /a_{{crop_box}"});
  EXPECT_EQ(messageOf(of_others), "--crop and speed are in /a_{crop_box}");
  EXPECT_EQ(parameterNameOf("--crop"), "crop_box");
  EXPECT_EQ(parameterNameOf("--remove-outliers"), "remove_outliers");
  EXPECT_EQ(parameterNameOf("--min-log-odds"), "min_log_odds");
}

TEST(SettingOptions, OtherNumbersInAListAreRefused)
{
  for (const auto& [argument, message] :
       std::vector<std::pair<std::string, std::string>>{
           {"--origin=1,2", "--origin needs 3 numbers, not 2"},
           {"--bounding-box=1,2,3", "--bounding-box needs 6 numbers, not 3"},
           {"--origin=1,2,x", "--origin: 'x' is not a number"},
           {"--fields=ring,", "--fields is 'ring,'; it must be names with commas"}})
    try {
      Program(io::encoderSettingTable()).parse({argument});
      ADD_FAILURE() << argument;
    }
    catch (const UsageError& error) {
      EXPECT_EQ(std::string(error.what()).substr(0, message.size()), message);
    }
}

} // namespace
} // namespace pcl_ext::tools

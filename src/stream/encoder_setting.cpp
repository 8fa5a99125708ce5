// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "stream/encoder_setting.h"

#include "bytes/exact_text.h"
#include "stream/setting_checks.h"

#include <algorithm>
#include <type_traits>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

/** \brief The type of a setting that is a flag or a number. */
template <typename MemberT>
struct TypeOf;
template <typename ValueT>
struct TypeOf<ValueT EncoderSettings::*> {
  using Type = ValueT;
};
template <typename MemberT>
using ValueOf = typename TypeOf<MemberT>::Type;

template <typename MemberT>
constexpr bool is_access = std::is_same_v<MemberT, SettingAccess>;

CompressionStatus
invalid(const EncoderSetting& setting, const std::string& value)
{
  return {CompressionCode::InvalidSettings,
          invalidText(setting.id, value, demandOf(setting))};
}

/** \brief The value as messages have it. */
std::string
shownValue(const EncoderSetting& setting, const EncoderSettings& settings)
{
  return std::visit(
      [&](const auto& member) -> std::string {
        using MemberT = std::decay_t<decltype(member)>;
        if constexpr (is_access<MemberT>)
          return std::get<std::string>(member.get(settings));
        else if constexpr (std::is_floating_point_v<ValueOf<MemberT>>)
          return exactText(settings.*member);
        else
          return std::to_string(settings.*member);
      },
      setting.member);
}

bool
isAllowed(const EncoderSetting& setting, const EncoderSettings& settings)
{
  const SettingRange& range = setting.range;
  return std::visit(
      [&](const auto& member) {
        using MemberT = std::decay_t<decltype(member)>;
        if constexpr (is_access<MemberT>) {
          const std::vector<std::string>& words = member.words;
          return words.empty() || std::count(words.begin(),
                                             words.end(),
                                             shownValue(setting, settings)) != 0;
        }
        else if constexpr (!std::is_same_v<ValueOf<MemberT>, bool>) {
          const auto number = static_cast<double>(settings.*member);
          // NaN is not in the range.
          return (number >= range.lowest && number <= range.highest) ||
                 (number == 0.0 && !range.zero.empty());
        }
        return true;
      },
      setting.member);
}

} // namespace

std::vector<std::string>
wordsOf(const EncoderSetting& setting)
{
  const auto* const access = std::get_if<SettingAccess>(&setting.member);
  return access == nullptr ? std::vector<std::string>() : access->words;
}

std::size_t
listSizeOf(const EncoderSetting& setting)
{
  const auto* const access = std::get_if<SettingAccess>(&setting.member);
  return access == nullptr ? 0 : access->list_size;
}

SettingValue
valueOf(const EncoderSetting& setting, const EncoderSettings& settings)
{
  return std::visit(
      [&](const auto& member) -> SettingValue {
        using MemberT = std::decay_t<decltype(member)>;
        if constexpr (is_access<MemberT>)
          return member.get(settings);
        else if constexpr (std::is_same_v<ValueOf<MemberT>, unsigned int>)
          return std::int64_t{settings.*member};
        else if constexpr (std::is_floating_point_v<ValueOf<MemberT>>)
          return double{settings.*member};
        else
          return settings.*member;
      },
      setting.member);
}

CompressionStatus
setValue(const EncoderSetting& setting,
         const SettingValue& value,
         EncoderSettings& settings)
{
  return std::visit(
      [&](const auto& member) -> CompressionStatus {
        using MemberT = std::decay_t<decltype(member)>;
        if constexpr (is_access<MemberT>) {
          const auto& words = member.words;
          const auto* const list = std::get_if<std::vector<double>>(&value);
          if (list != nullptr && !list->empty() && list->size() != member.list_size)
            return {CompressionCode::InvalidSettings,
                    invalidText(setting.id,
                                std::to_string(list->size()) + " numbers",
                                std::to_string(member.list_size) + " numbers")};
          if (!words.empty() &&
              std::count(words.begin(), words.end(), std::get<std::string>(value)) == 0)
            return invalid(setting, std::get<std::string>(value));
          return member.set(value, settings);
        }
        else if constexpr (std::is_same_v<ValueOf<MemberT>, unsigned int>)
          settings.*member = static_cast<unsigned int>(std::get<std::int64_t>(value));
        else if constexpr (std::is_floating_point_v<ValueOf<MemberT>>)
          settings.*member = static_cast<ValueOf<MemberT>>(std::get<double>(value));
        else
          settings.*member = std::get<bool>(value);
        return {};
      },
      setting.member);
}

std::string
demandOf(const EncoderSetting& setting)
{
  std::string words;
  for (const std::string& word : wordsOf(setting))
    words += (words.empty() ? "one of " : ", ") + word;
  if (!words.empty())
    return words;
  const SettingRange& range = setting.range;
  const std::string separator = range.lowest > 0.0 ? ", or 0 for " : ", 0 for ";
  return exactText(range.lowest) + " to " + exactText(range.highest) +
         (range.unit.empty() ? "" : ' ' + range.unit) +
         (range.zero.empty() ? "" : separator + range.zero);
}

bool
needsIntensities(const EncoderSetting& setting)
{
  return std::count(setting.needs.begin(), setting.needs.end(), "law") != 0;
}

SettingText
unmetNeedOf(const EncoderSetting& setting, const EncoderSettings& settings)
{
  std::string text;
  for (const EncoderSetting& other : encoderSettingTable()) {
    if (std::count(setting.needs.begin(), setting.needs.end(), other.id) == 0)
      continue;
    if (valueOf(other, settings) != valueOf(other, EncoderSettings()))
      return {};
    text += (text.empty() ? "{" : " or {") + other.id + '}';
  }
  return {text};
}

SettingText
helpOf(const EncoderSetting& setting)
{
  if (setting.range.zero.empty())
    return {setting.help};
  return {setting.help.substr(0, setting.help.size() - 1) +
          "; 0: " + setting.range.zero + '.'};
}

CompressionStatus
checkEach(const EncoderSettingTable& table, const EncoderSettings& settings)
{
  for (const EncoderSetting& setting : table)
    if (!isAllowed(setting, settings))
      return invalid(setting, shownValue(setting, settings));
  return {};
}

} // namespace pcl_ext::PCL_EXT_ABI::io

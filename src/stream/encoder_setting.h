// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/export.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

// A setting of an encoder as a row of a table, from which its checks, the parameters of
// nodes, the options of the program and the keywords of Python are made.

namespace pcl_ext::PCL_EXT_ABI::io {

/** \brief A value as parameters, options and keywords have it. An empty list or text is
 * a setting that is not set. */
using SettingValue =
    std::variant<bool, std::int64_t, double, std::string, std::vector<double>>;

/** \brief How a setting is read and set that is no flag and no number. */
struct SettingAccess {
  SettingValue (*get)(const EncoderSettings& settings);

  /** \brief Returns Ok, or InvalidSettings for a text that cannot be read. */
  CompressionStatus (*set)(const SettingValue& value, EncoderSettings& settings);

  std::vector<std::string> words; ///< all that a text may be; empty: any text
  std::size_t list_size = 0;      ///< of a list that is not empty
};

/** \brief The range of a number, both ends included. */
struct SettingRange {
  double lowest = 0.0;
  double highest = 0.0;
  std::string unit; ///< "m", "frames"; empty: none
  std::string
      zero; ///< what 0 stands for, as "off", whatever the range; empty: a number
};

/** \brief The commands of the program that have an option. */
enum class OptionGroup {
  Codec, ///< all that encode
  Cloud, ///< those that encode a user's clouds
  Budget ///< those that keep a budget
};

/** \brief The option of the program. */
struct SettingOption {
  std::string names;      ///< as CLI11 takes them: "-r,--resolution"
  std::string value_name; ///< what stands for the value: "M"; of words and flags empty
  std::string help;       ///< a line, without the default
  OptionGroup group = OptionGroup::Codec;
  unsigned int alone = 0; ///< value of the option without one; 0: it needs one
};

/** \brief Why a face does not offer a setting; empty: it does. */
struct NotOffered {
  std::string parameter; ///< of the nodes
  std::string option;    ///< of the program
  std::string keyword;   ///< of Python
};

/** \brief One setting. */
struct EncoderSetting {
  using Member = std::variant<bool EncoderSettings::*,
                              unsigned int EncoderSettings::*,
                              float EncoderSettings::*,
                              double EncoderSettings::*,
                              SettingAccess>;

  std::string id; ///< the field's name
  Member member;
  SettingRange range; ///< of numbers; its unit is that of lists, too

  /** \brief What it is for, in one sentence; other settings are in braces. */
  std::string help;
  SettingOption option;
  NotOffered not_offered;
  /** \brief It has no effect while all of these are 0, or the law is None: "law". */
  std::vector<std::string> needs = {};
};

using EncoderSettingTable = std::vector<EncoderSetting>;

/** \brief All settings of an encoder, in the order in which they are shown, but
 * decoder_limits: an encoder only warns of them, and each face that decodes has options
 * for those of its decoders. */
PCL_EXT_CODEC_EXPORT const EncoderSettingTable&
encoderSettingTable();

/** \brief The words of a setting that has some; else none. */
PCL_EXT_CODEC_EXPORT std::vector<std::string>
wordsOf(const EncoderSetting& setting);

/** \brief The number of elements of a setting that is a list; else 0. */
PCL_EXT_CODEC_EXPORT std::size_t
listSizeOf(const EncoderSetting& setting);

/** \brief The value that a setting has. */
PCL_EXT_CODEC_EXPORT SettingValue
valueOf(const EncoderSetting& setting, const EncoderSettings& settings);

/** \brief Sets a setting, and checks its words and syntax, but not its range.
 * \param[in] value of the type that valueOf() has; whole numbers within 32 bits
 * \return Ok; or InvalidSettings, and the settings are unchanged
 */
PCL_EXT_CODEC_EXPORT CompressionStatus
setValue(const EncoderSetting& setting,
         const SettingValue& value,
         EncoderSettings& settings);

/** \brief What a setting must be: "2 to 64 frames, or 0 for off". */
PCL_EXT_CODEC_EXPORT std::string
demandOf(const EncoderSetting& setting);

/** \brief Whether a setting has no effect with the law None. */
PCL_EXT_CODEC_EXPORT bool
needsIntensities(const EncoderSetting& setting);

/** \brief What has to be set for a setting to have an effect: "{max_rate} or
 * {max_encode_ms}"; empty if it is. */
PCL_EXT_CODEC_EXPORT SettingText
unmetNeedOf(const EncoderSetting& setting, const EncoderSettings& settings);

/** \brief What a setting is for, in one sentence with what 0 stands for. */
PCL_EXT_CODEC_EXPORT SettingText
helpOf(const EncoderSetting& setting);

/** \brief Checks each setting for itself.
 * \return Ok, or InvalidSettings with the first that is outside its range
 */
PCL_EXT_CODEC_EXPORT CompressionStatus
checkEach(const EncoderSettingTable& table, const EncoderSettings& settings);

} // namespace pcl_ext::PCL_EXT_ABI::io

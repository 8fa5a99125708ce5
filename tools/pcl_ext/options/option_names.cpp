// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "options/option_names.h"

#include <cctype>
#include <cstddef>
#include <utility>

namespace pcl_ext {
namespace tools {

namespace {

/** \brief Settings and their options. Words that are no names alone have the words around
 * them. */
constexpr std::pair<const char*, const char*> options_of_settings[] = {
    {"settings.resolution", "--resolution"},
    {"resolution is", "--resolution is"},
    {"larger resolution", "larger --resolution"},
    {"set origin", "set --origin"},
    {"origin is", "--origin is"},
    {"is faces or points and law is", "is faces or points and --law is"},
    {"settings.effort", "--effort"},
    {"i_frame_rate", "--i-frame-rate"},
    {"colour_bits", "--colour-bits"},
    {"intensity_bits", "--intensity-bits"},
    {"intensity_range", "--intensity-range"},
    {"intensity_curve", "--intensity-curve"},
    {"intensity_field", "--intensity-field"},
    {"keep_point_counts", "--keep-point-counts"},
    {"coarsen_wide_clouds", "--coarsen"},
    {"temporal_filter", "--temporal-filter"},
    {"max_rate", "--max-rate"},
    {"max_encode_ms", "--max-encode-ms"},
    {"rate_buffer", "--rate-buffer"},
    {"rate_temporal_filter", "--rate-temporal-filter"},
    {"fields is", "--fields is"},
    {"fields has", "--fields has"},
    {"bounding_box", "--bounding-box"},
    {"crop_box", "--crop"},
    {"sensor_pose", "--pose"},
    {"global_frame", "--frame-id"},
    {"outlier_removal.unit", "--unit"},
    {"outlier_removal", "--remove-outliers"},
    {"decoder_limits.max_voxels", "--max-voxels"},
    {"site is", "--site is"},
    {"servers is", "--server is"},
    {"certificate_file and key_file", "--certificate and --key"},
    {"ca_file", "--ca"},
    {"sensor is not set", "--sensor is not set"}};

bool
isPartOfName(char letter)
{
  return std::isalnum(static_cast<unsigned char>(letter)) != 0 || letter == '_' ||
         letter == '.' || letter == '/' || letter == '-';
}

} // namespace

std::string
withOptionNames(const std::string& message)
{
  std::string text = message;
  for (const auto& [setting, option] : options_of_settings) {
    const std::string name = setting;
    const std::string replacement = option;
    for (std::size_t at = 0; (at = text.find(name, at)) != std::string::npos;) {
      const std::size_t end = at + name.size();
      // A dot after it may end the sentence, but not a name.
      const bool is_whole =
          (at == 0 || !isPartOfName(text[at - 1])) &&
          (end == text.size() || text[end] == '.' || !isPartOfName(text[end]));
      if (is_whole)
        text.replace(at, name.size(), replacement);
      at += is_whole ? replacement.size() : name.size();
    }
  }
  return text;
}

} // namespace tools
} // namespace pcl_ext

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/compression/voxel_grid.h>
#include <pcl_ext/filters/temporal_voxel_filter.h>

#include "bytes/exact_text.h"
#include "stream/encoder_setting.h"

#include <limits>

namespace pcl_ext::PCL_EXT_ABI::io {

namespace {

using S = EncoderSettings;
using Numbers = std::vector<double>;

constexpr double least_frames = TemporalVoxelFilter::least_frames;
constexpr double most_frames = TemporalVoxelFilter::most_frames;
constexpr double most_intervals = std::numeric_limits<unsigned int>::max();
// A decimal just below the largest float.
constexpr double largest_intensity = 3.4e38;

/** \brief A setting that is one of a table of words. */
template <auto Member, const auto& Table>
SettingAccess
wordAccess()
{
  SettingAccess access;
  access.get = [](const S& settings) -> SettingValue {
    return std::string(nameOf(Table, settings.*Member));
  };
  access.set = [](const SettingValue& value, S& settings) {
    settings.*Member = valueNamed(Table, std::get<std::string>(value)).value();
    return CompressionStatus();
  };
  for (const auto& named : Table)
    access.words.emplace_back(named.name);
  return access;
}

SettingAccess
originAccess()
{
  return {[](const S& settings) -> SettingValue {
            const auto& origin = settings.origin;
            return origin ? Numbers(origin->begin(), origin->end()) : Numbers();
          },
          [](const SettingValue& value, S& settings) {
            const auto& numbers = std::get<Numbers>(value);
            settings.origin.reset();
            if (!numbers.empty())
              settings.origin = {numbers[0], numbers[1], numbers[2]};
            return CompressionStatus();
          },
          {},
          3};
}

SettingAccess
boxAccess()
{
  return {[](const S& settings) -> SettingValue {
            Numbers corners;
            if (settings.bounding_box)
              for (const auto& corner :
                   {settings.bounding_box->min, settings.bounding_box->max})
                corners.insert(corners.end(), corner.begin(), corner.end());
            return corners;
          },
          [](const SettingValue& value, S& settings) {
            const auto& corners = std::get<Numbers>(value);
            settings.bounding_box.reset();
            if (!corners.empty())
              settings.bounding_box = {{corners[0], corners[1], corners[2]},
                                       {corners[3], corners[4], corners[5]}};
            return CompressionStatus();
          },
          {},
          6};
}

/** \brief The fields, which parseFields() reads. */
SettingAccess
fieldAccess()
{
  return {[](const S& settings) -> SettingValue {
            std::string text;
            for (const FieldSetting& field : settings.fields)
              text += (text.empty() ? "" : ",") + field.name +
                      (field.step == 0.0 ? "" : ':' + exactText(field.step));
            return text;
          },
          [](const SettingValue& value, S& settings) {
            std::vector<FieldSetting> fields;
            const auto status = parseFields(std::get<std::string>(value), fields);
            if (status.ok())
              settings.fields = fields;
            return status;
          },
          {},
          0};
}

void
addGrid(EncoderSettingTable& table)
{
  table.push_back({"resolution",
                   &S::resolution,
                   {smallest_resolution, largest_resolution, "m", ""},
                   "Edge of a voxel.",
                   {"-r,--resolution", "M", "edge of a voxel, metres, such as 0.05"},
                   {}});
  table.push_back({"origin",
                   originAccess(),
                   {0.0, 0.0, "m", ""},
                   "Position [x, y, z] from which voxels are counted, 2^20 each way; "
                   "version1 only; []: automatic.",
                   {"--origin",
                    "X,Y,Z",
                    "where voxels are counted from (automatic)",
                    OptionGroup::Cloud},
                   {}});
  table.push_back({"bounding_box",
                   boxAccess(),
                   {0.0, 0.0, "m", ""},
                   "Fixed grid, the box [x0, y0, z0, x1, y1, z1], outside of which "
                   "points are left out; []: that of the crop box, or it follows the "
                   "points.",
                   {"--bounding-box",
                    "BOX",
                    "fixed grid (the crop box, or it follows the points)",
                    OptionGroup::Cloud},
                   {}});
  table.push_back({"coarsen_wide_clouds",
                   &S::coarsen_wide_clouds,
                   {},
                   "Double the edge of a voxel as often as clouds wider than 2^21 of "
                   "them need, up to 16-fold, instead of leaving points out; not for "
                   "quadratic and linear.",
                   {"--coarsen",
                    "",
                    "up to 16 times larger voxels, for clouds wider than 2^21 of them",
                    OptionGroup::Cloud},
                   {}});
  table.push_back({"use_coordinate_step",
                   &S::use_coordinate_step,
                   {},
                   "Larger voxels, centred on the coordinates, for clouds whose "
                   "coordinates are all multiples of a step, as whole millimetres; not "
                   "for quadratic and linear, nor with {origin} or {bounding_box}; "
                   "version1 only.",
                   {"--use-coordinate-step",
                    "",
                    "larger voxels for coordinates of a step, as whole mm",
                    OptionGroup::Cloud},
                   {}});
}

void
addStream(EncoderSettingTable& table)
{
  table.push_back({"effort",
                   wordAccess<&S::effort, efforts>(),
                   {},
                   "Time against size; version1 only.",
                   {"-e,--effort", "", "time against size"},
                   {}});
  table.push_back({"format",
                   wordAccess<&S::format, stream_formats>(),
                   {},
                   "Bitstream: this library's own, or that which the paper's authors "
                   "published.",
                   {"--format", "", "published: that of the paper's authors"},
                   {}});
  table.push_back({"i_frame_rate",
                   &S::i_frame_rate,
                   {0.0, most_intervals, "frames", ""},
                   "Frames from one I-frame to the next; 0 and 1: I-frames only.",
                   {"--i-frame-rate", "N", "frames from one I-frame to the next"},
                   {}});
  table.push_back(
      {"i_frame_every",
       &S::i_frame_every,
       {0.001, 86400.0, "s", "the count alone"},
       "Time from one I-frame to the next, by the stamps of the clouds, so "
       "that a seek soon shows something; {i_frame_rate} may have one earlier.",
       {"--i-frame-every", "TIME", "an I-frame also after so long, as 1s"},
       {}});
  const std::string of_parts =
      "for parts of a recording that are encoded side by side, which ";
  table.push_back({"first_frame_number",
                   &S::first_frame_number,
                   {0.0, most_intervals, "", ""},
                   "Number of the first frame; version1 only.",
                   {},
                   {of_parts + "nodes do not write",
                    of_parts + "encode --jobs numbers itself",
                    of_parts + "no function of the package does"}});
}

void
addIntensities(EncoderSettingTable& table)
{
  table.push_back({"aggregation",
                   wordAccess<&S::aggregation, aggregations>(),
                   {},
                   "Intensity of several points in a voxel; automatic: mean for native "
                   "in version1, else sum.",
                   {"--aggregation", "", "what several intensities in a voxel become"},
                   {},
                   {"law"}});
  table.push_back({"intensity_bits",
                   &S::intensity_bits,
                   {1.0, 16.0, "bits", "automatic"},
                   "Bits of an intensity; published: 8.",
                   {"--intensity-bits", "N", "bits of an intensity, 1 to 16"},
                   {},
                   {"law"}});
  table.push_back(
      {"intensity_range",
       &S::intensity_range,
       {0.0, largest_intensity, "of the intensity", "automatic"},
       "Top of the scale: points, for quadratic and linear shares of a "
       "voxel face (1: a whole one, which is decoded as 255), else as in "
       "the clouds; published: 255.",
       {"--intensity-range", "I", "largest intensity; of shares of a face 1"},
       {},
       {"law"}});
  table.push_back(
      {"intensity_curve",
       wordAccess<&S::intensity_curve, intensity_curves>(),
       {},
       "Steps of the scale; companded: small intensities are exact, large "
       "ones rounded; published: linear.",
       {"--intensity-curve", "", "companded: small ones are exact, large ones rounded"},
       {},
       {"law"}});
  table.push_back({"colour_bits",
                   &S::colour_bits,
                   {1.0, 8.0, "bits", "none"},
                   "Bits of a colour channel, for clouds with colours, which can "
                   "double the bytes of a frame; version1 only.",
                   {"--colour-bits", "N", "of red, green and blue each"},
                   {}});
}

void
addPoints(EncoderSettingTable& table)
{
  table.push_back(
      {"keep_points",
       &S::keep_points,
       {},
       "Keep all points, in the order of their sensor where that hardly takes more "
       "bytes, else at the centres of their voxels; version1 only.",
       {"--keep-points",
        "",
        "keep all points, in the sensor's order where that hardly takes more",
        OptionGroup::Cloud},
       {}});
  table.push_back(
      {"keep_order",
       &S::keep_order,
       {},
       "Keep all points in their order, and rows and columns, whatever bytes "
       "that takes; version1 only.",
       {"--keep-order",
        "",
        "keep all points in their order, whatever bytes that takes; colours are "
        "rounded to {colour_bits}, 8: exact",
        OptionGroup::Cloud},
       {}});
  table.push_back(
      {"fields",
       fieldAccess(),
       {},
       "Further fields to keep, as ring,time:1e-6 (exact; in steps), or all: with "
       "{keep_points} of each point, else the mean of a voxel, or of integers "
       "the most frequent; version1 only; not with {temporal_filter}; '': none.",
       {"--fields",
        "NAME[:STEP],...",
        "further fields, or all; of voxels without {keep_points}",
        OptionGroup::Cloud},
       {}});
  table.push_back({"threads",
                   &S::threads,
                   {1.0, 256.0, "", ""},
                   "Most threads that encode a cloud; the bytes do not depend on it.",
                   {"--threads", "N", "threads for one large cloud"},
                   {}});
}

void
addFilter(EncoderSettingTable& table)
{
  table.push_back(
      {"temporal_filter",
       &S::temporal_filter,
       {least_frames, most_frames, "frames", "off"},
       "Frames over which surfaces are told from noise before they are encoded, 8 for "
       "10 to 30 Hz, so that a still scene takes few bytes; lossy; not with "
       "{keep_points}.",
       {"--temporal-filter",
        "FRAMES",
        "surfaces are told from noise over so many; lossy",
        OptionGroup::Codec,
        TemporalVoxelFilter::usual_frames},
       {}});
  const std::string of_rate =
      "RateControl sets it where it turns the filter on by itself";
  table.push_back({"temporal_filter_holds",
                   &S::temporal_filter_holds,
                   {},
                   "Show voxels for up to a quarter of a second though the cloud has "
                   "nothing near them, with {temporal_filter}.",
                   {},
                   {of_rate, of_rate, of_rate}});
}

void
addBudget(EncoderSettingTable& table)
{
  table.push_back(
      {"max_rate",
       &S::max_rate,
       {least_max_rate, most_max_rate, "bit/s", "no limit"},
       "Bits that the frames of any second may take; where they would take more, "
       "filters, bits and voxels become coarser, and clouds without room are left out.",
       {"--max-rate",
        "RATE",
        "most that a stream may take in any second, as 2Mbit/s; settings become "
        "coarser and clouds are left out to keep it; 0: no limit",
        OptionGroup::Budget},
       {}});
  table.push_back({"rate_buffer",
                   &S::rate_buffer,
                   {0.01, 1.0, "s", ""},
                   "How long, at {max_rate}, a frame may take and wait to be sent.",
                   {"--rate-buffer",
                    "S",
                    "how long a frame may be sent and wait, 0.01 to 1 s",
                    OptionGroup::Budget},
                   {},
                   {"max_rate"}});
  table.push_back({"max_encode_ms",
                   &S::max_encode_ms,
                   {0.1, 1e4, "ms", "no limit"},
                   "Time that encoding may take, on average; effort, then voxels "
                   "follow, and {max_rate} may raise the effort.",
                   {"--max-encode-ms",
                    "MS",
                    "mean time to encode; {effort} falls to keep it",
                    OptionGroup::Budget},
                   {}});
  table.push_back({"rate_temporal_filter",
                   &S::rate_temporal_filter,
                   {least_frames, most_frames, "frames", "none"},
                   "Strongest {temporal_filter} that {max_rate} may choose, where the "
                   "sensor rests.",
                   {"--rate-temporal-filter",
                    "FRAMES",
                    "most {temporal_filter} to keep {max_rate}",
                    OptionGroup::Budget},
                   {},
                   {"max_rate"}});
  table.push_back({"rate_sent_share",
                   &S::rate_sent_share,
                   {0.1, 1.0, "", ""},
                   "Share of the clouds that {max_rate} sends, leaving others out, "
                   "before it doubles the edge of a voxel; 1: for those that need each "
                   "cloud.",
                   {"--rate-sent-share",
                    "SHARE",
                    "clouds to send at least before voxels double, 1: all",
                    OptionGroup::Budget},
                   {},
                   {"max_rate"}});
  table.push_back({"rate_doublings",
                   &S::rate_doublings,
                   {0.0, 8.0, "", ""},
                   "How often {max_rate} and {max_encode_ms} may double the edge of a "
                   "voxel.",
                   {"--rate-doublings",
                    "N",
                    "how often the edge of a voxel may double",
                    OptionGroup::Budget},
                   {},
                   {"max_rate", "max_encode_ms"}});
}

EncoderSettingTable
makeTable()
{
  EncoderSettingTable table;
  addGrid(table);
  addStream(table);
  addIntensities(table);
  addPoints(table);
  addFilter(table);
  addBudget(table);
  return table;
}

} // namespace

const EncoderSettingTable&
encoderSettingTable()
{
  static const EncoderSettingTable table = makeTable();
  return table;
}

} // namespace pcl_ext::PCL_EXT_ABI::io

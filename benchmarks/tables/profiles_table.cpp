// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * The table of PCL's profiles: what who switches to this library gets for the same
 * constructor argument.
 */
#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>

#include "coders/frame_buffer.h"
#include "coders/pcl_compression.h"
#include "inputs/coloured_clouds.h"
#include "measuring/markdown_table.h"
#include "measuring/samples.h"
#include "meters/decoded_checks.h"
#include "meters/take_turns.h"
#include "tables/table_cells.h"
#include "tables/tables.h"

#include <pcl/common/io.h>
#include <pcl/compression/compression_profiles.h>

#include <algorithm>
#include <array>
#include <deque>
#include <functional>
#include <istream>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

namespace pcl_ext {
namespace measuring {

namespace {

using Profile = pcl::io::compression_Profiles_e;

/** \brief PCL's profiles, in the order of its enumeration. */
constexpr std::array<const char*, pcl::io::COMPRESSION_PROFILE_COUNT> profile_names = {
    "LOW_RES_ONLINE, without colour",
    "LOW_RES_ONLINE, with colour",
    "MED_RES_ONLINE, without colour",
    "MED_RES_ONLINE, with colour",
    "HIGH_RES_ONLINE, without colour",
    "HIGH_RES_ONLINE, with colour",
    "LOW_RES_OFFLINE, without colour",
    "LOW_RES_OFFLINE, with colour",
    "MED_RES_OFFLINE, without colour",
    "MED_RES_OFFLINE, with colour",
    "HIGH_RES_OFFLINE, without colour",
    "HIGH_RES_OFFLINE, with colour"};

template <typename PointT>
using Frames = std::vector<typename pcl::PointCloud<PointT>::Ptr>;

/** \brief Figures of one frame; sent from the coder's process to the parent's. */
struct FrameFigures {
  std::size_t bytes = 0;
  double encode_ms = 0.0;
  double decode_ms = 0.0;
  double largest_error = 0.0; ///< metres
};

/** \brief Figures of a stream in one of the classes. */
struct StreamFigures {
  Samples bytes;
  Samples encode_ms;
  Samples decode_ms;
  double largest_error = 0.0; ///< metres
};

/** \brief This library's class, with the interface of PclCompression. */
template <typename PointT>
class LibraryCompression {
public:
  using Cloud = pcl::PointCloud<PointT>;

  explicit LibraryCompression(Profile profile) : compression_(profile) {}

  void
  encode(const typename Cloud::ConstPtr& cloud, std::ostream& bytes)
  {
    throwUnlessOk(compression_.encodePointCloud(cloud, bytes));
  }

  void
  decode(std::istream& bytes, typename Cloud::Ptr& cloud)
  {
    throwUnlessOk(compression_.decodePointCloud(bytes, cloud));
  }

private:
  io::OctreePointCloudIntensityCompression<PointT> compression_;
};

/** \brief Encoder and decoder of one stream. */
template <typename PointT, template <typename> class CompressionT>
class ProfileCoder {
public:
  explicit ProfileCoder(Profile profile) : encoder_(profile), decoder_(profile) {}

  FrameFigures
  run(const typename pcl::PointCloud<PointT>::ConstPtr& cloud, bool measures_error)
  {
    FrameFigures figures;
    buffer_.restart();
    stream_.clear();
    figures.encode_ms = timeOf([&] { encoder_.encode(cloud, stream_); });
    figures.bytes = buffer_.size();
    figures.decode_ms = timeOf([&] { decoder_.decode(stream_, decoded_); });
    if (measures_error) {
      const PositionCloud::Ptr from(new PositionCloud);
      const PositionCloud::Ptr to(new PositionCloud);
      pcl::copyPointCloud(*cloud, *from);
      pcl::copyPointCloud(*decoded_, *to);
      figures.largest_error = nearestDistances(from, to).largest;
    }
    return figures;
  }

private:
  CompressionT<PointT> encoder_;
  CompressionT<PointT> decoder_;
  FrameBuffer buffer_;
  std::iostream stream_{&buffer_};
  typename pcl::PointCloud<PointT>::Ptr decoded_{new pcl::PointCloud<PointT>};
};

/** \brief What a process of one coder measures; frame 0 begins the stream anew. */
template <typename PointT, template <typename> class CompressionT>
std::function<ProcessOf<FrameFigures>::Measure()>
makeCoder(const Frames<PointT>& frames, Profile profile)
{
  using Coder = ProfileCoder<PointT, CompressionT>;
  return [&frames, profile] {
    return [&frames, profile, coder = std::shared_ptr<Coder>(), times_begun = 0](
               std::size_t index) mutable {
      if (index == 0) {
        coder = std::make_shared<Coder>(profile);
        ++times_begun;
      }
      // A repetition has the same errors.
      return coder->run(frames[index], times_begun == 1);
    };
  };
}

/** \brief What the class takes with one profile on one stream, against PCL's. */
struct Measurement {
  std::string stream; ///< name, number of frames
  std::string point_type;
  bool has_colours = false;
  int profile = 0;
  std::array<StreamFigures, 2> figures; ///< PCL's, this library's

  double
  morePercentOfBytes() const
  {
    return 100.0 * (figures[1].bytes.sum() / figures[0].bytes.sum() - 1.0);
  }

  double
  encodesFaster() const
  {
    return figures[0].encode_ms.sum() / figures[1].encode_ms.sum();
  }

  double
  decodesFaster() const
  {
    return figures[0].decode_ms.sum() / figures[1].decode_ms.sum();
  }

  bool
  hasLargerError() const
  {
    // Half the diagonal of a voxel is the largest error; how near to it the points of a
    // cloud are is chance.
    constexpr double as_large = 1.01;
    return figures[1].largest_error > as_large * figures[0].largest_error;
  }
};

/** \brief All profiles on one stream. */
template <typename PointT>
void
measureStream(const Measurement& stream,
              const Frames<PointT>& frames,
              const Options& options,
              std::vector<Measurement>& measurements)
{
  for (int index = 0; index < pcl::io::COMPRESSION_PROFILE_COUNT; ++index) {
    const auto profile = static_cast<Profile>(index);
    std::deque<ProcessOf<FrameFigures>> processes;
    processes.emplace_back("PCL", makeCoder<PointT, PclCompression>(frames, profile));
    processes.emplace_back("pcl_ext",
                           makeCoder<PointT, LibraryCompression>(frames, profile));
    measurements.push_back(stream);
    measurements.back().profile = index;
    takeTurns(stream.stream,
              frames.size(),
              options.repetitions,
              processes,
              [&](std::size_t which, std::size_t frame, const FrameFigures& measured) {
                StreamFigures& coder = measurements.back().figures[which];
                coder.bytes.keepLeast(frame, static_cast<double>(measured.bytes));
                coder.encode_ms.keepLeast(frame, measured.encode_ms);
                coder.decode_ms.keepLeast(frame, measured.decode_ms);
                coder.largest_error =
                    std::max(coder.largest_error, measured.largest_error);
              });
  }
}

/** \brief All profiles on one stream, for each point type that it has. */
void
measureStream(const InputStream& stream,
              bool is_painted,
              const Options& options,
              std::vector<Measurement>& measurements)
{
  Frames<pcl::PointXYZ> positions;
  for (const InputFrame& frame : readFrames(stream, Workload(), Keep::Preprocessed))
    positions.push_back(frame.positions);
  Measurement measurement;
  measurement.stream = stream.clouds->name() + ", " + std::to_string(positions.size());
  measurement.point_type = "PointXYZ";
  measureStream<pcl::PointXYZ>(measurement, positions, options, measurements);
  Frames<pcl::PointXYZRGB> coloured;
  if (is_painted)
    for (std::size_t i = 0; i < positions.size(); ++i)
      coloured.push_back(paint(*positions[i], static_cast<std::uint32_t>(i)));
  else
    coloured = readColouredFrames(stream);
  if (coloured.empty())
    return;
  measurement.point_type = "PointXYZRGB";
  measurement.has_colours = true;
  measureStream<pcl::PointXYZRGB>(measurement, coloured, options, measurements);
}

bool
codesColour(int profile)
{
  return pcl::io::compressionProfiles_[profile].doColorEncoding;
}

/** \brief A row for each stream, a column for each profile that codes the colours of a
 * point type with colours, or codes none of one without. */
void
printRatios(const std::vector<Measurement>& measurements,
            bool has_colours,
            std::ostream& output)
{
  MarkdownTable::Row header = {"stream, frames"};
  std::vector<MarkdownTable::Row> rows;
  for (const Measurement& measurement : measurements) {
    if (measurement.has_colours != has_colours ||
        codesColour(measurement.profile) != has_colours)
      continue;
    if (rows.empty() || rows.back().front() != measurement.stream)
      rows.push_back({measurement.stream});
    if (rows.size() == 1) {
      const std::string name =
          profile_names[static_cast<std::size_t>(measurement.profile)];
      header.push_back(name.substr(0, name.find(',')));
    }
    rows.back().push_back(signedPercent(measurement.morePercentOfBytes()) + ", " +
                          factor(measurement.encodesFaster()) + ", " +
                          factor(measurement.decodesFaster()));
  }
  MarkdownTable table(header);
  for (MarkdownTable::Row& row : rows)
    table.addRow(std::move(row));
  output << "### PCL's profiles "
         << (has_colours ? "with colour, PointXYZRGB\n\n"
                         : "without colour, PointXYZ\n\n");
  table.print(output);
}

/** \brief The measurements in which this library's class is behind PCL's. */
void
printShortcomings(const std::vector<Measurement>& measurements, std::ostream& output)
{
  MarkdownTable table({"stream, frames", "points", "profile", "behind PCL's class in"});
  std::size_t more_bytes = 0;
  std::size_t larger_error = 0;
  std::size_t slower_encoding = 0;
  std::size_t slower_decoding = 0;
  for (const Measurement& measurement : measurements) {
    std::vector<std::string> behind;
    if (measurement.morePercentOfBytes() > 0.0) {
      ++more_bytes;
      behind.push_back("bytes: " + signedPercent(measurement.morePercentOfBytes()));
    }
    if (measurement.hasLargerError()) {
      ++larger_error;
      behind.push_back(
          "largest error: " + formatted(1e3 * measurement.figures[1].largest_error, 2) +
          " mm, PCL " + formatted(1e3 * measurement.figures[0].largest_error, 2));
    }
    if (measurement.encodesFaster() < 1.0) {
      ++slower_encoding;
      behind.push_back("encoding: " + factor(measurement.encodesFaster()));
    }
    if (measurement.decodesFaster() < 1.0) {
      ++slower_decoding;
      behind.push_back("decoding: " + factor(measurement.decodesFaster()));
    }
    for (const std::string& what : behind)
      table.addRow({measurement.stream,
                    measurement.point_type,
                    profile_names[static_cast<std::size_t>(measurement.profile)],
                    what});
  }
  output << "Of " << measurements.size() << " measurements, all 12 profiles with each "
         << "point type, " << more_bytes << " have more bytes and " << larger_error
         << " a larger error than PCL's class; " << slower_encoding
         << " encode slower and " << slower_decoding << " decode slower.\n\n";
  if (more_bytes + larger_error + slower_encoding + slower_decoding != 0)
    table.print(output);
}

} // namespace

void
printProfiles(const Options& options, std::ostream& output)
{
  std::vector<Measurement> measurements;
  measureStream(openCellStream(first_sensor, options.frames),
                /* is_painted */ true,
                options,
                measurements);
  for (const InputStream& stream : openRecordedStreams(options.recordings))
    measureStream(stream, /* is_painted */ false, options, measurements);
  printRatios(measurements, /* has_colours */ false, output);
  printRatios(measurements, /* has_colours */ true, output);
  printShortcomings(measurements, output);
}

} // namespace measuring
} // namespace pcl_ext

/** \file
 * The table of PCL's profiles: what who switches to this library gets for the same
 * constructor argument.
 */
#include <pcl_ext/compression/octree_pointcloud_intensity_compression.h>

#include "coloured_clouds.h"
#include "comparison_tables.h"
#include "decoded_checks.h"
#include "frame_buffer.h"
#include "measuring/markdown_table.h"
#include "measuring/samples.h"
#include "pcl_compression.h"
#include "table_cells.h"
#include "take_turns.h"

#include <pcl/common/io.h>
#include <pcl/compression/compression_profiles.h>

#include <algorithm>
#include <array>
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

template <typename PointT, template <typename> class CompressionT>
ProcessOf<FrameFigures>
startCoder(const std::string& name,
           const Frames<PointT>& frames,
           Profile profile,
           std::size_t error_every)
{
  return ProcessOf<FrameFigures>(name, [&frames, profile, error_every] {
    const auto coder =
        std::make_shared<std::unique_ptr<ProfileCoder<PointT, CompressionT>>>();
    const auto times_begun = std::make_shared<unsigned int>(0);
    return [&frames, profile, error_every, coder, times_begun](std::size_t index) {
      if (index == 0) {
        *coder = std::make_unique<ProfileCoder<PointT, CompressionT>>(profile);
        ++*times_begun;
      }
      // A repetition has the same errors.
      const bool measures_error =
          error_every != 0 && index % error_every == 0 && *times_begun == 1;
      return (*coder)->run(frames[index], measures_error);
    };
  });
}

/** \brief Rows in which this library's class is behind PCL's. */
struct Shortcomings {
  std::size_t rows = 0;
  std::size_t more_bytes = 0;
  std::size_t larger_error = 0;
  std::size_t slower_encoding = 0;
  std::size_t slower_decoding = 0;
};

void
addRow(Profile profile,
       const StreamFigures& pcl,
       const StreamFigures& library,
       MarkdownTable& table,
       Shortcomings& shortcomings)
{
  // Half the diagonal of a voxel is the largest error; how near to it the points of a
  // cloud are is chance.
  constexpr double as_large = 1.01;
  const double encoding = pcl.encode_ms.sum() / library.encode_ms.sum();
  const double decoding = pcl.decode_ms.sum() / library.decode_ms.sum();
  table.addRow({profile_names[static_cast<std::size_t>(profile)],
                formatted(pcl.bytes.mean(), 0),
                formatted(library.bytes.mean(), 0),
                formatted(library.bytes.sum() / pcl.bytes.sum(), 2),
                formatted(1000.0 * pcl.largest_error, 2),
                formatted(1000.0 * library.largest_error, 2),
                formatted(encoding, 2) + "x",
                formatted(decoding, 2) + "x"});
  ++shortcomings.rows;
  shortcomings.more_bytes += library.bytes.sum() > pcl.bytes.sum() ? 1 : 0;
  shortcomings.larger_error +=
      library.largest_error > as_large * pcl.largest_error ? 1 : 0;
  shortcomings.slower_encoding += encoding < 1.0 ? 1 : 0;
  shortcomings.slower_decoding += decoding < 1.0 ? 1 : 0;
}

/** \brief All profiles on one stream. */
template <typename PointT>
void
printStream(const std::string& title,
            const Frames<PointT>& frames,
            const ComparisonOptions& options,
            Shortcomings& shortcomings,
            std::ostream& output)
{
  MarkdownTable table({"profile",
                       "bytes, PCL",
                       "pcl_ext",
                       "ratio",
                       "largest error mm, PCL",
                       "pcl_ext",
                       "encodes faster",
                       "decodes faster"});
  for (int index = 0; index < pcl::io::COMPRESSION_PROFILE_COUNT; ++index) {
    const auto profile = static_cast<Profile>(index);
    std::vector<ProcessOf<FrameFigures>> processes;
    processes.push_back(startCoder<PointT, PclCompression>(
        "PCL", frames, profile, options.error_every));
    processes.push_back(startCoder<PointT, LibraryCompression>(
        "pcl_ext", frames, profile, options.error_every));
    std::array<StreamFigures, 2> figures;
    takeTurns(title,
              frames.size(),
              options.repetitions,
              processes,
              [&](std::size_t which, std::size_t frame, const FrameFigures& measured) {
                StreamFigures& stream = figures[which];
                stream.bytes.keepLeast(frame, static_cast<double>(measured.bytes));
                stream.encode_ms.keepLeast(frame, measured.encode_ms);
                stream.decode_ms.keepLeast(frame, measured.decode_ms);
                stream.largest_error =
                    std::max(stream.largest_error, measured.largest_error);
              });
    addRow(profile, figures[0], figures[1], table, shortcomings);
  }
  output << "### PCL's profiles, " << title << "\n\n";
  table.print(output);
  output.flush();
}

/** \brief All profiles on one stream, for each point type that it has. */
void
printStream(const InputStream& stream,
            bool is_painted,
            const ComparisonOptions& options,
            Shortcomings& shortcomings,
            std::ostream& output)
{
  Frames<pcl::PointXYZ> positions;
  for (const InputFrame& frame : readFrames(stream, Workload(), Keep::Preprocessed))
    positions.push_back(frame.positions);
  const std::string title =
      stream.clouds->name() + ", " + std::to_string(positions.size()) + " frames, ";
  printStream<pcl::PointXYZ>(
      title + "PointXYZ", positions, options, shortcomings, output);
  Frames<pcl::PointXYZRGB> coloured;
  if (is_painted)
    for (std::size_t i = 0; i < positions.size(); ++i)
      coloured.push_back(paint(*positions[i], static_cast<std::uint32_t>(i)));
  else
    coloured = readColouredFrames(stream);
  if (!coloured.empty())
    printStream<pcl::PointXYZRGB>(
        title + "PointXYZRGB", coloured, options, shortcomings, output);
}

} // namespace

void
printProfiles(const ComparisonOptions& options, std::ostream& output)
{
  Shortcomings shortcomings;
  printStream(openCellStream(options.sensor, options.frames),
              /* is_painted */ true,
              options,
              shortcomings,
              output);
  for (const InputStream& stream : openRecordedStreams(options.recordings))
    printStream(stream, /* is_painted */ false, options, shortcomings, output);
  output << "Of " << shortcomings.rows << " rows " << shortcomings.more_bytes
         << " have more bytes and " << shortcomings.larger_error
         << " a larger error than PCL's class; " << shortcomings.slower_encoding
         << " encode slower and " << shortcomings.slower_decoding
         << " decode slower.\n\n";
}

} // namespace measuring
} // namespace pcl_ext

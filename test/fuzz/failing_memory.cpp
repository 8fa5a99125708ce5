/** \file
 * Fuzz target: memory runs out at any allocation of any call, once or from then on.
 *
 * encode and decode never throw; a call in which no allocation failed succeeds, and one
 * that fails says OutOfMemory. Behind an encoder's failure its next frame is an
 * I-frame, and a decoder that follows gets this one and all others right. A decoder
 * that says Ok has exactly what was sent, and after a failure it takes the next I-frame
 * at the latest. A voxelizer may throw std::bad_alloc; called again it has the voxels
 * that it would have had.
 *
 * The first byte chooses the stream; for each frame follow a byte of choices and the
 * number of allocations that succeed.
 */
#include <pcl_ext/compression/point_view.h>

#include "checked_decoding.h"
#include "small_streams.h"
#include "support/test_memory.h"
#include "voxelizing/voxelizer.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <new>
#include <optional>
#include <utility>
#include <vector>

namespace {

using namespace pcl_ext::fuzz;
using namespace pcl_ext::io;

constexpr std::size_t frames_of_stream = 12;

enum Choice : std::uint8_t {
  fails = 1,
  fails_lastingly = 2,
  is_tried_again = 4,   // after a failure
  requests_i_frame = 8, // encoder
  forgets_decoder = 16, // a new one takes over
  allocations_shift = 5 // above: a few of the allocations that succeed
};

/** \brief What an input says of one frame. */
class FrameChoices {
public:
  explicit FrameChoices(FuzzInput& input) : choices_(input.byte())
  {
    // The first frame of a stream takes a hundred allocations or two, later ones a few.
    if ((choices_ & fails) != 0)
      allocations_ = (choices_ >> allocations_shift) + std::size_t{input.byte()};
  }

  bool
  has(Choice choice) const
  {
    return (choices_ & choice) != 0;
  }

  /** \brief Calls a function while memory may run out; it must not throw.
   * \return whether memory ran out
   */
  template <typename FunctionT>
  bool
  run(const FunctionT& function) const
  {
    std::optional<pcl_ext::test::FailingAllocation> failing;
    if (has(fails))
      failing.emplace(allocations_ + 1, has(fails_lastingly));
    bool has_thrown = false;
    try {
      function();
    }
    catch (...) {
      has_thrown = true;
    }
    const bool has_run_out = failing && failing->hasFailed();
    // First of all: the report of a broken promise needs memory.
    failing.reset();
    require(!has_thrown);
    return has_run_out;
  }

private:
  std::uint8_t choices_;
  std::size_t allocations_ = 0;
};

/** \brief What is encoded, and as what it is sent; made when it is first asked for. */
const SentStream&
streamOf(std::uint8_t choice)
{
  static std::map<std::uint8_t, std::unique_ptr<SentStream>> streams;
  std::unique_ptr<SentStream>& stream = streams[choice % stream_choices];
  if (!stream) {
    stream = std::make_unique<SentStream>();
    const StreamKind kind = streamKind(choice);
    sendAll(kind,
            sensorFrames(kind, choice % stream_choices, frames_of_stream, 0.04),
            5,
            1,
            *stream);
  }
  return *stream;
}

/** \brief A decoder without memory. */
void
decodeWithFailures(const SentStream& stream, FuzzInput& input)
{
  FrameDecoder decoder;
  VoxelFrame frame;
  // True if all that the frame depends on was decoded and no call failed since.
  bool is_behind_predecessor = false;
  for (const SentFrame& sent : stream.frames) {
    if (input.isAtEnd())
      return;
    const FrameChoices choices(input);
    if (choices.has(forgets_decoder)) {
      decoder = FrameDecoder();
      is_behind_predecessor = false;
    }
    const bool is_decodable = sent.is_i_frame || is_behind_predecessor;
    CompressionStatus status;
    const bool has_run_out = choices.run(
        [&] { status = decoder.decode(sent.bytes.data(), sent.bytes.size(), frame); });
    if (!status.ok()) {
      requireReason(status, frame);
      require(!is_decodable ||
              (has_run_out && status.code() == CompressionCode::OutOfMemory));
      if (choices.has(is_tried_again)) {
        status = decoder.decode(sent.bytes.data(), sent.bytes.size(), frame);
        require(status.ok() || !sent.is_i_frame);
      }
    }
    // A frame whose reference was not decoded must not be decoded.
    require(!status.ok() || (is_decodable && isSame(sent, frame, decoder.stamp())));
    is_behind_predecessor = status.ok();
  }
}

/** \brief An encoder without memory, and a decoder that follows. */
void
encodeWithFailures(const SentStream& stream, FuzzInput& input)
{
  FrameEncoder encoder(stream.kind.format, 5, stream.kind.effort);
  FrameDecoder decoder;
  VoxelFrame decoded;
  SentFrame sent;
  sent.kind = &stream.kind;
  bool has_failed = false;
  for (const SentFrame& model : stream.frames) {
    if (input.isAtEnd())
      return;
    const FrameChoices choices(input);
    sent.sensor_frame = model.sensor_frame;
    const VoxelFrame& voxels = sent.sensor_frame.voxels;
    const std::optional<FrameStamp>& stamp = sent.sensor_frame.stamp;
    if (choices.has(requests_i_frame))
      encoder.requestIFrame();
    CompressionStatus status;
    const bool has_run_out =
        choices.run([&] { status = encoder.encode(voxels, stamp, sent.bytes); });
    if (!status.ok()) {
      require(has_run_out && status.code() == CompressionCode::OutOfMemory);
      require(!status.message().empty());
      has_failed = true;
      if (!choices.has(is_tried_again))
        continue;
      require(encoder.encode(voxels, stamp, sent.bytes).ok());
    }
    require(encoder.statistics().is_i_frame || !has_failed);
    has_failed = false;
    require(decoder.decode(sent.bytes.data(), sent.bytes.size(), decoded).ok());
    require(decoder.statistics().is_i_frame == encoder.statistics().is_i_frame);
    require(isSame(sent, decoded, decoder.stamp()));
  }
}

/** \brief Lattice index and intensity of each voxel, which do not depend on where the
 * grid lies; a call that failed may have made another one. */
std::vector<std::pair<std::array<std::int64_t, 3>, float>>
voxelsOf(const VoxelFrame& frame)
{
  std::vector<std::pair<std::array<std::int64_t, 3>, float>> voxels;
  for (std::size_t i = 0; i < frame.size(); ++i)
    voxels.emplace_back(test::latticeIndex(frame, i),
                        frame.intensity_scale.value(frame.intensities[i]));
  std::sort(voxels.begin(), voxels.end());
  return voxels;
}

/** \brief A voxelizer without memory against one with. */
void
voxelizeWithFailures(FuzzInput& input)
{
  IntensityCompressionSettings settings;
  settings.resolution = 0.1;
  const auto unit = static_cast<pcl_ext::IntensityUnit>(input.byte() % 3);
  Voxelizer voxelizer(settings, unit);
  Voxelizer reference(settings, unit);
  VoxelFrame frame;
  VoxelFrame expected;
  while (!input.isAtEnd()) {
    const FrameChoices choices(input);
    std::vector<float> points(4 * (1 + std::size_t{input.byte()} * 4));
    const std::uint32_t spread = 1 + input.byte() % 64u;
    std::uint32_t state = input.byte();
    for (float& number : points) {
      state = state * 1664525u + 1013904223u;
      number = 0.07f * static_cast<float>(state >> 16 & spread);
    }
    PointView view;
    view.coordinates = points.data();
    view.intensities = points.data() + 3;
    view.coordinate_stride = view.intensity_stride = 4 * sizeof(float);
    view.count = points.size() / 4;
    bool is_whole = true;
    choices.run([&] {
      try {
        voxelizer.voxelize(view, choices.has(requests_i_frame), frame);
      }
      catch (const std::bad_alloc&) {
        is_whole = false;
      }
    });
    if (!is_whole)
      voxelizer.voxelize(view, choices.has(requests_i_frame), frame);
    reference.voxelize(view, choices.has(requests_i_frame), expected);
    require(isConsistent(frame) && voxelsOf(frame) == voxelsOf(expected));
  }
}

} // namespace

extern "C" int
LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
  FuzzInput input(data, size);
  const std::uint8_t choice = input.byte();
  switch (choice >> 4 & 7) {
  case 0:
    voxelizeWithFailures(input);
    break;
  case 1:
  case 2:
  case 3:
    encodeWithFailures(streamOf(choice), input);
    break;
  default:
    decodeWithFailures(streamOf(choice), input);
  }
  return 0;
}

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "live/played_recording.h"

#include "console/interruption.h"
#include "inputs/recording_input.h"
#include "live/cloud_times.h"
#include "live/real_time.h"
#include "stream/frame_chain.h"
#include "streams/frame_failures.h"

#include <utility>
#include <vector>

namespace pcl_ext::tools {

bool
playRecording(recording::RecordingReader& reader,
              double rate,
              LiveOutput& output,
              Console& console,
              const std::function<void()>& meanwhile)
{
  std::vector<std::size_t> numbers; // of the streams in the output
  for (const recording::RecordedStream& stream : reader.streams())
    numbers.push_back(output.addStream(stream.name, stream.metadata));
  std::vector<CloudTimes> times(numbers.size());
  RealTime pace;
  recording::RecordedFrame frame;
  std::vector<io::FrameChain> chains(numbers.size()); // of what was published
  FrameFailures failures([&console](const std::string& line) { console.error(line); });
  bool is_whole = true;
  while (!isInterrupted()) {
    const auto status = reader.next(frame);
    if (status.code() == recording::RecordingCode::EndOfRecording)
      break;
    if (!status.ok())
      continue; // it is among the damage
    if (chains[frame.stream].take(frame.description,
                                  frame.bytes.data(),
                                  frame.bytes.size()) != io::FrameChain::Place::Next) {
      failures.add(
          reader.streams()[frame.stream].name, frame.number, "", undecodable_frame);
      is_whole = false;
      continue;
    }
    const bool has_time = reader.streams()[frame.stream].has_times;
    const auto time =
        has_time
            ? frame.time
            : std::chrono::duration_cast<recording::Time>(std::chrono::duration<double>(
                  static_cast<double>(frame.number) / rate));
    // Frames that are late are sent, as those after them need them.
    pace.waitFor(time, meanwhile);
    if (!isInterrupted())
      output.publish(numbers[frame.stream],
                     times[frame.stream].timeOf(frame.stamp, time),
                     std::move(frame.bytes));
  }
  output.end();
  failures.finish();
  for (const recording::RecordingDamage& damage : reader.damage())
    console.error(describe(damage));
  return is_whole && reader.damage().empty();
}

} // namespace pcl_ext::tools

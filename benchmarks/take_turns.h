/** \file
 * \brief Measurements in turns, each in a process of its own.
 */
#pragma once

#include "measuring_process.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace pcl_ext {
namespace measuring {

/** \brief A MeasuringProcess whose results are a struct of plain numbers. */
template <typename FiguresT>
class ProcessOf {
  static_assert(std::is_trivially_copyable<FiguresT>::value,
                "figures go from one process to another as bytes");

public:
  using Measure = std::function<FiguresT(std::size_t frame)>;

  /** \param[in] name for messages
   * \param[in] make see MeasuringProcess
   */
  ProcessOf(std::string name, const std::function<Measure()>& make)
  : name_(std::move(name))
  , process_(std::make_unique<MeasuringProcess>([make]() -> MeasuringProcess::Measure {
    return [measure = make()](std::size_t frame) {
      const FiguresT figures = measure(frame);
      std::vector<char> bytes(sizeof(figures));
      std::memcpy(bytes.data(), &figures, sizeof(figures));
      return bytes;
    };
  }))
  {}

  /** \brief Measures a frame in the process.
   * \throws std::runtime_error with name and message if that failed
   */
  FiguresT
  measure(std::size_t frame)
  {
    try {
      const std::vector<char> bytes = process_->measure(frame);
      FiguresT figures;
      if (bytes.size() != sizeof(figures))
        throw std::runtime_error("a result of another size");
      std::memcpy(&figures, bytes.data(), sizeof(figures));
      return figures;
    }
    catch (const std::exception& error) {
      throw std::runtime_error("frame " + std::to_string(frame) + ", " + name_ + ": " +
                               error.what());
    }
  }

private:
  std::string name_;
  std::unique_ptr<MeasuringProcess> process_;
};

/** \brief Frames of a turn. Few, so that other load on the machine affects all alike;
 * not one, as the caches would then be filled by another process before each frame,
 * which doubles the times of PCL's class. */
constexpr std::size_t frames_of_a_turn = 10;

/** \brief Measures a stream in all processes, in turns of some frames. Only one process runs
 * at a time; another one is the first in each round.
 * \param[in] stream its name, for messages
 * \param[in] frames number of frames
 * \param[in,out] processes the measurements
 * \param[in] repetitions of the stream; measuring frame 0 restarts it
 * \param[in] add takes the index of a process, the index of a frame and its figures
 */
template <typename FiguresT, typename AddT>
void
takeTurns(const std::string& stream,
          std::size_t frames,
          std::size_t repetitions,
          std::vector<ProcessOf<FiguresT>>& processes,
          const AddT& add)
{
  std::size_t first = 0;
  for (std::size_t begin = 0; begin < frames * repetitions; ++first) {
    const std::size_t end_of_stream = (begin / frames + 1) * frames;
    const std::size_t end = std::min(begin + frames_of_a_turn, end_of_stream);
    for (std::size_t turn = 0; turn < processes.size(); ++turn) {
      const std::size_t which = (first + turn) % processes.size();
      try {
        for (std::size_t i = begin; i < end; ++i)
          add(which, i % frames, processes[which].measure(i % frames));
      }
      catch (const std::exception& error) {
        throw std::runtime_error(stream + ", " + error.what());
      }
    }
    begin = end;
  }
}

} // namespace measuring
} // namespace pcl_ext

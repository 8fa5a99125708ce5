// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Measurements in turns, each in a process of its own.
 */
#pragma once

#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstddef>
#include <deque>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>
#include <system_error>
#include <type_traits>
#include <utility>

namespace pcl_ext {
namespace measuring {

/** \brief Runs a measurement in a process of its own, frame by frame.
 *
 * Coders that are compared must not share a heap: PCL's class, which allocates each
 * node of its tree, is several times slower in a heap that others have fragmented.
 * \tparam FiguresT a struct of plain numbers
 */
template <typename FiguresT>
class ProcessOf {
  static_assert(std::is_trivially_copyable<FiguresT>::value,
                "figures go from one process to another as bytes");

public:
  using Measure = std::function<FiguresT(std::size_t frame)>;

  /** \brief Starts the process.
   * \param[in] name for messages
   * \param[in] make called in the new process; what it returns is called for every
   * frame
   * \throws std::system_error if there is no new process
   */
  ProcessOf(std::string name, const std::function<Measure()>& make)
  : name_(std::move(name))
  {
    // Packets arrive whole.
    if (socketpair(AF_UNIX, SOCK_SEQPACKET, 0, sockets_) != 0)
      throw std::system_error(errno, std::generic_category(), "socketpair");
    process_ = fork();
    if (process_ < 0)
      throw std::system_error(errno, std::generic_category(), "fork");
    if (process_ != 0)
      return;
    // Ends with the parent, even if that is killed.
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    serve(make);
    // Not exit(), which would print what the parent has buffered.
    _exit(0);
  }

  ~ProcessOf()
  {
    send(sockets_[0], &no_more_frames, sizeof(no_more_frames), MSG_NOSIGNAL);
    waitpid(process_, nullptr, 0);
    close(sockets_[0]);
    close(sockets_[1]);
  }

  ProcessOf(const ProcessOf&) = delete;
  ProcessOf&
  operator=(const ProcessOf&) = delete;

  /** \brief Measures a frame in the process.
   * \throws std::runtime_error with name and message if that failed
   */
  FiguresT
  measure(std::size_t frame)
  {
    Result result;
    send(sockets_[0], &frame, sizeof(frame), MSG_NOSIGNAL);
    receive(result);
    if (result.message[0] != '\0')
      throw std::runtime_error("frame " + std::to_string(frame) + ", " + name_ + ": " +
                               result.message);
    return result.figures;
  }

private:
  struct Result {
    FiguresT figures;
    char message[256] = {}; ///< empty: it did not fail
  };

  /** \brief The frame number that ends a process. */
  static constexpr std::size_t no_more_frames = std::numeric_limits<std::size_t>::max();

  /** \brief Receives a result, as long as the process runs. */
  void
  receive(Result& result)
  {
    timeval second{1, 0};
    setsockopt(sockets_[0], SOL_SOCKET, SO_RCVTIMEO, &second, sizeof(second));
    while (recv(sockets_[0], &result, sizeof(result), 0) !=
           static_cast<ssize_t>(sizeof(result)))
      if (waitpid(process_, nullptr, WNOHANG) != 0)
        throw std::runtime_error(name_ +
                                 ": the process ended; is there enough memory?");
  }

  /** \brief Loop of the new process. */
  void
  serve(const std::function<Measure()>& make)
  {
    Measure measure;
    std::size_t frame = 0;
    while (recv(sockets_[1], &frame, sizeof(frame), 0) > 0 && frame != no_more_frames) {
      Result result;
      try {
        if (!measure)
          measure = make();
        result.figures = measure(frame);
      }
      catch (const std::exception& error) {
        const std::string text = error.what();
        text.copy(result.message, sizeof(result.message) - 1);
      }
      send(sockets_[1], &result, sizeof(result), MSG_NOSIGNAL);
    }
  }

  std::string name_;
  pid_t process_ = -1;
  int sockets_[2] = {-1, -1}; ///< of the parent, of the process
};

/** \brief Frames of a turn. Few, so that other load on the machine affects all alike;
 * not one, as the caches would then be filled by another process before each frame,
 * which doubles the times of PCL's class. */
constexpr std::size_t frames_of_a_turn = 10;

/** \brief Measures a stream in all processes, in turns of some frames. Only one process
 * runs at a time; another one is the first in each round.
 * \param[in] stream its name, for messages
 * \param[in] frames number of frames
 * \param[in] repetitions of the stream; measuring frame 0 restarts it
 * \param[in,out] processes the measurements
 * \param[in] add takes the index of a process, the index of a frame and its figures
 */
template <typename FiguresT, typename AddT>
void
takeTurns(const std::string& stream,
          std::size_t frames,
          std::size_t repetitions,
          std::deque<ProcessOf<FiguresT>>& processes,
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

#pragma once

#include <sys/types.h>

#include <cstddef>
#include <functional>
#include <vector>

namespace pcl_ext {
namespace measuring {

/** \brief Measures one thing, frame by frame, in a process of its own.
 *
 * What is compared must not share a heap: coders that build trees of small nodes, as
 * PCL's does, become several times slower among the fragments that others leave.
 */
class MeasuringProcess {
public:
  /** \brief Measures a frame; gives whatever bytes. */
  using Measure = std::function<std::vector<char>(std::size_t frame)>;

  /** \brief Starts the process.
   * \param[in] make is called in the new process, and what it returns for every frame
   * \throws std::system_error if there is no new process
   */
  explicit MeasuringProcess(const std::function<Measure()>& make);

  /** \brief Ends the process. */
  ~MeasuringProcess();

  MeasuringProcess(const MeasuringProcess&) = delete;
  MeasuringProcess&
  operator=(const MeasuringProcess&) = delete;

  /** \brief Measures a frame there, and waits for it.
   * \throws std::runtime_error with the process's message if it failed
   */
  std::vector<char>
  measure(std::size_t frame);

private:
  pid_t process_ = -1;
  int socket_ = -1;
};

} // namespace measuring
} // namespace pcl_ext

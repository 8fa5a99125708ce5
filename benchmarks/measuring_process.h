#pragma once

#include <sys/types.h>

#include <cstddef>
#include <functional>
#include <vector>

namespace pcl_ext {
namespace measuring {

/** \brief Runs a measurement in a process of its own, frame by frame.
 *
 * Coders that are compared must not share a heap: PCL's class, which allocates each
 * node of its tree, is several times slower in a heap that others have fragmented.
 */
class MeasuringProcess {
public:
  /** \brief Measures a frame; returns any bytes. */
  using Measure = std::function<std::vector<char>(std::size_t frame)>;

  /** \brief Starts the process.
   * \param[in] make called in the new process; what it returns is called for every
   * frame
   * \throws std::system_error if there is no new process
   */
  explicit MeasuringProcess(const std::function<Measure()>& make);

  /** \brief Ends the process. */
  ~MeasuringProcess();

  MeasuringProcess(const MeasuringProcess&) = delete;
  MeasuringProcess&
  operator=(const MeasuringProcess&) = delete;

  /** \brief Measures a frame in the process.
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

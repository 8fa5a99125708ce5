#pragma once

#include <atomic>
#include <optional>
#include <string>

namespace pcl_ext_ros {

/** \brief The threshold of one stream, followed while the node runs.
 *
 * It is the parameter ~min_intensity_of/<topic>, else what ~streams said at the start,
 * else the parameter ~min_intensity, else 0.
 */
class MinIntensity {
public:
  /** \brief Follows a stream's parameters.
   * \param[in] topic resolved name of the stream
   * \param[in] from_streams what ~streams says
   * \param[in] current in use
   */
  MinIntensity(const std::string& topic,
               std::optional<float> from_streams,
               float current);

  /** \brief In use now. */
  float
  current() const
  {
    return current_;
  }

  /** \brief Reads the parameters, which roscpp keeps up to date; a wrong value is warned
   * about once and changes nothing.
   * \return true if the threshold is another one now
   */
  bool
  update();

private:
  /** \brief A parameter's value if it is set and right. */
  std::optional<float>
  read(const std::string& name);

  std::string name_of_own_;
  std::string name_for_all_;
  std::optional<float> from_streams_;
  std::atomic<float> current_; // read by other timers, too
  std::string last_warning_;
};

} // namespace pcl_ext_ros

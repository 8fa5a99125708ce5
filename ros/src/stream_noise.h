#pragma once

#include <pcl_ext/nodes/node_parameters.h>

#include <mutex>
#include <set>
#include <string>

namespace pcl_ext_ros1 {

/** \brief What is noise in one stream. It can change while the node runs, except for
 * density_unit. Thread-safe.
 *
 * Each value is that of the parameter ~<name>_of/<topic>, else that in ~streams, else that of
 * the parameter ~<name>, else the value so far.
 */
class StreamNoise {
public:
  /** \brief Reads the parameters at the start.
   * \param[in] topic resolved name of the stream
   * \param[in] from_streams values of noiseParameters() in the stream's entry of ~streams
   * \param[in] for_all those of all streams, each of which has a value
   * \throws WrongParameter
   */
  StreamNoise(std::string topic,
              const pcl_ext::nodes::ParameterValues& from_streams,
              const pcl_ext::nodes::ParameterValues& for_all);

  pcl_ext::nodes::ParameterValues
  values() const;

  /** \brief Reads the parameters again, which roscpp caches. A wrong value changes nothing;
   * there is one warning for it. */
  void
  update();

private:
  /** \brief Takes the value of a ROS parameter.
   * \param[in] name of the parameter without the node's
   * \return true if it is set, to an allowed value or another one
   */
  bool
  take(const std::string& name,
       const pcl_ext::nodes::ParameterDescription& description);

  const std::string topic_;
  const pcl_ext::nodes::ParameterValues from_streams_;
  std::set<std::string> warnings_; // that were given

  mutable std::mutex mutex_; // guards values_: timers of several threads read it
  pcl_ext::nodes::ParameterValues values_;
};

} // namespace pcl_ext_ros1

#pragma once

#include <atomic>
#include <optional>
#include <string>

namespace pcl_ext_ros {

/** \brief A setting of one stream, followed while the node runs.
 *
 * It is the parameter ~<name>_of/<topic>, else what ~streams said at the start, else the
 * parameter ~<name>, else what it was before.
 * \tparam ValueT float, for finite numbers, or bool
 */
template <typename ValueT>
class StreamParameter {
public:
  /** \brief Reads what is in force at the start, and follows it from then on.
   * \param[in] name of the setting
   * \param[in] topic resolved name of the stream
   * \param[in] from_streams what ~streams says
   * \param[in] for_all what ~<name> says
   * \throws WrongParameter
   */
  StreamParameter(const std::string& name,
                  const std::string& topic,
                  std::optional<ValueT> from_streams,
                  ValueT for_all);

  /** \brief In use now. */
  ValueT
  current() const
  {
    return current_;
  }

  /** \brief Reads the parameters, which roscpp keeps up to date; a wrong value is warned
   * about once and changes nothing.
   * \return true if the setting is another one now
   */
  bool
  update();

private:
  /** \brief A parameter's value if it is set and right. */
  std::optional<ValueT>
  read(const std::string& name);

  std::string name_of_own_;
  std::string name_for_all_;
  std::optional<ValueT> from_streams_;
  std::atomic<ValueT> current_; // read by other timers, too
  std::string last_warning_;
};

} // namespace pcl_ext_ros

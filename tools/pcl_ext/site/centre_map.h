#pragma once

#include <pcl_ext/nodes/central_node.h>

#include "console/console.h"
#include "inputs/stream_metadata.h"

#include <memory>
#include <string>

namespace pcl_ext {
namespace tools {

/** \brief An OctoMap that is fed with the streams of a site. */
struct CentreMapOptions {
  std::string path;            ///< of the .ot file; empty: no map
  double full_intensity = 4.0; ///< that counts as one hit, in the unit of the streams
  bool waits = false;          ///< for each update, as a replay can
};

/** \brief Feeds the map: with the latest frames, once a second of the clouds' time, by a
 * thread of its own, as that may take longer than from one merged frame to the next. */
class CentreMap {
public:
  /** \param[in] resolution metres
   * \param[in] console must outlive this
   * \throws UsageError if the map cannot be written
   */
  CentreMap(const CentreMapOptions& options, double resolution, Console& console);
  ~CentreMap();
  CentreMap(const CentreMap&) = delete;
  CentreMap&
  operator=(const CentreMap&) = delete;

  /** \brief Adds a stream; rays are taken from the pose that the metadata tell. */
  void
  addStream(const std::string& name, const StreamMetadata& metadata);

  /** \brief Inserts the latest frames, unless that was done within the last second, or is
   * still being done, which a replay waits for. Writes the map once a minute.
   * \param[in] node must outlive this
   * \param[in] time of the clouds
   * \throws std::runtime_error if it could not be written
   */
  void
  update(const nodes::CentralNode& node, nodes::Time time);

  /** \brief Inserts the last frames, unless that takes long or the program is
   * interrupted, and writes the map.
   * \throws std::runtime_error
   */
  void
  finish(const nodes::CentralNode& node);

private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_; // null: no map
};

} // namespace tools
} // namespace pcl_ext

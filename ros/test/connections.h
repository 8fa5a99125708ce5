/** \file
 * \brief Who is connected with whom, as the publisher itself tells; the master only knows
 * who wants to be.
 */
#pragma once

#include <cstddef>
#include <string>

namespace pcl_ext_ros {
namespace test {

/** \brief Connections over which a node sends a topic now.
 * \param[in] node_name full name; 0 if it is not there
 * \param[in] topic full name
 */
std::size_t
subscribersOf(const std::string& node_name, const std::string& topic);

/** \brief Waits until a node sends a topic to so many, or more. */
bool
waitForSubscribers(const std::string& node_name,
                   const std::string& topic,
                   std::size_t count);

} // namespace test
} // namespace pcl_ext_ros

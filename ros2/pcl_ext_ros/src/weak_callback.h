// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <utility>

namespace pcl_ext_ros {

/** \brief A callback that does nothing once its object is gone: executors of several
 * threads may call it while a container unloads the node.
 * \param[in] object whose method it calls
 * \param[in] method what it calls
 */
template <typename ObjectT, typename... Arguments>
auto
weakCallback(const std::weak_ptr<ObjectT>& object,
             void (ObjectT::*method)(Arguments...))
{
  return [object, method](Arguments... arguments) {
    if (const auto alive = object.lock())
      ((*alive).*method)(std::forward<Arguments>(arguments)...);
  };
}

} // namespace pcl_ext_ros

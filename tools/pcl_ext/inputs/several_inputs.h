// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "console/console.h"
#include "console/exit_status.h"
#include "console/interruption.h"

#include <algorithm>
#include <exception>
#include <string>
#include <vector>

namespace pcl_ext::tools {

/** \brief Does the same with each of some inputs. One that fails is told of and does not
 * keep the others from their turn.
 * \param[in] action takes an input and returns an exit status
 * \return the largest one
 */
template <typename ActionT>
int
forEachInput(const std::vector<std::string>& inputs,
             Console& console,
             const ActionT& action)
{
  if (inputs.size() == 1)
    return action(inputs.front());
  int result = all_done;
  for (const std::string& input : inputs) {
    if (isInterrupted())
      return interrupted;
    int status = something_failed;
    try {
      status = action(input);
    }
    catch (const UsageError&) {
      throw;
    }
    catch (const std::exception& error) {
      console.error(error.what());
    }
    result = std::max(result, status);
  }
  return result;
}

} // namespace pcl_ext::tools

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/status.h>

#include "options/setting_options.h"

#include <stdexcept>

namespace pcl_ext::tools {

/** \brief \throws std::runtime_error with the message of a status that is not Ok */
template <typename CodeT>
void
throwUnlessOk(const Status<CodeT>& status)
{
  if (!status.ok())
    throw std::runtime_error(messageOf(status));
}

} // namespace pcl_ext::tools

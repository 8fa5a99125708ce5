// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/view/view_server.h>

#include "console/console.h"

namespace pcl_ext::tools {

/** \brief Starts a server, tells where it is, warns if others can reach it.
 * \param[in] settings that the server was made with
 * \param[in] opens_browser whether to open its page
 * \throws std::runtime_error
 */
void
startServer(view::ViewServer& server,
            const view::ViewServerSettings& settings,
            bool opens_browser,
            Console& console);

} // namespace pcl_ext::tools

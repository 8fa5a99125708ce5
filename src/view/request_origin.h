// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief Who may ask: checks of the headers Host and Origin, and the headers that keep
 * other pages out.
 */
#pragma once

#include <pcl_ext/version.h>

#include <string>
#include <string_view>

namespace pcl_ext::PCL_EXT_ABI::view {

/** \brief True if a header Host is the name of a host with or without a port, and has
 * no other characters than these have. */
bool
isHost(std::string_view host);

/** \brief True if it is localhost or an address of loopback, with any port: others come
 * from a page whose server's name was made to point here (DNS rebinding). */
bool
isLoopbackHost(std::string_view host);

/** \brief True if a header Origin is that of a page from this host. */
bool
isSameOrigin(std::string_view origin, std::string_view host);

/** \brief The policy for the page: code and workers in itself, nothing from elsewhere.
 * \param[in] host a header Host that isHost()
 */
std::string
contentSecurityPolicy(std::string_view host);

} // namespace pcl_ext::PCL_EXT_ABI::view

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "view/connections.h"

#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>

namespace pcl_ext::PCL_EXT_ABI::view {

/** \brief Makes a connection that of a viewer of live streams.
 * \param[in] request for the WebSocket, which was checked
 */
void
serveViewer(boost::beast::tcp_stream stream,
            const boost::beast::http::request<boost::beast::http::empty_body>& request,
            ServedContent& content,
            ConnectionToken token);

} // namespace pcl_ext::PCL_EXT_ABI::view

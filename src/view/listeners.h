// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/view/view_server.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>

#include <cstdint>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::view {

/** \brief What a server listens on. */
struct Listeners {
  std::vector<boost::asio::ip::tcp::acceptor> acceptors;
  std::uint16_t port = 0;
  bool is_loopback = true;
};

/** \brief Listens.
 * \param[in] address in numbers; empty: 127.0.0.1, and ::1 where there is one
 * \param[in] port 0: a free one
 * \param[out] listeners unchanged unless Ok
 */
ViewServerStatus
listen(boost::asio::io_context& io,
       const std::string& address,
       std::uint16_t port,
       Listeners& listeners);

/** \brief Children that this process starts do not inherit a socket. */
void
closeOnExec(int descriptor);

/** \brief An address as it is in a URL on this machine: those that stand for all are
 * that of loopback. */
std::string
hostOfUrl(const boost::asio::ip::address& address);

} // namespace pcl_ext::PCL_EXT_ABI::view

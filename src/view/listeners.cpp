// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "view/listeners.h"

#include <boost/asio/ip/v6_only.hpp>

#include <fcntl.h>

#include <utility>

namespace pcl_ext::PCL_EXT_ABI::view {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

namespace {

/** \brief Opens, binds and listens; the first error. */
error_code
open(const tcp::endpoint& endpoint, tcp::acceptor& acceptor)
{
  error_code error;
  acceptor.open(endpoint.protocol(), error);
  if (error)
    return error;
  closeOnExec(acceptor.native_handle());
  acceptor.set_option(asio::socket_base::reuse_address(true), error);
  if (!error && endpoint.address().is_v6() && endpoint.address().is_loopback())
    acceptor.set_option(asio::ip::v6_only(true), error);
  if (!error)
    acceptor.bind(endpoint, error);
  if (!error)
    acceptor.listen(asio::socket_base::max_listen_connections, error);
  return error;
}

ViewServerStatus
cannotListen(const tcp::endpoint& endpoint, const error_code& error)
{
  const std::string address = "port " + std::to_string(endpoint.port()) + " of " +
                              endpoint.address().to_string();
  if (error == asio::error::address_in_use)
    return {ViewServerCode::CannotListen,
            address +
                " is taken by another program; choose another one, or 0 for one that "
                "is free"};
  return {ViewServerCode::CannotListen,
          "cannot listen on " + address + ": " + error.message()};
}

/** \brief Listens on 127.0.0.1, and on ::1 if this machine has it. */
ViewServerStatus
listenOnLoopback(asio::io_context& io, std::uint16_t port, Listeners& listeners)
{
  const bool is_chosen = port != 0;
  constexpr int most_tries = 20; // of ports that are free in one of the two
  ViewServerStatus status;
  for (int i = 0; i < (is_chosen ? 1 : most_tries); ++i) {
    tcp::endpoint endpoint(asio::ip::address_v4::loopback(), port);
    tcp::acceptor v4(io);
    if (const error_code error = open(endpoint, v4))
      return cannotListen(endpoint, error);
    listeners.port = v4.local_endpoint().port();
    endpoint = {asio::ip::address_v6::loopback(), listeners.port};
    tcp::acceptor v6(io);
    const error_code error = open(endpoint, v6);
    if (error == asio::error::address_in_use) {
      status = cannotListen(endpoint, error);
      continue;
    }
    listeners.acceptors.push_back(std::move(v4));
    if (!error)
      listeners.acceptors.push_back(std::move(v6));
    return {};
  }
  return status;
}

} // namespace

void
closeOnExec(int descriptor)
{
  ::fcntl(descriptor, F_SETFD, FD_CLOEXEC);
}

std::string
hostOfUrl(const asio::ip::address& address)
{
  if (address.is_v4())
    return address.is_unspecified() ? "127.0.0.1" : address.to_string();
  return address.is_unspecified() ? "[::1]" : "[" + address.to_string() + "]";
}

ViewServerStatus
listen(asio::io_context& io,
       const std::string& address,
       std::uint16_t port,
       Listeners& listeners)
{
  Listeners opened;
  if (address.empty()) {
    if (ViewServerStatus status = listenOnLoopback(io, port, opened); !status.ok())
      return status;
  }
  else {
    error_code error;
    const tcp::endpoint endpoint(asio::ip::make_address(address, error), port);
    if (error)
      return {ViewServerCode::InvalidArgument,
              "'" + address +
                  "' is no address in numbers, such as 192.168.1.10, 0.0.0.0 or ::"};
    opened.acceptors.emplace_back(io);
    if (const error_code failure = open(endpoint, opened.acceptors.front()))
      return cannotListen(endpoint, failure);
    opened.port = opened.acceptors.front().local_endpoint().port();
    opened.is_loopback = endpoint.address().is_loopback();
  }
  listeners = std::move(opened);
  return {};
}

} // namespace pcl_ext::PCL_EXT_ABI::view

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "view/request_origin.h"

#include <algorithm>
#include <cctype>

namespace pcl_ext::PCL_EXT_ABI::view {

namespace {

bool
areEqualIgnoringCase(std::string_view a, std::string_view b)
{
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) {
    return std::tolower(static_cast<unsigned char>(x)) ==
           std::tolower(static_cast<unsigned char>(y));
  });
}

std::string_view
withoutPort(std::string_view host)
{
  const std::size_t colon = host.rfind(':');
  const bool has_port = colon != std::string_view::npos &&
                        host.find(']', colon) == std::string_view::npos;
  return has_port ? host.substr(0, colon) : host;
}

} // namespace

bool
isHost(std::string_view host)
{
  constexpr std::size_t longest = 260;
  constexpr std::string_view others = ".-_:[]";
  return !host.empty() && host.size() <= longest &&
         std::all_of(host.begin(), host.end(), [&](char character) {
           return std::isalnum(static_cast<unsigned char>(character)) != 0 ||
                  others.find(character) != std::string_view::npos;
         });
}

bool
isLoopbackHost(std::string_view host)
{
  const std::string_view name = withoutPort(host);
  constexpr std::string_view first_byte = "127.";
  const bool is_address_of_loopback =
      name.substr(0, first_byte.size()) == first_byte &&
      name.find_first_not_of("0123456789.") == std::string_view::npos;
  return isHost(host) && (is_address_of_loopback || name == "[::1]" ||
                          areEqualIgnoringCase(name, "localhost"));
}

bool
isSameOrigin(std::string_view origin, std::string_view host)
{
  for (const std::string_view scheme : {"http://", "https://"})
    if (areEqualIgnoringCase(origin.substr(0, scheme.size()), scheme) &&
        areEqualIgnoringCase(origin.substr(scheme.size()), host))
      return true;
  return false;
}

std::string
contentSecurityPolicy(std::string_view host)
{
  // Not all browsers take 'self' for WebSockets.
  return "default-src 'none'; script-src 'unsafe-inline' 'wasm-unsafe-eval' blob:; "
         "worker-src blob:; style-src 'unsafe-inline'; img-src data: blob:; "
         "font-src data:; connect-src 'self' data: blob: ws://" +
         std::string(host) +
         "; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
}

} // namespace pcl_ext::PCL_EXT_ABI::view

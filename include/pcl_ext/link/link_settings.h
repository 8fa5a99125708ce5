// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/export.h>
#include <pcl_ext/status.h>

#include <chrono>
#include <functional>
#include <map>
#include <string>

namespace pcl_ext::PCL_EXT_ABI {

/** \addtogroup link
 * @{ */
/** \brief Carries frames between machines, by a NATS server (https://nats.io). */
namespace link {

/** \brief Time of a cloud, since 1970. */
using Time = std::chrono::nanoseconds;

/** \brief What is known of a stream besides its frames, as of a recording's channels. */
using StreamMetadata = std::map<std::string, std::string>;

/** \brief Outcomes of calls to a publisher or a subscriber. */
enum class LinkCode {
  Ok,
  InvalidSettings, ///< a setting is outside its range, or a file cannot be read
  InvalidArgument, ///< an unknown stream, a taken name, or bytes that are no frame
  CannotConnect,   ///< no server answers, or none with TLS as it is asked for
  Refused,         ///< the server does not accept user, password, token or certificate
  NotConnected,    ///< the connection is lost for the moment; the frame was not sent
  FrameTooLarge,   ///< above the server's max_payload
  NoFrame,         ///< none came in time
  EndOfReplay,     ///< all frames that the server keeps were received
  Closed,          ///< the connection is lost for good
  OutOfMemory
};

/** \brief Outcome of a call to a publisher or a subscriber. */
using LinkStatus = Status<LinkCode>;

/** \brief Which server, as whom, and for which site. Who may connect, what is encrypted
 * and who may publish what is the server's configuration, see doc/site.md. */
struct LinkSettings {
  /** \brief Addresses of the servers of a cluster, with commas between them:
   * nats://HOST:PORT, or tls://HOST:PORT for a connection that must be encrypted. One
   * may have USER:PASSWORD@ before its host, also with commas; no message has them. */
  std::string servers = "nats://127.0.0.1:4222";

  /** \brief Name of the site, the first word of all its subjects: letters, digits, - and
   * _, up to 64. */
  std::string site = "site";

  /** \brief Name of this program on the server's list of connections. */
  std::string client_name = "pcl_ext";

  std::string user;             ///< empty: none
  std::string password;         ///< of the user
  std::string token;            ///< in place of a user; empty: none
  std::string credentials_file; ///< JWT and seed, as nsc writes them; empty: none

  std::string ca_file; ///< certificates to trust, PEM; empty: those of the system
  std::string certificate_file; ///< of this client, PEM; empty: none
  std::string key_file;         ///< its private key, PEM

  /** \brief Time in which a server must answer, for each of `servers`, and in which the
   * first echo of a publisher must come. 1 ms to 1 hour. */
  std::chrono::milliseconds connect_timeout{2000};

  /** \brief Called with one sentence when the connection is lost, is there again, or the
   * server reports an error, the same one at most once in 10 s. Called by other threads;
   * must not throw. May be empty. */
  std::function<void(const std::string&)> on_event;
};

/** \brief Checks all but whether the servers answer and the files can be read. */
PCL_EXT_LINK_EXPORT LinkStatus
checkSettings(const LinkSettings& settings);

} // namespace link
/** @} */

} // namespace pcl_ext::PCL_EXT_ABI

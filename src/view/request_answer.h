// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include "view/resource.h"

#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/status.hpp>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::view {

using Request = boost::beast::http::request<boost::beast::http::empty_body>;

/** \brief Bytes of a resource that are part of an answer. */
struct AnswerPart {
  std::shared_ptr<const Resource> resource;
  std::uint64_t offset = 0;
  std::uint64_t size = 0;
};

/** \brief An answer: its head, and the parts of its content one after the other, which
 * an answer to HEAD is sent without. */
struct Answer {
  boost::beast::http::response<boost::beast::http::empty_body> head;
  std::vector<AnswerPart> parts;
};

/** \brief An answer that ends the connection.
 * \param[in] text one line
 */
Answer
errorAnswer(boost::beast::http::status status, const std::string& text);

/** \brief Why a request is refused whatever it asks for; nothing if it is not.
 * \param[in] is_loopback the server listens on loopback alone
 */
std::optional<Answer>
refuse(const Request& request, bool is_loopback);

/** \brief Why a request for a WebSocket is refused; nothing if it is not.
 * \param[in] is_live there are live streams
 */
std::optional<Answer>
refuseViewer(const Request& request, bool is_live);

/** \brief The answer to a request that is not refused.
 * \param[in] resources what is served
 * \param[in] random number for the boundary between parts
 */
Answer
answerOf(const Request& request, const Resources& resources, std::uint64_t random);

/** \brief True if a request asks for the server's metrics. */
bool
asksForMetrics(const Request& request);

/** \brief The answer to such a request, which nobody keeps.
 * \param[in] text in Prometheus' format
 */
Answer
metricsAnswer(const Request& request, const std::string& text);

} // namespace pcl_ext::PCL_EXT_ABI::view

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "view/request_answer.h"

#include "view/byte_ranges.h"
#include "view/live_messages.h"
#include "view/request_origin.h"

#include <boost/beast/http/rfc7230.hpp>

#include <string_view>

namespace pcl_ext::PCL_EXT_ABI::view {

namespace beast = boost::beast;
namespace http = beast::http;

namespace {

std::string_view
standard(beast::string_view text)
{
  return {text.data(), text.size()};
}

std::string_view
headerOf(const Request& request, http::field field)
{
  return standard(request[field]);
}

/** \brief The path that is asked for, as it came. */
std::string_view
pathOf(const Request& request)
{
  const std::string_view target = standard(request.target());
  return target.substr(0, target.find('?'));
}

void
setCommonHeaders(Answer& answer)
{
  http::response<http::empty_body>& head = answer.head;
  head.version(11);
  head.set("X-Content-Type-Options", "nosniff");
  head.set("Cross-Origin-Resource-Policy", "same-origin");
  head.set("Cross-Origin-Opener-Policy", "same-origin");
  head.set("Referrer-Policy", "no-referrer");
  head.set(http::field::cache_control, "no-cache");
}

void
addText(Answer& answer, const std::string& text)
{
  const auto resource = textResource("text/plain; charset=utf-8", text);
  answer.parts.push_back({resource, 0, resource->size()});
}

void
setLength(Answer& answer)
{
  std::uint64_t size = 0;
  for (const AnswerPart& part : answer.parts)
    size += part.size;
  answer.head.set(http::field::content_length, std::to_string(size));
}

/** \brief True if a list of entity tags has this one; weak tags are compared, too. */
bool
hasTag(std::string_view list, std::string_view tag)
{
  return list == "*" || list.find(tag) != std::string_view::npos;
}

void
addRanges(const std::vector<ByteRange>& ranges,
          const std::shared_ptr<const Resource>& resource,
          std::uint64_t random,
          Answer& answer)
{
  answer.head.result(http::status::partial_content);
  if (ranges.size() == 1) {
    answer.head.set(http::field::content_range,
                    contentRange(ranges.front(), resource->size()));
    answer.parts.push_back({resource, ranges.front().first, ranges.front().size()});
    return;
  }
  const std::string boundary = "pcl_ext_" + std::to_string(random);
  for (const ByteRange& range : ranges) {
    addText(answer,
            "\r\n--" + boundary + "\r\nContent-Type: " + resource->type() +
                "\r\nContent-Range: " + contentRange(range, resource->size()) +
                "\r\n\r\n");
    answer.parts.push_back({resource, range.first, range.size()});
  }
  addText(answer, "\r\n--" + boundary + "--\r\n");
  answer.head.set(http::field::content_type,
                  "multipart/byteranges; boundary=" + boundary);
}

/** \brief The content of an answer, by the headers about what the browser has and
 * wants. */
void
addContent(const Request& request,
           const std::shared_ptr<const Resource>& resource,
           std::uint64_t random,
           Answer& answer)
{
  const std::string_view if_range = headerOf(request, http::field::if_range);
  std::optional<std::vector<ByteRange>> ranges;
  if (if_range.empty() || if_range == resource->tag())
    ranges = parseByteRanges(headerOf(request, http::field::range), resource->size());
  if (!ranges) {
    answer.head.result(http::status::ok);
    answer.parts.push_back({resource, 0, resource->size()});
  }
  else if (ranges->empty()) {
    answer.head.result(http::status::range_not_satisfiable);
    answer.head.set(http::field::content_range,
                    "bytes */" + std::to_string(resource->size()));
  }
  else
    addRanges(*ranges, resource, random, answer);
}

bool
offersLiveProtocol(const Request& request)
{
  if (request.count(http::field::sec_websocket_protocol) == 0)
    return true;
  return http::token_list(request[http::field::sec_websocket_protocol])
      .exists(live_protocol);
}

} // namespace

Answer
errorAnswer(http::status status, const std::string& text)
{
  Answer answer;
  setCommonHeaders(answer);
  answer.head.result(status);
  answer.head.set(http::field::content_type, "text/plain; charset=utf-8");
  answer.head.keep_alive(false);
  addText(answer, text + "\n");
  setLength(answer);
  return answer;
}

std::optional<Answer>
refuse(const Request& request, bool is_loopback)
{
  if (request.method() != http::verb::get && request.method() != http::verb::head) {
    Answer answer = errorAnswer(http::status::method_not_allowed,
                                "the only methods are GET and HEAD");
    answer.head.set(http::field::allow, "GET, HEAD");
    return answer;
  }
  const std::string_view host = headerOf(request, http::field::host);
  if (request.count(http::field::host) != 1 || !isHost(host))
    return errorAnswer(http::status::bad_request,
                       "the header Host is missing or wrong");
  if (is_loopback && !isLoopbackHost(host))
    return errorAnswer(http::status::misdirected_request,
                       "this server is for this machine: name localhost");
  return std::nullopt;
}

std::optional<Answer>
refuseViewer(const Request& request, bool is_live)
{
  if (!is_live || pathOf(request) != "/api/live")
    return errorAnswer(http::status::not_found, "there is no such stream");
  const std::size_t origins = request.count(http::field::origin);
  if (origins > 1 ||
      (origins == 1 && !isSameOrigin(headerOf(request, http::field::origin),
                                     headerOf(request, http::field::host))))
    return errorAnswer(http::status::forbidden, "other pages may not read the streams");
  if (!offersLiveProtocol(request))
    return errorAnswer(http::status::bad_request,
                       std::string("the protocol is ") + live_protocol);
  return std::nullopt;
}

Answer
answerOf(const Request& request, const Resources& resources, std::uint64_t random)
{
  const auto found = resources.find(pathOf(request));
  if (found == resources.end())
    return errorAnswer(http::status::not_found, "there is no such file");
  const std::shared_ptr<const Resource>& resource = found->second;
  Answer answer;
  setCommonHeaders(answer);
  answer.head.set(http::field::content_type, resource->type());
  answer.head.set(http::field::accept_ranges, "bytes");
  answer.head.set(http::field::etag, resource->tag());
  answer.head.set("Content-Security-Policy",
                  contentSecurityPolicy(headerOf(request, http::field::host)));
  if (hasTag(headerOf(request, http::field::if_none_match), resource->tag()))
    answer.head.result(http::status::not_modified);
  else {
    addContent(request, resource, random, answer);
    setLength(answer);
  }
  answer.head.keep_alive(request.keep_alive());
  return answer;
}

bool
asksForMetrics(const Request& request)
{
  return pathOf(request) == "/metrics";
}

Answer
metricsAnswer(const Request& request, const std::string& text)
{
  Answer answer;
  setCommonHeaders(answer);
  answer.head.result(http::status::ok);
  answer.head.set(http::field::content_type,
                  "text/plain; version=0.0.4; charset=utf-8");
  answer.head.set(http::field::cache_control, "no-store");
  addText(answer, text);
  setLength(answer);
  answer.head.keep_alive(request.keep_alive());
  return answer;
}

} // namespace pcl_ext::PCL_EXT_ABI::view

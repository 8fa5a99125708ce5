// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "support/recorded_streams.h"
#include "view/byte_ranges.h"
#include "view/clients.h"
#include "view/running_server.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <random>

namespace pcl_ext::PCL_EXT_ABI::view::test {

namespace {

using recording::test::TestFolder;
using recording::test::writeBytes;

class ServedFiles : public ::testing::Test {
protected:
  ServedFiles()
  {
    std::mt19937 random(1);
    std::vector<std::string> paths;
    for (const std::size_t size : {300'001u, 1000u}) {
      Bytes bytes(size);
      for (std::uint8_t& byte : bytes)
        byte = static_cast<std::uint8_t>(random());
      contents.emplace_back(bytes.begin(), bytes.end());
      paths.push_back(folder / ("a \"b\"_" + std::to_string(paths.size()) + ".mcap"));
      writeBytes(paths.back(), bytes);
    }
    ViewServerSettings settings;
    settings.page = test_page;
    settings.name = "a <bag>";
    server = std::make_unique<ViewServer>(settings);
    EXPECT_TRUE(server->setRecording(paths).ok());
    EXPECT_TRUE(server->start().ok());
  }

  HttpAnswer
  get(const std::string& target, const std::string& headers = {})
  {
    return request(server->port(), target, headers);
  }

  void
  expectRange(const std::string& range, std::size_t first, std::size_t count)
  {
    const HttpAnswer answer = get("/api/files/0", "Range: bytes=" + range + "\r\n");
    EXPECT_EQ(answer.status, 206) << range;
    EXPECT_EQ(answer.headers.at("content-range"),
              "bytes " + std::to_string(first) + "-" +
                  std::to_string(first + count - 1) + "/300001");
    EXPECT_EQ(answer.body, contents[0].substr(first, count)) << range;
  }

  const TestFolder folder;
  std::vector<std::string> contents;
  std::unique_ptr<ViewServer> server;
};

} // namespace

TEST_F(ServedFiles, PageAndSourceAndFilesAreServed)
{
  EXPECT_EQ(server->url(), "http://127.0.0.1:" + std::to_string(server->port()) + "/");
  const HttpAnswer page = get("/?file=x#y");
  EXPECT_EQ(page.status, 200);
  EXPECT_EQ(page.body, test_page);
  EXPECT_EQ(page.headers.at("content-type"), "text/html; charset=utf-8");
  const HttpAnswer source = get("/api/source.json");
  EXPECT_EQ(source.headers.at("content-type"), "application/json");
  const auto json = nlohmann::json::parse(source.body);
  EXPECT_EQ(json["kind"], "recording");
  EXPECT_EQ(json["name"], "a <bag>");
  ASSERT_EQ(json["files"].size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(json["files"][i]["name"], "a \"b\"_" + std::to_string(i) + ".mcap");
    EXPECT_EQ(json["files"][i]["size"], contents[i].size());
    const HttpAnswer file = get("/" + json["files"][i]["url"].get<std::string>());
    EXPECT_EQ(file.status, 200);
    EXPECT_TRUE(file.body == contents[i]);
    EXPECT_EQ(file.headers.at("accept-ranges"), "bytes");
  }
}

TEST_F(ServedFiles, HeadersKeepOtherPagesOut)
{
  for (const char* target : {"/", "/api/source.json", "/api/files/0", "/nothing"}) {
    const HttpAnswer answer = get(target);
    EXPECT_EQ(answer.headers.at("x-content-type-options"), "nosniff");
    EXPECT_EQ(answer.headers.at("cross-origin-resource-policy"), "same-origin");
    EXPECT_EQ(answer.headers.count("access-control-allow-origin"), 0u);
  }
  const std::string policy = get("/").headers.at("content-security-policy");
  for (const char* part : {"default-src 'none'",
                           "'wasm-unsafe-eval'",
                           "worker-src blob:",
                           "connect-src 'self'"})
    EXPECT_TRUE(hasPart(policy, part));
}

TEST_F(ServedFiles, RangesHaveTheirBytesAndOthersAreRefusedOrIgnored)
{
  expectRange("0-299999", 0, 300'000);
  expectRange("131072-262144", 131'072, 131'073);
  expectRange("-1", 300'000, 1);
  const HttpAnswer outside = get("/api/files/0", "Range: bytes=300001-\r\n");
  EXPECT_EQ(outside.status, 416);
  EXPECT_EQ(outside.headers.at("content-range"), "bytes */300001");
  EXPECT_EQ(outside.body, "");
  EXPECT_EQ(get("/api/files/0", "Range: bytes=9-1\r\n").body.size(), 300'001u);
}

TEST_F(ServedFiles, SeveralRangesArePartsOfOneAnswer)
{
  const HttpAnswer answer =
      get("/api/files/0", "Range: bytes=5-9,-3,200000-200001\r\n");
  EXPECT_EQ(answer.status, 206);
  const std::string type = answer.headers.at("content-type");
  const std::string prefix = "multipart/byteranges; boundary=";
  ASSERT_EQ(type.rfind(prefix, 0), 0u) << type;
  const std::string boundary = "\r\n--" + type.substr(prefix.size());
  std::string expected;
  for (const auto& [first, count] :
       {std::pair{5, 5}, std::pair{299'998, 3}, std::pair{200'000, 2}})
    expected += boundary +
                "\r\nContent-Type: application/octet-stream\r\nContent-Range: bytes " +
                std::to_string(first) + "-" + std::to_string(first + count - 1) +
                "/300001\r\n\r\n" +
                contents[0].substr(static_cast<std::size_t>(first),
                                   static_cast<std::size_t>(count));
  EXPECT_EQ(answer.body, expected + boundary + "--\r\n");
}

TEST_F(ServedFiles, HeadHasTheHeadersAlone)
{
  const std::uint16_t port = server->port();
  for (const std::string headers : {"", "Range: bytes=5-9\r\n"}) {
    const HttpAnswer answer = request(port, "/api/files/0", headers, "HEAD");
    EXPECT_EQ(answer.status, headers.empty() ? 200 : 206);
    EXPECT_EQ(answer.headers.at("content-length"), headers.empty() ? "300001" : "5");
  }
  RawConnection connection(port);
  connection.send("HEAD / HTTP/1.1\r\nHost: localhost\r\n\r\n"
                  "HEAD /nothing HTTP/1.1\r\nHost: localhost\r\n\r\n");
  const std::string answers = connection.receiveAll().value_or("");
  EXPECT_FALSE(hasPart(answers, "page"));
  EXPECT_EQ(answers.substr(answers.size() - 4), "\r\n\r\n");
}

TEST_F(ServedFiles, WhatTheBrowserHasIsNotSentAgain)
{
  const std::string tag = get("/api/files/0").headers.at("etag");
  EXPECT_EQ(get("/api/files/0", "If-None-Match: " + tag + "\r\n").status, 304);
  EXPECT_EQ(get("/api/files/1", "If-None-Match: " + tag + "\r\n").status, 200);
  const std::string range = "Range: bytes=0-0\r\nIf-Range: ";
  EXPECT_EQ(get("/api/files/0", range + tag + "\r\n").status, 206);
  EXPECT_EQ(get("/api/files/0", range + "\"other\"\r\n").status, 200);
}

TEST_F(ServedFiles, OtherPathsAreNotThere)
{
  for (const char* target : {"/api/files/2",
                             "/api/files/-1",
                             "/api/files/00",
                             "/api/files/0/",
                             "/api/files/",
                             "/api/files/../files/0",
                             "/../../../../etc/passwd",
                             "/api/files/..%2f..%2f..%2fetc%2fpasswd",
                             "/%2e%2e/%2e%2e/etc/passwd",
                             "/%2e%2e%2f%2e%2e%2fetc%2fpasswd",
                             "/..\\..\\etc\\passwd",
                             "/%61pi/files/0",
                             "/etc/passwd",
                             "//etc/passwd",
                             "/api/files/0%00.html",
                             "file:///etc/passwd",
                             "http://127.0.0.1/api/files/0",
                             "/api/live",
                             "*"})
    EXPECT_EQ(get(target).status, 404) << target;
  const HttpAnswer nul = get(std::string("/api/files/0\0.html", 19));
  EXPECT_EQ(nul.status, 400);
  EXPECT_EQ(upgradeStatus(server->port(), ""), 404); // a recording has no live streams
}

TEST_F(ServedFiles, OtherMethodsAndContentsAreRefused)
{
  for (const char* method :
       {"POST", "PUT", "DELETE", "OPTIONS", "TRACE", "PATCH", "FOO"})
    EXPECT_EQ(request(server->port(), "/", "", method).status, 405) << method;
  EXPECT_EQ(get("/", "Content-Length: 5\r\n").status, 400);
  EXPECT_EQ(get("/", "Transfer-Encoding: chunked\r\n").status, 400);
  EXPECT_EQ(get("/", "X: " + std::string(20'000, 'x') + "\r\n").status, 431);
}

TEST_F(ServedFiles, OnLoopbackOtherHostsAreRefused)
{
  const std::string port = ":" + std::to_string(server->port());
  for (const std::string host :
       {"localhost", "LOCALHOST:1", "127.0.0.1", "127.8.9.1:80", "[::1]", "[::1]:8080"})
    EXPECT_EQ(get("/", "Host: " + host + "\r\n").status, 200) << host;
  for (const std::string host : {"example.org",
                                 "127.0.0.1.example.org",
                                 "localhost.example.org",
                                 "10.0.0.1",
                                 "[::2]",
                                 "127.evil"})
    EXPECT_EQ(get("/", "Host: " + host + port + "\r\n").status, 421) << host;
  EXPECT_EQ(get("/", "Host: localhost\r\nHost: localhost\r\n").status, 400);
  EXPECT_EQ(get("/", "Host: local host\r\n").status, 400);
  EXPECT_EQ(get("/", "Host: a'; script-src *\r\n").status, 400);
  EXPECT_EQ(get("/", "Host:\r\n").status, 400);
  RawConnection connection(server->port());
  connection.send("GET / HTTP/1.0\r\n\r\n");
  EXPECT_EQ(connection.receiveAll().value_or("").substr(0, 12), "HTTP/1.1 400");
}

TEST_F(ServedFiles, AConnectionServesManyRequests)
{
  RawConnection connection(server->port());
  std::string requests;
  for (int i = 0; i < 20; ++i)
    requests += "GET /api/files/1 HTTP/1.1\r\nHost: localhost\r\n\r\n";
  connection.send(requests);
  for (int i = 0; i < 20; ++i) {
    EXPECT_EQ(connection.receiveUntil("\r\n\r\n").substr(0, 15), "HTTP/1.1 200 OK");
    EXPECT_TRUE(connection.receive(1000) == contents[1]);
  }
}

TEST(ViewServer, FilesThatCannotBeReadAreRefused)
{
  ViewServer server{ViewServerSettings()};
  const ViewServerStatus status = server.setRecording({"/nowhere/x.mcap"});
  EXPECT_EQ(status.code(), ViewServerCode::InputFailed);
  EXPECT_TRUE(hasPart(status.message(), "/nowhere/x.mcap"));
  EXPECT_EQ(server.setRecording({"/"}).code(), ViewServerCode::InputFailed);
  EXPECT_TRUE(server.start().ok());
  EXPECT_EQ(server.setRecording({}).code(), ViewServerCode::InvalidArgument);
  EXPECT_EQ(server.start().code(), ViewServerCode::InvalidArgument);
}

namespace {

/** \brief The ranges of a header for a file of 1000 bytes, such as "0-9 5-5"; "whole"
 * if it is ignored. */
std::string
rangesOf(const std::string& header)
{
  const auto ranges = parseByteRanges(header, 1000);
  if (!ranges)
    return "whole";
  std::string text;
  for (const ByteRange& range : *ranges)
    text += (text.empty() ? "" : " ") + std::to_string(range.first) + "-" +
            std::to_string(range.last);
  return text;
}

} // namespace

TEST(ByteRanges, AreThoseOfTheHeaderInTheFile)
{
  const std::vector<std::pair<const char*, const char*>> cases = {
      {"0-0", "0-0"},
      {"10-19", "10-19"},
      {"999-999", "999-999"},
      {"990-", "990-999"},
      {"990-5000", "990-999"},
      {"-1", "999-999"},
      {"-1000", "0-999"},
      {"-99999999", "0-999"},
      {"0-0, 5-9 ,-2", "0-0 5-9 998-999"},
      {",0-0,,1-1,", "0-0 1-1"},
      {"2000-3000,1-2", "1-2"},
      // Outside of the file they cannot be satisfied.
      {"1000-", ""},
      {"1000-1001,5000-", ""},
      {"-0", ""}};
  for (const auto& [header, ranges] : cases)
    EXPECT_EQ(rangesOf("bytes=" + std::string(header)), ranges) << header;
  EXPECT_TRUE(parseByteRanges("bytes=-5", 0)->empty());
  EXPECT_TRUE(parseByteRanges("bytes=0-", 0)->empty());
}

TEST(ByteRanges, WrongHeadersAreIgnored)
{
  for (const char* header : {"",
                             "bytes",
                             "bytes=",
                             "bytes=,",
                             "bytes=-",
                             "bytes=5",
                             "bytes=9-5",
                             "bytes=a-b",
                             "bytes=0x1-2",
                             "bytes=+1-2",
                             "bytes=1--2",
                             "bytes=--2",
                             "bytes= 1 - 2",
                             "bytes=0-99999999999999999999999",
                             "lines=0-1",
                             "0-1"})
    EXPECT_EQ(rangesOf(header), "whole") << header;
}

TEST(ByteRanges, TooManyAreIgnored)
{
  std::string header = "bytes=0-0";
  for (std::size_t i = 1; i < max_byte_ranges; ++i)
    header += ",0-0";
  EXPECT_EQ(parseByteRanges(header, 1000)->size(), max_byte_ranges);
  EXPECT_EQ(rangesOf(header + ",0-0"), "whole");
}

} // namespace pcl_ext::PCL_EXT_ABI::view::test

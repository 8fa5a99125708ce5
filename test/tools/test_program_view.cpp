// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "tools/view_process.h"
#include "view/clients.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <csignal>
#include <filesystem>
#include <thread>

namespace pcl_ext::tools::test {

namespace {

namespace fs = std::filesystem;

using view::test::HttpAnswer;
using view::test::LiveClient;
using view::test::LiveMessage;
using view::test::request;

void
recordFolder(const TestFolder& folder, const std::string& name)
{
  fs::create_directory(folder / name);
  record({knownStream(0, 5, 5)}, folder / (name + "/" + name + "_0.mcap"));
  record({knownStream(1, 5, 5)}, folder / (name + "/" + name + "_1.mcap"));
}

} // namespace

using ProgramView = ProgramTest;

TEST_F(ProgramView, ARecordingIsServedUntilItIsInterrupted)
{
  recordTwoStreams(folder / "x.mcap");
  ViewProcess view(folder, "x.mcap");
  EXPECT_EQ(view.line(),
            "x.mcap: http://127.0.0.1:" + std::to_string(view.port()) +
                "/ (Ctrl-C ends)\n");
  EXPECT_EQ(request(view.port(), "/").body, view_page);
  const auto source =
      nlohmann::json::parse(request(view.port(), "/api/source.json").body);
  EXPECT_EQ(source["kind"], "recording");
  EXPECT_EQ(source["files"][0]["name"], "x.mcap");
  EXPECT_EQ(request(view.port(), "/api/files/0").body, textOf(folder / "x.mcap"));
  EXPECT_EQ(view.end(SIGINT), 0);
  EXPECT_EQ(view.errors(), "");
}

TEST_F(ProgramView, TheFilesOfAFolderAreServedInTheirOrder)
{
  recordFolder(folder, "bag");
  ViewProcess view(folder, "bag/");
  const auto source =
      nlohmann::json::parse(request(view.port(), "/api/source.json").body);
  EXPECT_EQ(source["name"], "bag");
  ASSERT_EQ(source["files"].size(), 2u);
  for (const std::string number : {"0", "1"}) {
    EXPECT_EQ(source["files"][std::stoul(number)]["name"], "bag_" + number + ".mcap");
    EXPECT_EQ(request(view.port(), "/api/files/" + number).body,
              textOf(folder / ("bag/bag_" + number + ".mcap")));
  }
  EXPECT_EQ(view.end(SIGTERM), 0);
}

TEST_F(ProgramView, FramesOfAPipeAreShownAsTheyArrive)
{
  const KnownStream stream = knownStream(0, 12, 5);
  ViewProcess view(folder, "-");
  LiveClient client(view.port());
  const auto expectFrames = [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const LiveMessage message = client.nextFrame().value();
      EXPECT_EQ(message.frame, stream.frames[i].bytes);
      EXPECT_EQ(message.time, stream.frames[i].time.count());
    }
  };
  client.next(); // the streams: it is a viewer from here on
  // Garbage before the frames, and a frame in pieces.
  view.write({1, 2, 3});
  for (const std::uint8_t byte : framesOf(stream, 0, 7))
    view.write({byte});
  expectFrames(0, 7);
  view.write(framesOf(stream, 7, 12));
  expectFrames(7, 12);
  view.closeInput();
  EXPECT_EQ(client.next()->text, R"({"type":"end"})");
  // One who comes later begins with the last I-frame.
  LiveClient late(view.port());
  late.next();
  EXPECT_EQ(late.nextFrame().value().frame, stream.frames[10].bytes);
  EXPECT_EQ(view.end(SIGINT), 0);
  EXPECT_TRUE(hasPart(view.errors(), "3 bytes of the standard input are no frame"));
}

TEST_F(ProgramView, TheCellIsShownLive)
{
  ViewProcess view(folder, "--cell --sensors 2 --resolution 0.1 --effort fast");
  LiveClient client(view.port());
  const auto list = nlohmann::json::parse(client.next()->text)["streams"];
  ASSERT_EQ(list.size(), 2u);
  EXPECT_EQ(list[0]["name"], "/cell_sensor_1");
  EXPECT_EQ(list[0]["metadata"]["intensity_law"], "count");
  EXPECT_EQ(list[0]["metadata"].count("sensor_pose"), 1u);
  io::FrameDecoder decoders[2];
  io::VoxelFrame voxels;
  std::int64_t last[2] = {-1, -1};
  for (int i = 0; i < 8; ++i) {
    const LiveMessage message = client.nextFrame().value();
    ASSERT_LT(message.stream, 2u);
    const auto status = decoders[message.stream].decode(
        message.frame.data(), message.frame.size(), voxels);
    ASSERT_TRUE(status.ok()) << status;
    EXPECT_GT(voxels.size(), 100u);
    EXPECT_GT(message.time, last[message.stream]);
    EXPECT_EQ(message.time % 50'000'000, 0); // of a frame of the sensor
    last[message.stream] = message.time;
  }
  EXPECT_EQ(view.end(SIGINT), 0);
}

TEST_F(ProgramView, ABrowserIsOpenedWhereThereIsADesktop)
{
  recordTwoStreams(folder / "x.mcap");
  const std::string script =
      "#!/bin/sh\necho \"$1\" > opened.part\nmv opened.part opened\n";
  writeText(folder / "xdg-open", script);
  fs::permissions(folder / "xdg-open", fs::perms::owner_all);
  const std::string path = "PATH=\"" + folder / "" + ":$PATH\" ";
  {
    ViewProcess view(folder, "x.mcap", path + "DISPLAY= WAYLAND_DISPLAY=");
  }
  {
    ViewProcess view(folder, "x.mcap --no-browser", path + "DISPLAY=:0");
  }
  EXPECT_FALSE(fs::exists(folder / "opened"));
  ViewProcess view(folder, "x.mcap", path + "DISPLAY=:0");
  for (int i = 0; i < 6000 && !fs::exists(folder / "opened"); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_EQ(textOf(folder / "opened"),
            "http://127.0.0.1:" + std::to_string(view.port()) + "/\n");
}

TEST_F(ProgramView, OthersAreLetInWithAWarningOnly)
{
  recordTwoStreams(folder / "x.mcap");
  const ViewProcess open(folder, "x.mcap --address 0.0.0.0 -q");
  EXPECT_TRUE(hasPart(open.errors(), "anyone who can reach this machine can look"));
  EXPECT_EQ(request(open.port(), "/", "Host: robot-cell.example\r\n").status, 200);
  const ViewProcess closed(folder, "x.mcap --address 127.0.0.1");
  EXPECT_EQ(closed.errors(), "");
  EXPECT_EQ(request(closed.port(), "/", "Host: robot-cell.example\r\n").status, 421);
  const std::string port = std::to_string(closed.port());
  expectFailure("view x.mcap --page page.html --port " + port,
                1,
                "port " + port + " of 127.0.0.1 is taken");
}

TEST_F(ProgramView, APageWithTheRecordingIsExported)
{
  const std::string name = "a&b<\"c'.pcxi";
  for (const std::size_t frames : {1u, 2u, 4u}) { // of several rests modulo 3
    record({knownStream(0, frames, 5)}, folder / name);
    writeText(folder / "page.html", view_page);
    const ProgramRun result = expectRun(
        "view \"a&b<\\\"c'.pcxi\" --page page.html --export out.html --overwrite");
    EXPECT_EQ(result.output.rfind("out.html: the page with ", 0), 0u) << result.output;
    const std::string html = textOf(folder / "out.html");
    const std::string before =
        "<html><head></head><body><script "
        "type=\"application/octet-stream;base64\" "
        "id=\"pcl-ext-recording\" data-name=\"a&amp;b&lt;&quot;c'.pcxi\">";
    const std::string after =
        "</script><script id=\"pcl-ext-codec\"></script></body></html>";
    ASSERT_EQ(html.rfind(before, 0), 0u) << html.substr(0, 300);
    ASSERT_EQ(html.substr(html.size() - after.size()), after);
    writeText(folder / "base64",
              html.substr(before.size(), html.size() - before.size() - after.size()));
    EXPECT_EQ(runShell("base64 -d base64 > decoded").status, 0);
    EXPECT_EQ(bytesOf(folder / "decoded"), bytesOf(folder / name));
    EXPECT_FALSE(fs::exists(folder / "out.html.unfinished"));
  }
}

TEST_F(ProgramView, WhatCannotBeShownOrExportedIsRefused)
{
  recordTwoStreams(folder / "x.mcap");
  recordFolder(folder, "bag");
  writeClouds("room", roomClouds(1));
  writeText(folder / "other.html", "<html><body></body></html>");
  writeText(folder / "used.html",
            std::string(view_page) + "<script id=\"pcl-ext-recording\">");
  writeText(folder / "page.html", view_page);
  fs::create_directory(folder / "empty");
  record({knownStream(0, 3, 5)}, folder / "large.pcxi");
  fs::resize_file(folder / "large.pcxi", 400'000'000);
  const std::string page = " --page page.html";
  const std::string pipe = "view - --page page.html --no-browser > out ";
  const std::string out = page + " --export out.html";
  expectRefusals(2,
                 {{"view" + page, "name a recording, - or --cell"},
                  {"view x.mcap --cell" + page, "without a recording"},
                  {"view x.mcap --resolution 0.1" + page, "requires --cell"},
                  {"view x.mcap --sensors 2" + page, "requires --cell"},
                  {"view --cell --sensors 7" + page, "--sensors"},
                  {"view x.mcap --port 65536" + page, "--port"},
                  {"view x.mcap --port 1 --export o.html", "excludes"},
                  {"view --cell --export o.html", "excludes"},
                  {"view -" + out, "not -"},
                  {"view x.mcap --export x.mcap" + page, "is an input"},
                  {"view x.mcap --export empty" + page, "'empty' is a folder"}});
  expectRefusals(
      1,
      {{pipe + "< /dev/null", "standard input has no frame: it is empty"},
       {pipe + "< room/000.pcd", "standard input has no frame: "},
       {pipe + "< x.mcap", "an MCAP file, which can be read when it is"},
       {"view missing.mcap" + page, "missing.mcap"},
       {"view missing.mcap --page no.html", "missing.mcap"},
       {"view room/000.pcd" + page, "is not a recording"},
       {"view room" + page, "room"},
       {"view x.mcap --page no.html", "the page 'no.html' cannot be"},
       {"view x.mcap --page other.html", "'other.html' is not the viewer's page"},
       {"view x.mcap --page used.html", "'used.html' has a recording in it"},
       {"view x.mcap --address here" + page, "'here' is no address in numbers"},
       {"view bag" + out, "pcl_ext merge bag -o one.mcap"},
       {"view missing.mcap" + out, "missing.mcap"},
       {"view x.mcap --page other.html --export out.html",
        "'other.html' is not the viewer's page"},
       {"view x.mcap --export no/out.html" + page, "no/out.html"},
       {"view empty" + out, "'empty' is no recording of rosbag2"},
       {"view large.pcxi" + out,
        "browsers take pages with 384 MB at most: take a part of it with pcl_ext "
        "cut"}});
  EXPECT_FALSE(fs::exists(folder / "out.html"));
  EXPECT_FALSE(fs::exists(folder / "out.html.unfinished"));
  expectRun("view bag/bag_0.mcap" + out);
}

TEST_F(ProgramView, TheCommandThatMakesAMissingPageIsTold)
{
  recordTwoStreams(folder / "x.mcap");
  for (const std::string prefix : {"installed", "built"}) {
    fs::create_directories(folder / prefix + "/bin");
    fs::create_directories(folder / prefix + "/share/pcl_ext");
    fs::copy_file(testedProgram(), folder / prefix + "/bin/pcl_ext");
  }
  const auto expectCommand = [&](const std::string& prefix,
                                 const std::string& command) {
    const ProgramRun result = runShell(prefix + "/bin/pcl_ext view x.mcap");
    EXPECT_EQ(result.status, 1);
    EXPECT_TRUE(hasPart(result.errors, command));
  };
  expectCommand(
      "installed",
      "the command bash viewer/build.sh makes it, as viewer/dist/viewer.html: "
      "name that with --page, or copy it to " +
          (folder / "installed/share/pcl_ext/viewer.html"));
  // In a build tree the page is a link to where the sources' script puts it.
  fs::create_symlink(folder / "sources/viewer/dist/viewer.html",
                     folder / "built/share/pcl_ext/viewer.html");
  expectCommand("built",
                "this command makes it: bash " + (folder / "sources/viewer/build.sh"));
}

} // namespace pcl_ext::tools::test

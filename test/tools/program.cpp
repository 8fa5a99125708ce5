// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "tools/program.h"

#include <pcl/io/pcd_io.h>
#include <pcl/io/ply_io.h>

#include <gtest/gtest.h>

#include <sys/wait.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <random>
#include <sstream>

namespace pcl_ext::tools::test {

namespace {

/** \brief A text without lines of progress, which a slow machine has. */
std::string
withoutProgress(const std::string& text)
{
  std::istringstream lines(text);
  std::string rest;
  for (std::string line; std::getline(lines, line);)
    if (line.find(" a second") == std::string::npos)
      rest += line + '\n';
  return rest;
}

} // namespace

std::string
testedProgram()
{
  const char* const other = std::getenv("PCL_EXT_PROGRAM");
  return other != nullptr ? other : PCL_EXT_PROGRAM;
}

ProgramRun
ProgramTest::runShell(const std::string& line) const
{
  const std::string command = "cd '" + folder / "" + "' && P='" + testedProgram() +
                              "'; (" + line + ") > .output 2> .errors";
  const int result = std::system(command.c_str());
  return {WIFEXITED(result) ? WEXITSTATUS(result) : -1,
          textOf(folder / ".output"),
          withoutProgress(textOf(folder / ".errors"))};
}

ProgramRun
ProgramTest::run(const std::string& arguments) const
{
  return runShell("\"$P\" " + arguments);
}

ProgramRun
ProgramTest::expectRun(const std::string& arguments) const
{
  ProgramRun result = run(arguments);
  EXPECT_EQ(result.status, 0) << arguments << '\n' << result.errors;
  EXPECT_EQ(result.errors, "") << arguments;
  return result;
}

void
ProgramTest::expectFailure(const std::string& arguments,
                           int status,
                           const std::string& text) const
{
  const ProgramRun result = run(arguments);
  EXPECT_EQ(result.status, status) << arguments << '\n' << result.errors;
  EXPECT_TRUE(hasPart(result.errors, text)) << arguments;
  EXPECT_EQ(result.errors.find('\n'), result.errors.size() - 1) << arguments << '\n'
                                                                << result.errors;
  EXPECT_EQ(result.errors.rfind("pcl_ext", 0), 0u) << result.errors;
}

ProgramRun
ProgramTest::expectRemark(const std::string& arguments,
                          const std::string& text,
                          int status) const
{
  ProgramRun result = run(arguments);
  EXPECT_EQ(result.status, status) << arguments << '\n' << result.errors;
  EXPECT_TRUE(hasPart(result.errors, text)) << arguments;
  return result;
}

void
ProgramTest::expectRefusals(int status, const std::vector<Refusal>& rows) const
{
  for (const Refusal& row : rows)
    expectFailure(row.arguments, status, row.text);
}

std::vector<pcl::PointCloud<pcl::PointXYZI>>
roomClouds(std::size_t frames, unsigned int seed)
{
  std::mt19937 random(seed);
  const auto error = [&random] {
    return 0.02f * (static_cast<float>(random() % 1000) / 1000.0f - 0.5f);
  };
  std::vector<pcl::PointCloud<pcl::PointXYZI>> clouds(frames);
  for (std::size_t frame = 0; frame < frames; ++frame)
    for (float x = -1.0f; x < 1.0f; x += 0.04f)
      for (float y = -1.0f; y < 1.0f; y += 0.04f) {
        pcl::PointXYZI point;
        point.x = x + error();
        point.y = y + error();
        // A step that moves.
        point.z =
            (x > -0.5f + 0.05f * static_cast<float>(frame) ? 2.0f : 1.5f) + error();
        point.intensity = std::floor(50.0f + 49.0f * std::sin(3.0f * x + y));
        clouds[frame].push_back(point);
      }
  return clouds;
}

void
ProgramTest::writeClouds(
    const std::string& name,
    const std::vector<pcl::PointCloud<pcl::PointXYZI>>& clouds) const
{
  std::filesystem::create_directories(folder / name);
  for (std::size_t i = 0; i < clouds.size(); ++i) {
    char file[40];
    std::snprintf(file, sizeof(file), "/%03zu.pcd", i);
    ASSERT_EQ(pcl::io::savePCDFileBinary(folder / (name + file), clouds[i]), 0);
  }
}

pcl::PointCloud<pcl::PointXYZI>
readCloud(const std::string& path)
{
  pcl::PointCloud<pcl::PointXYZI> cloud;
  const bool is_ply = std::filesystem::path(path).extension() == ".ply";
  EXPECT_GE(
      is_ply ? pcl::io::loadPLYFile(path, cloud) : pcl::io::loadPCDFile(path, cloud), 0)
      << path;
  return cloud;
}

std::vector<DecodedStream>
decode(const std::string& path)
{
  recording::RecordingReader reader;
  std::vector<DecodedStream> streams;
  const recording::RecordingStatus status = reader.open(path);
  EXPECT_TRUE(status.ok()) << status;
  for (std::size_t i = 0; status.ok() && i < reader.streams().size(); ++i) {
    streams.emplace_back();
    DecodedStream& stream = streams.back();
    stream.name = reader.streams()[i].name;
    recording::RecordedStreamDecoder decoder(reader, i);
    for (std::size_t number = 0; number < reader.streams()[i].frames; ++number) {
      stream.frames.emplace_back();
      stream.voxels.emplace_back();
      EXPECT_TRUE(reader.read(i, number, stream.frames.back()).ok());
      const io::CompressionStatus decoded =
          decoder.decode(stream.frames.back(), stream.voxels.back());
      EXPECT_TRUE(decoded.ok()) << path << ", frame " << number << ": " << decoded;
    }
  }
  EXPECT_TRUE(reader.damage().empty()) << path;
  EXPECT_FALSE(reader.isUnfinished()) << path;
  return streams;
}

void
expectSameFrames(const DecodedStream& stream,
                 std::size_t first,
                 const DecodedStream& part)
{
  ASSERT_LE(first + part.frames.size(), stream.frames.size());
  for (std::size_t i = 0; i < part.frames.size(); ++i)
    EXPECT_EQ(part.frames[i].bytes, stream.frames[first + i].bytes) << "frame " << i;
}

std::vector<recording::test::KnownStream>
recordTwoStreams(const std::string& path)
{
  const std::vector<recording::test::KnownStream> streams = {
      recording::test::knownStream(0, 40, 10), recording::test::knownStream(1, 31, 7)};
  recording::test::record(streams, path);
  return streams;
}

void
expectVoxels(const io::VoxelFrame& frame, const pcl::PointCloud<pcl::PointXYZI>& cloud)
{
  ASSERT_EQ(cloud.size(), frame.size());
  std::size_t i = 0;
  io::forEachVoxelCentre(frame, [&](float x, float y, float z, float intensity) {
    const pcl::PointXYZI& point = cloud[i++];
    ASSERT_FLOAT_EQ(point.x, x);
    ASSERT_FLOAT_EQ(point.y, y);
    ASSERT_FLOAT_EQ(point.z, z);
    ASSERT_FLOAT_EQ(point.intensity, intensity);
  });
}

std::size_t
filesIn(const std::string& path)
{
  return static_cast<std::size_t>(
      std::distance(std::filesystem::directory_iterator(path),
                    std::filesystem::directory_iterator()));
}

} // namespace pcl_ext::tools::test

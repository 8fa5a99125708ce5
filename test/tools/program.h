// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include "support/recorded_streams.h"
#include "support/text_parts.h"

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <gtest/gtest.h>

#include <cstddef>
#include <string>
#include <vector>

namespace pcl_ext::tools::test {

using pcl_ext::test::hasPart;
using recording::test::Bytes;
using recording::test::bytesOf;
using recording::test::framesOf;
using recording::test::knownStream;
using recording::test::KnownStream;
using recording::test::record;
using recording::test::TestFolder;
using recording::test::textOf;
using recording::test::writeBytes;
using recording::test::writeMcap;
using recording::test::writeText;

struct ProgramRun {
  int status = -1;
  std::string output;
  std::string errors;
};

/** \brief As much of the viewer's page as the program looks for. */
constexpr char view_page[] =
    "<html><head></head><body><script id=\"pcl-ext-codec\"></script></body></html>";

/** \brief The program that is tested: that of the environment variable PCL_EXT_PROGRAM,
 * else that of this build. */
std::string
testedProgram();

struct Refusal {
  std::string arguments; ///< as a shell takes them
  std::string text;      ///< that its line of error has
};

/** \brief A test with a folder, in which the program runs; its arguments are as a
 * shell takes them. */
class ProgramTest : public ::testing::Test {
protected:
  ProgramRun
  run(const std::string& arguments) const;

  /** \brief Runs a line of a shell, in which $P is the program. */
  ProgramRun
  runShell(const std::string& line) const;

  /** \brief Expects that the program does all and prints no error. */
  ProgramRun
  expectRun(const std::string& arguments) const;

  /** \brief Expects a status, and a text in what the program says of remarks and
   * errors. */
  ProgramRun
  expectRemark(const std::string& arguments,
               const std::string& text,
               int status = 0) const;

  /** \brief Expects that the program ends with a status and one line of error.
   * \param[in] text that the line has
   */
  void
  expectFailure(const std::string& arguments,
                int status,
                const std::string& text) const;

  void
  expectRefusals(int status, const std::vector<Refusal>& rows) const;

  void
  writeClouds(const std::string& name,
              const std::vector<pcl::PointCloud<pcl::PointXYZI>>& clouds) const;

  const TestFolder folder;
};

/** \brief Frames of a small room that a sensor sees, with some noise; intensity 0 to 99
 * in whole numbers. */
std::vector<pcl::PointCloud<pcl::PointXYZI>>
roomClouds(std::size_t frames, unsigned int seed = 1);

pcl::PointCloud<pcl::PointXYZI>
readCloud(const std::string& path);

/** \brief The decoded frames of a stream of a recording; all must be readable. */
struct DecodedStream {
  std::string name;
  std::vector<recording::RecordedFrame> frames;
  std::vector<io::VoxelFrame> voxels;
};
std::vector<DecodedStream>
decode(const std::string& path);

/** \brief Expects that two streams have the same frames, byte for byte.
 * \param[in] first number of the first stream's frame that is the other's first
 */
void
expectSameFrames(const DecodedStream& stream,
                 std::size_t first,
                 const DecodedStream& part);

/** \brief Records two streams: 40 frames with an I-frame every 10, and 31 every 7. */
std::vector<recording::test::KnownStream>
recordTwoStreams(const std::string& path);

void
expectVoxels(const io::VoxelFrame& frame, const pcl::PointCloud<pcl::PointXYZI>& cloud);

std::size_t
filesIn(const std::string& path);

} // namespace pcl_ext::tools::test

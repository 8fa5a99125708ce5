// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * Inputs that PCL would read as something else, take all memory for, or wait for.
 */
#include "tools/program.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <utility>

namespace pcl_ext {
namespace tools {
namespace test {

namespace {

/** \brief A PCD file with x, y, z in float32. */
std::string
pcd(const std::string& points, const std::string& data)
{
  return "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH " +
         points + "\nHEIGHT 1\nPOINTS " + points + "\nDATA " + data;
}

/** \brief A PLY file with x, y, z in float32, and red. */
std::string
ply(const std::string& format, const std::string& vertices, const std::string& data)
{
  return "ply\nformat " + format + " 1.0\nelement vertex " + vertices +
         "\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n"
         "end_header\n" +
         data;
}

Bytes
bytesOfText(const std::string& text)
{
  return {text.begin(), text.end()};
}

/** \brief A file that holds no cloud, and why. */
struct InvalidFile {
  std::string extension;
  Bytes bytes;
  std::string reason;
};

std::vector<InvalidFile>
invalidFiles()
{
  const std::string zeros(30, '\0');
  const std::string ones("\0\0\x80\x3f\0\0\x80\x3f\0\0\x80\x3f", 12);
  const std::string ten("\x0a\0\0\0", 4); // bytes that are compressed
  const auto after = [](std::string text, const char* line, const std::string& more) {
    return text.insert(text.find(line), more);
  };
  const std::pair<std::string, std::string> texts_of_pcd[] = {
      {"", "it is empty"},
      {"<PCL-OCT-COMPRESSED>x", "it is a stream of PCL's own class"},
      // Words that are no numbers.
      {pcd("2", "ascii\n1 2 3\nfoo bar baz\n"),
       "line 11: 'foo' is no number of the field 'x'"},
      {pcd("1", "ascii\n1,5 2,5 3,5\n"),
       "line 10: '1,5' is no number of the field 'x'"},
      {pcd("1", "ascii\n1 2 3x\n"), "line 10: '3x' is no number of the field 'z'"},
      // Other numbers of points than the header has.
      {pcd("2", "ascii\n1.5 2.5 3.5\n1.5 2.5\n"), "line 11 has 2 numbers, fewer"},
      {pcd("1", "ascii\n1 2 3 4\n"), "line 10 has more than 3 numbers"},
      {pcd("1", "ascii\n1 2 3\n4 5 6\n"), "lines follow the points"},
      {pcd("1", "binary\n" + std::string(24, 'a')), "12 bytes follow the points"},
      {pcd("1", "binary\n" + ones + ones), "12 bytes follow the points"},
      {pcd("4000000000", "binary\n"),
       "its header promises 4000000000 x 1 points, which is too"},
      {pcd("100000000", "binary\n"),
       "it was cut off: it has 0 bytes of points, not 1200000000"},
      // Sizes of compressed points; the second agrees with its header.
      {pcd("1", "binary_compressed\n" + ten + "\xff\xff\xff\xff" + zeros),
       "its points have 4294967295 bytes uncompressed, not the 12"},
      {pcd("357913941", "binary_compressed\n" + ten + "\xfc\xff\xff\xff" + zeros),
       "its compressed points are damaged: 10 bytes cannot stand for 4294967292"},
      // PCL's reader would write 1000 bytes after each point.
      {"VERSION 0.7\nFIELDS _ x y z\nSIZE 1 4 4 4\nTYPE U F F F\nCOUNT 1000 1 1 1\n"
       "WIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA binary_compressed\n" +
           ten + std::string("\x0c\0\0\0", 4) + zeros,
       "its compressed points are damaged"},
      // PCL 1.13 would crash on it, and on the image below.
      {after(pcd("1", "binary\n"), "SIZE", "size 4\n"),
       "its header has two lines SIZE"}};
  const std::pair<std::string, std::string> texts_of_ply[] = {
      {ply("ascii", "2", "1 2 3 4\nfoo 2 3 4\n"), "line 10: 'foo' is no number"},
      {ply("ascii", "2", "1 2 3 4\n1,5 2 3 4\n"), "line 10: '1,5' is no number"},
      {ply("ascii", "2", "1 2 3 4\n1 2 3 300\n"), "line 10: '300' is no number"},
      {ply("ascii", "2", "1 2 3 4\n1 2 3 4.5\n"), "line 10: '4.5' is no number"},
      {ply("ascii", "1", "1 2 3 4\n5 6 7 8\n"), "lines follow the points"},
      {ply("binary_little_endian", "1", std::string(36, 'a')),
       "23 bytes follow the points"},
      {ply("binary_little_endian", "1", std::string(12, 'a')), "it was cut off"},
      {ply("binary_little_endian", "900000000", ""),
       "it was cut off, or its header is wrong: it promises"},
      {after(ply("ascii", "1", "1 2 3 4\n"),
             "element",
             "obj_info num_cols 3\nobj_info num_rows 1\n"),
       "num_cols x num_rows and the number of vertices"}};
  std::vector<InvalidFile> files = {
      {".bin", kittiBytes(roomClouds(1)[0], true), "its numbers are no lengths"},
      {".bin", Bytes(17), "it has 17 bytes, which is no multiple of 16"}};
  for (const auto& [text, reason] : texts_of_pcd)
    files.push_back({".pcd", bytesOfText(text), reason});
  for (const auto& [text, reason] : texts_of_ply)
    files.push_back({".ply", bytesOfText(text), reason});
  return files;
}

} // namespace

using ProgramHostileInputs = ProgramTest;

TEST_F(ProgramHostileInputs, FilesThatAreNoCloudsAreNamedWithTheReason)
{
  for (const InvalidFile& file : invalidFiles()) {
    SCOPED_TRACE(file.extension + ": " + file.reason);
    const std::string name = "a" + file.extension;
    writeBytes(folder / name, file.bytes);
    const ProgramRun result =
        runShell("timeout 60 \"$P\" encode " + name + " -o x.pcxi");
    EXPECT_EQ(result.status, 1);
    for (const std::string& text :
         {"'" + name + "': " + file.reason, std::string("'x.pcxi' was not written")})
      EXPECT_TRUE(hasPart(result.errors, text));
    EXPECT_FALSE(std::filesystem::exists(folder / "x.pcxi"));
    EXPECT_FALSE(std::filesystem::exists(folder / "x.pcxi.unfinished"));
  }
}

TEST_F(ProgramHostileInputs, NumbersAreReadInAllWaysOfWriting)
{
  writeBytes(
      folder / "a.pcd",
      bytesOfText(pcd("3", "ascii\n+1 -.5 2e-1\r\n\nnan -nan inf\n\t1.  0 -0\n\n \n")));
  expectRun("encode a.pcd -o x.pcxi");
  EXPECT_EQ(decode(folder / "x.pcxi")[0].voxels[0].size(), 2u);
}

TEST_F(ProgramHostileInputs, CloudsUntilAFailureStayWhereItsMessageTells)
{
  writeBytes(folder / "a.pcd", bytesOfText(pcd("1", "ascii\n1 2 3\n")));
  std::string points;
  for (int i = 0; i < 2000; ++i)
    points += std::to_string(i) + " 2 3\n";
  writeBytes(folder / "b.pcd", bytesOfText(pcd("2000", "ascii\n" + points)));
  expectRun("encode a.pcd b.pcd -o x.pcxi --resolution 1");
  const ProgramRun result = runShell("ulimit -f 8; exec \"$P\" decode x.pcxi -o out");
  EXPECT_EQ(result.status, 1);
  EXPECT_TRUE(hasPart(result.errors, "File too large"));
  EXPECT_TRUE(hasPart(result.errors, "is in 'out.unfinished'"));
  EXPECT_TRUE(std::filesystem::exists(folder / "out.unfinished/000000.pcd"));
  EXPECT_FALSE(std::filesystem::exists(folder / "out"));
}

TEST_F(ProgramHostileInputs, ASignalEndsWaitingForAPipe)
{
  ASSERT_EQ(runShell("mkfifo p.mcap p.pcd; echo > page.html").status, 0);
  for (const std::string command : {"encode p.pcd -o x.mcap",
                                    "encode p.mcap -o x.mcap",
                                    "info p.mcap",
                                    "view p.mcap --export x.html --page page.html"}) {
    SCOPED_TRACE(command);
    const ProgramRun result =
        runShell("\"$P\" " + command +
                 " & until ls -l /proc/$!/fd | grep -q '/p[.]'; do kill -0 $! || "
                 "break; sleep 0.05; done; kill -TERM $!; wait $!");
    EXPECT_EQ(result.status, 130);
    EXPECT_TRUE(hasPart(result.errors, "interrupted"));
  }
}

TEST_F(ProgramHostileInputs, FilesOfTheSystemAreNotWaitedFor)
{
  // Its size is 0, and who reads it waits for the kernel's next message.
  for (const std::string command : {"encode", "merge", "info"}) {
    const ProgramRun result = runShell("timeout 20 \"$P\" " + command + " /proc/kmsg" +
                                       (command == "info" ? "" : " -o x.mcap"));
    EXPECT_EQ(result.status, 1) << command << result.errors;
  }
}

} // namespace test
} // namespace tools
} // namespace pcl_ext

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * \brief PCD and PLY files that are refused, and why: damaged ones, and those that PCL
 * would read as something else, or take all memory for.
 */
#include "clouds/file_layouts.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>

namespace pcl_ext::clouds::test {

namespace {

std::string
pcdOf(const std::string& points, const std::string& data)
{
  return "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH " +
         points + "\nHEIGHT 1\nPOINTS " + points + "\nDATA " + data;
}

std::string
plyOf(const std::string& format, const std::string& vertices, const std::string& data)
{
  return "ply\nformat " + format + " 1.0\nelement vertex " + vertices + "\n" + xyz +
         "property uchar red\nend_header\n" + data;
}

std::string
withBefore(std::string text, const char* word, const std::string& more)
{
  return text.insert(text.find(word), more);
}

} // namespace

TEST_F(FileLayouts, MorePointsThanPromisedAreLeftOutWithARemark)
{
  const std::string ones("\0\0\x80\x3f\0\0\x80\x3f\0\0\x80\x3f", 12);
  const std::pair<std::string, std::string> files[] = {
      {pcdOf("1", "ascii\n1 1 1\n4 5 6\n"),
       "lines after the points that its header promises are left out: '4 5 6'"},
      {pcdOf("1", "binary\n" + ones + ones),
       "12 bytes after the points that its header promises are left out"},
      {plyOf("ascii", "1", "1 1 1 4\n5 6 7 8\n"),
       "lines after the points that its header promises are left out: '5 6 7 8'"},
      {plyOf("binary_little_endian", "1", ones + "a" + ones + "b" + ones),
       "25 bytes after the points that its header promises are left out"}};
  for (const auto& [content, remark] : files) {
    EXPECT_EQ(read("a.cloud", content), Remarks{remark});
    EXPECT_EQ(floats("x"), std::vector<float>{1.0f});
    EXPECT_EQ(floats("z"), std::vector<float>{1.0f});
  }
}

TEST_F(FileLayouts, WhatIsNoCloudIsRefused)
{
  const std::string zeros(30, '\0');
  const std::string ten("\x0a\0\0\0", 4); // bytes that are compressed
  const std::pair<std::string, std::string> files[] = {
      {"", "it is empty"},
      {"<PCL-OCT-COMPRESSED>x", "it is a stream of PCL's own class"},
      // Words that are no numbers.
      {pcdOf("2", "ascii\n1 2 3\nfoo bar baz\n"),
       "line 11: 'foo' is no number of the field 'x'"},
      {pcdOf("1", "ascii\n1,5 2,5 3,5\n"),
       "line 10: '1,5' is no number of the field 'x'"},
      {pcdOf("1", "ascii\n1 2 3x\n"), "line 10: '3x' is no number of the field 'z'"},
      // Other numbers of points than the header has.
      {pcdOf("2", "ascii\n1.5 2.5 3.5\n1.5 2.5\n"), "line 11 has 2 numbers, fewer"},
      {pcdOf("1", "ascii\n1 2 3 4\n"), "line 10 has more than 3 numbers"},
      {pcdOf("4000000000", "binary\n"),
       "its header promises 4000000000 x 1 points, which is too"},
      {pcdOf("100000000", "binary\n"),
       "it was cut off: it has 0 bytes of points, not 1200000000"},
      // Sizes of compressed points; the second agrees with its header.
      {pcdOf("1", "binary_compressed\n" + ten + "\xff\xff\xff\xff" + zeros),
       "its points have 4294967295 bytes uncompressed, not the 12"},
      {pcdOf("357913941", "binary_compressed\n" + ten + "\xfc\xff\xff\xff" + zeros),
       "its compressed points are damaged: 10 bytes cannot stand for 4294967292"},
      // PCL's reader would write 1000 bytes after each point.
      {"VERSION 0.7\nFIELDS _ x y z\nSIZE 1 4 4 4\nTYPE U F F F\nCOUNT 1000 1 1 1\n"
       "WIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA binary_compressed\n" +
           ten + std::string("\x0c\0\0\0", 4) + zeros,
       "its compressed points are damaged"},
      // PCL 1.13 would crash on it, and on the image below.
      {withBefore(pcdOf("1", "binary\n"), "SIZE", "size 4\n"),
       "its header has two lines SIZE"},
      {plyOf("ascii", "2", "1 2 3 4\nfoo 2 3 4\n"), "line 10: 'foo' is no number"},
      {plyOf("ascii", "2", "1 2 3 4\n1,5 2 3 4\n"), "line 10: '1,5' is no number"},
      {plyOf("ascii", "2", "1 2 3 4\n1 2 3 300\n"), "line 10: '300' is no number"},
      {plyOf("ascii", "2", "1 2 3 4\n1 2 3 4.5\n"), "line 10: '4.5' is no number"},
      {plyOf("binary_little_endian", "1", std::string(12, 'a')), "it was cut off"},
      {plyOf("binary_little_endian", "900000000", ""),
       "it was cut off, or its header is wrong: it promises"},
      {withBefore(plyOf("ascii", "1", "1 2 3 4\n"),
                  "element",
                  "obj_info num_cols 3\nobj_info num_rows 1\n"),
       "num_cols x num_rows and the number of vertices"}};
  for (const auto& [file, reason] : files) {
    const std::string message = refusal("a.pcd", file);
    EXPECT_EQ(message.rfind(reason, 0), 0u) << reason << ", not: " << message;
  }
}

TEST_F(FileLayouts, FilesOfOtherProgramsAreNamedWithTheNextCommand)
{
  const std::pair<std::string, std::string> files[] = {
      {"\x1f\x8b\x08", "gzip -dk"},
      {"BZh91AY", "bzip2 -dk"},
      {"\xfd"
       "7zXZ",
       "xz -dk"},
      {"\x04\x22M\x18", "lz4 -dk"},
      {"\x28\xb5\x2f\xfd", "zstd -dk"},
      {"PK\x03\x04", "unzip"},
      {"LASF", "pdal translate"},
      {"ASTM-E57", "pdal translate"},
      {"\xd4\xc3\xb2\xa1", "ros2 bag record"},
      {"\x93NUMPY", "tofile()"},
      {"rosbag2_bagfile_information:\n", "name the folder"},
      {"version https://git-lfs.github.com/spec/v1\n", "git lfs pull"},
      {"DRACO\2\2", "draco_decoder"},
      {"1.5 2.5 3.5\n", "'FIELDS x y z'"},
      {"\xef\xbb\xbfx;y;z;H\xc3\xb6he\n", "'FIELDS x y z'"}};
  for (const auto& [bytes, command] : files) {
    expectPart(refusal("a.file", bytes), command);
    // Fields for a file without a header do not make such a file one.
    const std::string points = bytes + std::string(12 - bytes.size() % 12, '\n');
    expectPart(refusal("a.file", points, "x,y,z"), command);
    expectPart(refusal("a.bin", points, "x,y,z"), command);
    if (command != "'FIELDS x y z'") // which damaged PCD files are, too
      expectPart(refusal("a.pcd", bytes), command);
  }
  for (const std::string name : {"a.obj", "a.stl", "a.vtk"})
    expectPart(refusal(name, "v 1.5 2.5 3.5\n"), "pcl_converter");
}

TEST_F(FileLayouts, WhatContradictsItselfIsRefused)
{
  const std::string vertices = "element vertex 2\n" + xyz;
  const std::string points = "1 2 3\n4 5 6\n";
  const std::string image =
      "ply\nformat ascii 1.0\nobj_info num_cols 2\nobj_info num_rows 2\n" + vertices +
      "element range_grid 4\nproperty list uchar int vertex_indices\nend_header\n" +
      points;
  // Of 20 bytes a vertex, with which places become small again in numbers of 64 bits.
  const std::string wide_image =
      "ply\nformat ascii 1.0\nobj_info num_cols 1\nobj_info num_rows 1\n" + vertices +
      "property float a\nproperty float b\nelement range_grid 1\n"
      "property list uchar int vertex_indices\nend_header\n1 2 3 4 5\n6 7 8 9 10\n";
  const std::string sized_image =
      "ply\nformat ascii 1.0\nobj_info num_cols 2\nobj_info num_rows 1\n" + vertices;
  const std::string list =
      "\nproperty list uchar int vertex_indices\nend_header\n" + points;
  const std::string pcd = "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 2\n";
  const std::pair<std::string, std::string> files[] = {
      {"ply\n" + vertices + "end_header\n" + points, "no line format"},
      {"ply\nformat ascii 1.0\nformat binary_little_endian 1.0\n" + vertices +
           "end_header\n" + points,
       "two lines format"},
      {"ply\nformat ascii 9.9\n" + vertices + "end_header\n" + points, "version 1.0"},
      {image + "1 0\n1 1\n0\n", "cut off in its image"},
      {image + "1 0\n2 1 1\n0\n0\n", "neither empty nor"},
      {image + "1 0\n1\n0\n0\n", "neither empty nor"},
      {image + "1 0\n1 2\n0\n0\n", "a vertex that is not there"},
      {wide_image + "1 922337203685477580\n", "a vertex that is not there"},
      {image + "1 0\n1 -1\n0\n0\n", "'-1' in place of a number"},
      {"ply\nformat ascii 1.0\ncomment " + std::string(1 << 20, '-') + '\n' + vertices +
           "end_header\n" + points,
       "no line end_header"},
      {"ply\nformat binary_little_endian 1.0\nelement strip 1\n"
       "property list char uchar parts\n" +
           vertices + "end_header\n\xff" + std::string(300, '\0'),
       "negative"},
      {"VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F X\nWIDTH 2\nDATA ascii\n" +
           points,
       "unknown TYPE 'X'"},
      {pcd + "FIELDS z y x\nDATA ascii\n" + points, "two lines FIELDS"},
      {pcd + "COLUMNS z y x\nDATA ascii\n" + points, "two lines FIELDS"},
      {pcd + "SIZE 4 4 8\nDATA ascii\n" + points, "two lines SIZE"},
      {pcd + "WIDTH 1\nDATA ascii\n" + points, "two lines WIDTH"},
      {pcd + "VIEWPOINT 0 0 0 1 0 0 0\nVIEWPOINT 1 0 0 1 0 0 0\nDATA ascii\n" + points,
       "two lines VIEWPOINT"},
      {sized_image + "element range_grid 3" + list + "1 1\n1 0\n0\n",
       "number of elements range_grid"},
      {sized_image + "element range_grid 2\nproperty int vertex\nend_header\n" +
           points + "1\n0\n",
       "no lists of vertices"},
      {sized_image + "obj_info num_cols 1\nobj_info num_rows 2\nend_header\n" + points,
       "two lines num_cols"},
      {"VERSION .7\nFIELDS x y x\nSIZE 4 4 4\nTYPE F F F\nWIDTH 2\nDATA ascii\n" +
           points,
       "two fields 'x'"},
      {"ply\nformat ascii 1.0\n" + vertices +
           "property float z\nend_header\n1 2 3 4\n" + "5 6 7 8\n",
       "two fields 'z'"},
      {"ply\nformat ascii 1.0\n" + vertices + vertices + "end_header\n" + points,
       "two elements 'vertex'"},
      // Nothing to read, and no end of it.
      {"ply\nformat ascii 1.0\nobj_info num_cols 4000000000\n"
       "obj_info num_rows 4000000000\nend_header\n",
       ""},
      {"VERSION 0.7\nFIELDS x y\nSIZE 4 4\nTYPE F F\nCOUNT 0 0\nWIDTH 2000000000\n"
       "HEIGHT 1\nPOINTS 2000000000\nDATA binary_compressed\n" +
           std::string(8, '\0'),
       ""}};
  for (const auto& [file, reason] : files) {
    SCOPED_TRACE(file);
    const std::string message = refusal("a.pcd", file);
    EXPECT_NE(message, "");
    expectPart(message, reason);
  }
}

} // namespace pcl_ext::clouds::test

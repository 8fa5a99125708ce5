/** \file
 * Inputs that PCL would read as something else, take all memory for, or wait for.
 */
#include "tools/program.h"

#include <gtest/gtest.h>

#include <utility>

namespace pcl_ext {
namespace tools {
namespace test {

namespace {

/** \brief Writes a PCD file with x, y, z in float32. */
void
writePcd(const TestFolder& folder,
         const std::string& name,
         const std::string& points,
         const std::string& data)
{
  const std::string text = "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 "
                           "1 1\nWIDTH " +
                           points + "\nHEIGHT 1\nPOINTS " + points + "\nDATA " + data;
  writeBytes(folder / name, {text.begin(), text.end()});
}

/** \brief Expects that the clouds of a file are refused with a text. */
void
expectRefused(const TestFolder& folder,
              const std::string& name,
              const std::string& text)
{
  SCOPED_TRACE(name);
  const ProgramRun result =
      runShell(folder, "timeout 60 \"$P\" encode " + name + " -o x.pcxi");
  EXPECT_EQ(result.status, 1);
  EXPECT_NE(result.errors.find(text), std::string::npos) << result.errors;
}

} // namespace

TEST(ProgramHostileInputs, WordsThatAreNoNumbersAreNotReadAsNumbers)
{
  const TestFolder folder;
  writePcd(folder, "a.pcd", "2", "ascii\n1 2 3\nfoo bar baz\n");
  expectRefused(folder, "a.pcd", "line 11: 'foo' is no number of the field 'x'");
  writePcd(folder, "b.pcd", "1", "ascii\n1,5 2,5 3,5\n");
  expectRefused(folder, "b.pcd", "line 10: '1,5' is no number of the field 'x'");
  writePcd(folder, "c.pcd", "1", "ascii\n1 2 3x\n");
  expectRefused(folder, "c.pcd", "line 10: '3x' is no number of the field 'z'");
  writePcd(folder, "d.pcd", "2", "ascii\n1.5 2.5 3.5\n1.5 2.5\n");
  expectRefused(folder, "d.pcd", "line 11 has 2 numbers, fewer");
  writePcd(folder, "e.pcd", "1", "ascii\n1 2 3 4\n");
  expectRefused(folder, "e.pcd", "line 10 has more than 3 numbers");
  writePcd(folder, "f.pcd", "1", "ascii\n1 2 3\n4 5 6\n");
  expectRefused(folder, "f.pcd", "lines follow the points");
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
      "property float z\nproperty uchar red\nend_header\n1 2 3 4\n";
  for (const auto& [line, text] : {std::pair("foo 2 3 4", "'foo' is no number"),
                                   std::pair("1,5 2 3 4", "'1,5' is no number"),
                                   std::pair("1 2 3 300", "'300' is no number"),
                                   std::pair("1 2 3 4.5", "'4.5' is no number")}) {
    const std::string file = ply + line + "\n";
    writeBytes(folder / "a.ply", {file.begin(), file.end()});
    expectRefused(folder, "a.ply", std::string("line 10: ") + text);
  }
}

TEST(ProgramHostileInputs, PointsBeyondThoseOfTheHeaderAreNotLeftOut)
{
  const TestFolder folder;
  writePcd(folder, "a.pcd", "1", "binary\n" + std::string(24, 'a'));
  expectRefused(folder, "a.pcd", "12 bytes follow the points");
  const std::string ones("\0\0\x80\x3f\0\0\x80\x3f\0\0\x80\x3f", 12);
  writePcd(folder, "b.pcd", "1", "binary\n" + ones + ones);
  expectRefused(folder, "b.pcd", "12 bytes follow the points");
  const auto writePly = [&](const std::string& format, const std::string& points) {
    const std::string file = "ply\nformat " + format +
                             " 1.0\nelement vertex 1\nproperty float x\nproperty "
                             "float y\nproperty float z\nend_header\n" +
                             points;
    writeBytes(folder / "a.ply", {file.begin(), file.end()});
  };
  writePly("ascii", "1 2 3\n4 5 6\n");
  expectRefused(folder, "a.ply", "lines follow the points");
  writePly("binary_little_endian", std::string(36, 'a'));
  expectRefused(folder, "a.ply", "24 bytes follow the points");
  writePly("binary_little_endian", std::string(11, 'a'));
  expectRefused(folder, "a.ply", "it was cut off");
}

TEST(ProgramHostileInputs, NumbersAreReadInAllWaysOfWriting)
{
  const TestFolder folder;
  writePcd(
      folder, "a.pcd", "3", "ascii\n+1 -.5 2e-1\r\n\nnan -nan inf\n\t1.  0 -0\n\n \n");
  expectRun(folder, "encode a.pcd -o x.pcxi");
  EXPECT_EQ(decode(folder / "x.pcxi")[0].voxels[0].size(), 2u);
}

TEST(ProgramHostileInputs, SizesOfCompressedPointsAreChecked)
{
  const TestFolder folder;
  const std::string compressed("\x0a\0\0\0", 4); // bytes
  const std::string zeros(30, '\0');
  writePcd(folder,
           "a.pcd",
           "1",
           "binary_compressed\n" + compressed + "\xff\xff\xff\xff" + zeros);
  expectRefused(folder, "a.pcd", "4294967295 bytes uncompressed, not the 12");
  // With a header that agrees.
  writePcd(folder,
           "b.pcd",
           "357913941",
           "binary_compressed\n" + compressed + "\xfc\xff\xff\xff" + zeros);
  expectRefused(folder, "b.pcd", "10 bytes cannot stand for 4294967292");
  // PCL's reader would write 1000 bytes after each point.
  const std::string filled_up =
      "VERSION 0.7\nFIELDS _ x y z\nSIZE 1 4 4 4\nTYPE U F F F\nCOUNT 1000 1 1 1\n"
      "WIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA binary_compressed\n" +
      compressed + std::string("\x0c\0\0\0", 4) + zeros;
  writeBytes(folder / "c.pcd", {filled_up.begin(), filled_up.end()});
  expectRefused(folder, "c.pcd", "have a field named _");
}

TEST(ProgramHostileInputs, CloudsUntilAFailureStayWhereItsMessageTells)
{
  const TestFolder folder;
  writePcd(folder, "a.pcd", "1", "ascii\n1 2 3\n");
  std::string points;
  for (int i = 0; i < 2000; ++i)
    points += std::to_string(i) + " 2 3\n";
  writePcd(folder, "b.pcd", "2000", "ascii\n" + points);
  expectRun(folder, "encode a.pcd b.pcd -o x.pcxi --resolution 1");
  const ProgramRun result =
      runShell(folder, "ulimit -f 8; exec \"$P\" decode x.pcxi -o out");
  EXPECT_EQ(result.status, 1);
  EXPECT_NE(result.errors.find("File too large"), std::string::npos) << result.errors;
  EXPECT_NE(result.errors.find("is in 'out.unfinished'"), std::string::npos)
      << result.errors;
  EXPECT_TRUE(std::filesystem::exists(folder / "out.unfinished/000000.pcd"));
  EXPECT_FALSE(std::filesystem::exists(folder / "out"));
}

TEST(ProgramHostileInputs, ASignalEndsWaitingForAPipe)
{
  const TestFolder folder;
  ASSERT_EQ(runShell(folder, "mkfifo p.mcap p.pcd; echo > page.html").status, 0);
  for (const std::string command : {"encode p.pcd -o x.mcap",
                                    "encode p.mcap -o x.mcap",
                                    "info p.mcap",
                                    "view p.mcap --export x.html --page page.html"}) {
    SCOPED_TRACE(command);
    const ProgramRun result =
        runShell(folder,
                 "\"$P\" " + command +
                     " & until ls -l /proc/$!/fd | grep -q '/p[.]'; do kill -0 $! || "
                     "break; sleep 0.05; done; kill -TERM $!; wait $!");
    EXPECT_EQ(result.status, 130);
    EXPECT_NE(result.errors.find("interrupted"), std::string::npos) << result.errors;
  }
}

TEST(ProgramHostileInputs, FilesOfTheSystemAreNotWaitedFor)
{
  const TestFolder folder;
  // Its size is 0, and who reads it waits for the kernel's next message.
  for (const std::string command : {"encode", "merge", "info"}) {
    const ProgramRun result = runShell(folder,
                                       "timeout 20 \"$P\" " + command + " /proc/kmsg" +
                                           (command == "info" ? "" : " -o x.mcap"));
    EXPECT_EQ(result.status, 1) << command << result.errors;
  }
  expectFailure(folder, "encode /proc/self/status -o x.pcxi", 1, "it is empty");
}

} // namespace test
} // namespace tools
} // namespace pcl_ext

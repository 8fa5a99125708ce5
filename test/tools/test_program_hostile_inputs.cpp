// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "tools/program.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

namespace pcl_ext::tools::test {

namespace {

std::string
pcd(const std::string& points, const std::string& data)
{
  return "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH " +
         points + "\nHEIGHT 1\nPOINTS " + points + "\nDATA " + data;
}

} // namespace

using ProgramHostileInputs = ProgramTest;

TEST_F(ProgramHostileInputs, NumbersAreReadInAllWaysOfWriting)
{
  writeText(folder / "a.pcd",
            pcd("3", "ascii\n+1 -.5 2e-1\r\n\nnan -nan inf\n\t1.  0 -0\n\n \n"));
  expectRun("encode a.pcd -o x.pcxi");
  EXPECT_EQ(decode(folder / "x.pcxi")[0].voxels[0].size(), 2u);
}

TEST_F(ProgramHostileInputs, CloudsUntilAFailureStayWhereItsMessageTells)
{
  writeText(folder / "a.pcd", pcd("1", "ascii\n1 2 3\n"));
  std::string points;
  for (int i = 0; i < 2000; ++i)
    points += std::to_string(i) + " 2 3\n";
  writeText(folder / "b.pcd", pcd("2000", "ascii\n" + points));
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

} // namespace pcl_ext::tools::test

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "tools/program.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

namespace pcl_ext::tools::test {

using ProgramHostileInputs = ProgramTest;

TEST_F(ProgramHostileInputs, CloudsUntilAFailureStayWhereItsMessageTells)
{
  auto clouds = roomClouds(2);
  clouds[0].resize(1);
  writeClouds("room", clouds);
  expectRun("encode room -o x.pcxi");
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

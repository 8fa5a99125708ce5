// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "tools/program.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <string>

namespace pcl_ext::tools::test {

namespace fs = std::filesystem;

const std::string documentation =
    std::string(PCL_EXT_TEST_DATA) + "/../../tools/pcl_ext/documentation/";

using ProgramDemo = ProgramTest;
using ProgramHelp = ProgramTest;

TEST_F(ProgramDemo, MakesARecordingAndClouds)
{
  const ProgramRun result =
      run("demo --sensors 2 --frames 3 -o out -q && \"$P\" demo --sensors 2 "
          "--frames 2 -o out --overwrite -q -l quadratic --threshold 30 "
          "--temporal-filter=4");
  EXPECT_EQ(result.status, 0) << result.errors;
  EXPECT_EQ(result.errors, "");
  const std::size_t row = result.output.find("| cell_sensor_2 | 3      |");
  ASSERT_NE(row, std::string::npos) << result.output;
  EXPECT_LT(result.output.find("| noise removed | surfaces kept |\n"), row);
  const std::string denoising = "| 82.2 %        | 97.9 %        |\n";
  EXPECT_EQ(result.output.find(denoising, row) + denoising.size(),
            result.output.find('\n', row) + 1)
      << result.output;
  EXPECT_TRUE(hasPart(result.output, "pcl_ext info out/cell.mcap"));
  const std::vector<DecodedStream> streams = decode(folder / "out/cell.mcap");
  ASSERT_EQ(streams.size(), 2u);
  EXPECT_EQ(streams[1].name, "/cell_sensor_2");
  ASSERT_EQ(streams[1].voxels.size(), 2u);
  EXPECT_TRUE(streams[1].voxels[0].depth_model);
  // The clouds of the first run are gone.
  EXPECT_EQ(filesIn(folder / "out/cell_sensor_2/decoded"), 2u);
  EXPECT_EQ(filesIn(folder / "out/cell_sensor_2/denoised"), 2u);
  expectVoxels(streams[1].voxels[1],
               readCloud(folder / "out/cell_sensor_2/decoded/000001.pcd"));
}

TEST_F(ProgramDemo, ReplacesNothingUnlessAsked)
{
  fs::create_directory(folder / "out");
  const Bytes precious{'o', 'w', 'n'};
  writeBytes(folder / "out/cell.mcap", precious);
  expectFailure(
      "demo --sensors 1 --frames 1 -q",
      2,
      "the folder 'out' is not empty: name another one, or replace the clouds "
      "in it with --overwrite");
  EXPECT_EQ(bytesOf(folder / "out/cell.mcap"), precious);
  EXPECT_EQ(filesIn(folder / "out"), 1u);
}

TEST_F(ProgramHelp, FitsAScreenAndTheManPageHasAllOfIt)
{
  const ProgramRun script =
      runShell("sh " + documentation + "man_page.sh \"$P\" pcl_ext.1");
  EXPECT_EQ(script.status, 0) << script.errors;
  const std::string man = textOf(folder / "pcl_ext.1");
  for (const std::string command : {"encode",
                                    "decode",
                                    "info",
                                    "verify",
                                    "cut",
                                    "merge",
                                    "view",
                                    "advise",
                                    "benchmark",
                                    "demo"}) {
    const ProgramRun help = expectRun(command + " --help");
    EXPECT_LE(std::count(help.output.begin(), help.output.end(), '\n'), 66) << command;
    std::size_t longest = 0;
    for (std::size_t begin = 0; begin < help.output.size();) {
      const std::size_t end = help.output.find('\n', begin);
      longest = std::max(longest, end - begin);
      begin = end + 1;
    }
    EXPECT_LE(longest, 100u) << command;
    EXPECT_TRUE(hasPart(man, "\n.SS " + command + "\n"));
  }
  EXPECT_TRUE(hasPart(man, "\n.B \\-\\-i\\-frame\\-rate N\nframes from"));
  EXPECT_TRUE(hasPart(man, "\n.B \\-\\-temporal\\-filter[=FRAMES]\nsurfaces"));
  EXPECT_TRUE(hasPart(man, "\n.SH EXAMPLES\n"));
  // roff leaves out a line of text that begins as a macro does.
  const std::set<std::string> macros = {"B", "PP", "SH", "SS", "TH", "TP"};
  EXPECT_FALSE(hasPart(man, "\n'"));
  for (std::size_t at = man.find("\n."); at != std::string::npos;
       at = man.find("\n.", at + 1)) {
    const std::string macro =
        man.substr(at + 2, man.find_first_of(" \n", at + 2) - at - 2);
    EXPECT_EQ(macros.count(macro), 1u) << macro;
  }
}

TEST_F(ProgramHelp, CompletionKnowsCommandsOptionsAndValues)
{
  writeBytes(folder / "x.mcap", {});
  const auto complete = [this](const std::string& words) {
    const ProgramRun result = runShell("export P; bash -c '. " + documentation +
                                       "pcl_ext.bash; COMP_WORDS=(\"$P\" " + words +
                                       "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); "
                                       "_pcl_ext; echo ${COMPREPLY[*]}'");
    EXPECT_EQ(result.errors, "") << words;
    return result.output;
  };
  EXPECT_EQ(complete("e"), "encode\n");
  EXPECT_EQ(complete("encode --eff"), "--effort\n");
  EXPECT_EQ(complete("encode --effort \"\""), "fast balanced small\n");
  EXPECT_EQ(complete("encode --temp"), "--temporal-filter\n");
  EXPECT_EQ(complete("decode --pcd a"), "ascii\n");
  EXPECT_EQ(complete("decode --from \"\""), "\n");
  EXPECT_EQ(complete("info x.m"), "x.mcap\n");
  EXPECT_EQ(complete("v"), "verify view\n");
  EXPECT_EQ(complete("view --no"), "--no-browser --no-header\n");
}

} // namespace pcl_ext::tools::test

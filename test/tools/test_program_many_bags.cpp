// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "tools/cloud_bags.h"
#include "tools/program.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

namespace pcl_ext::tools::test {

namespace {

namespace fs = std::filesystem;

std::map<std::string, Bytes>
recordingsIn(const std::string& path)
{
  std::map<std::string, Bytes> recordings;
  for (const fs::directory_entry& entry : fs::directory_iterator(path))
    if (entry.path().filename() != "manifest.jsonl")
      recordings[entry.path().filename()] = bytesOf(entry.path());
  return recordings;
}

std::vector<std::string>
linesOfManifest(const std::string& path)
{
  std::vector<std::string> lines;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    const auto json = nlohmann::json::parse(line);
    lines.push_back(json["output"].get<std::string>() + " " +
                    json["status"].get<std::string>());
  }
  return lines;
}

} // namespace

class ProgramManyBags : public ProgramTest {
protected:
  /** \brief Writes bags/a.mcap, bags/b.mcap ... */
  void
  writeBags(std::size_t count) const
  {
    fs::create_directories(folder / "bags");
    for (std::size_t i = 0; i < count; ++i)
      writeBag(folder /
                   ("bags/" + std::string(1, static_cast<char>('a' + i)) + ".mcap"),
               3 + i);
  }
};

TEST_F(ProgramManyBags, BesideCloudsAreRefused)
{
  writeBags(2);
  writeText(folder / "bags/z.pcd", "");
  expectFailure(
      "encode bags -o made",
      2,
      "'bags' has clouds and bags, such as 'bags/z.pcd' and 'bags/a.mcap': name "
      "what is meant, such as 'bags/*.pcd'");
  EXPECT_EQ(run("encode 'bags/*.mcap' -o made").status, 0);
}

TEST_F(ProgramManyBags, EachBecomesWhatItBecomesAloneForAnyJobs)
{
  writeBags(4);
  for (const std::string name : {"a", "b", "c", "d"})
    expectRun("encode bags/" + name + ".mcap -r 0.05 -o " + name + ".mcap");
  for (const std::string jobs : {"1", "2", "5"}) {
    const ProgramRun result =
        expectRun("encode bags -r 0.05 -o made" + jobs + " -j " + jobs);
    EXPECT_TRUE(hasPart(result.output, "| 4    | 0        | 36     |"));
    const auto made = recordingsIn(folder / ("made" + jobs));
    ASSERT_EQ(made.size(), 4u);
    for (const auto& [name, bytes] : made)
      EXPECT_TRUE(bytes == bytesOf(folder / name)) << name;
  }
  // Named singly, by a glob, and as a rosbag2 folder.
  fs::create_directories(folder / "bag_d");
  fs::copy(folder / "bags/d.mcap", folder / "bag_d/bag_d_0.mcap");
  expectRun("encode bags/a.mcap 'bags/[bc].mcap' bag_d/ -r 0.05 -o made");
  EXPECT_EQ(recordingsIn(folder / "made").count("bag_d.mcap"), 1u);
  EXPECT_TRUE(bytesOf(folder / "made/b.mcap") == bytesOf(folder / "b.mcap"));
}

TEST_F(ProgramManyBags, ProgressAndWhatIsLeftOutAreToldToPrograms)
{
  writeBags(3);
  const ProgramRun one = run("encode bags/a.mcap -r 0.05 -q --progress -o a.mcap");
  EXPECT_EQ(one.errors.find("{\"done\": 0, \"total\": 9, \"of\": \"messages\"}\n"), 0u);
  EXPECT_TRUE(
      hasPart(one.errors, "{\"done\": 9, \"total\": 9, \"of\": \"messages\"}\n"));
  const ProgramRun piped =
      runShell("cat bags/a.mcap | \"$P\" encode - -r 0.05 -q --progress -o b.mcap");
  EXPECT_EQ(piped.errors.find("{\"done\": 0, \"total\": null, "), 0u) << piped.errors;
  // Neither the order of the options nor that of the runs changes what is done before.
  run("encode bags -r 0.05 -q -o made");
  fs::copy(folder / "bags/a.mcap", folder / "bags/d.mcap");
  const ProgramRun all = run("encode bags -r 0.05 -q --progress --json -o made");
  EXPECT_EQ(all.errors,
            "{\"done\": 0, \"total\": 1, \"of\": \"bags\"}\n"
            "{\"done\": 1, \"total\": 1, \"of\": \"bags\"}\n");
  std::string skipped;
  const nlohmann::json summary = nlohmann::json::parse(all.output);
  for (const nlohmann::json& bag : summary["bags"])
    skipped += bag["skipped"].get<bool>() ? 's' : 'n';
  EXPECT_EQ(skipped, "sssn");
}

TEST_F(ProgramManyBags, FailuresAreInATableAndTheOthersAreDone)
{
  writeBags(4);
  writeBytes(folder / "bags/b.mcap", {});
  Bytes bytes = bytesOf(folder / "bags/c.mcap");
  bytes.resize(bytes.size() / 2);
  writeBytes(folder / "bags/c.mcap", bytes);
  const ProgramRun one = run("encode bags -r 0.05 -o made");
  EXPECT_EQ(one.status, 1);
  EXPECT_TRUE(hasPart(one.output, "| 4    | 2        |"));
  EXPECT_TRUE(hasPart(one.output,
                      "| bags/b.mcap | failed     | 0      | 'bags/b.mcap' is not"));
  EXPECT_TRUE(hasPart(one.output, "| bags/c.mcap | incomplete |"));
  EXPECT_TRUE(
      hasPart(one.errors, "pcl_ext encode: bags/b.mcap: 'bags/b.mcap' is not a cloud"));
  const ProgramRun several = run("encode bags -r 0.05 -o made2 -j 3");
  EXPECT_EQ(several.output, one.output);
  EXPECT_EQ(several.errors, one.errors);
  EXPECT_TRUE(recordingsIn(folder / "made") == recordingsIn(folder / "made2"));
  // What failed is tried again, and only that.
  writeBag(folder / "bags/b.mcap", 4);
  EXPECT_EQ(run("encode bags -r 0.05 -o made").status, 1);
  const std::vector<std::string> lines =
      linesOfManifest(folder / "made/manifest.jsonl");
  ASSERT_EQ(lines.size(), 12u);
  EXPECT_EQ(std::vector<std::string>(lines.begin() + 8, lines.end()),
            (std::vector<std::string>{
                "b.mcap begun", "b.mcap done", "c.mcap begun", "c.mcap incomplete"}));
}

TEST_F(ProgramManyBags, GoesOnWhereItWasKilled)
{
  writeBags(4);
  writeBag(folder / "bags/e.mcap", 60);
  expectRun("encode bags -r 0.05 -o whole");
  const ProgramRun killed =
      runShell("\"$P\" encode bags -r 0.05 -o made & p=$!; i=0; "
               "until grep -q 'd.mcap.*done' made/manifest.jsonl || [ $i = 1000 ]; "
               "do i=$((i+1)); sleep 0.005; done 2> /dev/null; kill -9 $p; wait $p");
  EXPECT_EQ(killed.status, 137);
  EXPECT_FALSE(fs::exists(folder / "made/e.mcap"));
  // As if it were killed in the middle of a line, and after a recording got its name.
  const std::string manifest = folder / "made/manifest.jsonl";
  std::ofstream(manifest, std::ios::app) << "{\"input\":\"";
  writeBytes(folder / "made/e.mcap", {1, 2, 3});
  const auto time = fs::last_write_time(folder / "made/a.mcap");
  const ProgramRun again = expectRun("encode -q bags -r 0.05 -o made -j 2");
  EXPECT_TRUE(hasPart(again.output, "| 5    | 0        |"));
  EXPECT_TRUE(recordingsIn(folder / "made") == recordingsIn(folder / "whole"));
  EXPECT_EQ(fs::last_write_time(folder / "made/a.mcap"), time);
  const std::vector<std::string> lines = linesOfManifest(manifest);
  EXPECT_EQ(std::count(lines.begin(), lines.end(), "e.mcap done"), 1);
  EXPECT_EQ(std::count(lines.begin(), lines.end(), "a.mcap begun"), 1);
}

TEST_F(ProgramManyBags, WhatHasChangedIsEncodedAgain)
{
  writeBags(3);
  expectRun("encode bags -r 0.05 -o made");
  writeBag(folder / "bags/a.mcap", 8);
  fs::remove(folder / "made/b.mcap");
  EXPECT_EQ(run("encode bags -r 0.05 -o made").errors,
            "pcl_ext encode: 1 bag done before and unchanged\n");
  expectRun("encode bags -r 0.05 -q -o whole");
  EXPECT_TRUE(recordingsIn(folder / "made") == recordingsIn(folder / "whole"));
  expectFailure(
      "encode bags -r 0.06 -o made",
      2,
      "'made/a.mcap' was encoded with other options, '--resolution=0.05': name "
      "another folder, or encode all again with --overwrite");
  expectRun("encode bags -r 0.06 -o made --overwrite");
  expectRun("encode bags -r 0.06 -q -j 2 -o made");
  // Also one bag, into a folder that has recordings of several.
  fs::remove(folder / "made/c.mcap");
  expectRun("encode bags/c.mcap -r 0.06 -q -o made");
  expectRun("encode bags -r 0.06 -q -o other");
  EXPECT_TRUE(recordingsIn(folder / "made") == recordingsIn(folder / "other"));
  // The recording of a bag that is away keeps its options, and stops nothing.
  fs::remove(folder / "bags/b.mcap");
  expectRun("encode bags -r 0.07 -q -o made --overwrite");
  EXPECT_EQ(run("encode bags -r 0.07 -o made").errors,
            "pcl_ext encode: 2 bags done before and unchanged\n");
}

TEST_F(ProgramManyBags, OfWhichNothingWasWrittenMayHaveOtherOptionsNext)
{
  writeBags(2);
  EXPECT_EQ(run("encode bags -o made --topics /nope").status, 1);
  expectRun("encode bags -o made -q --topics /front/points");
}

TEST_F(ProgramManyBags, FilesAndBagsOfOthersAreNotReplacedNorTakenForKnownOnes)
{
  writeBags(2);
  fs::create_directories(folder / "more");
  fs::copy(folder / "bags/a.mcap", folder / "more/a.mcap");
  fs::create_directories(folder / "made");
  writeBytes(folder / "made/b.mcap", {1});
  expectFailure("encode bags -o made", 2, "'made/b.mcap' exists");
  fs::remove(folder / "made/b.mcap");
  expectRun("encode bags -o made -q");
  expectFailure("encode more -o made", 2, "'made/a.mcap' is of another bag");
  const ProgramRun locked =
      runShell("flock made/manifest.jsonl \"$P\" encode bags -o made");
  EXPECT_EQ(locked.status, 2);
  EXPECT_TRUE(hasPart(locked.errors, "another run encodes bags into 'made'"));
}

TEST_F(ProgramManyBags, WhatIsNoBagInAFolderIsLeftOutAndNamed)
{
  writeBags(2);
  writeBytes(folder / "bags/._a.mcap", {0, 5, 22, 7});
  writeBytes(folder / "bags/a.db3-wal", {1});
  for (const char* name : {"c", "c.mcap.bak", "day/a.mcap", "day/b.mcap"}) {
    const fs::path path = folder / (std::string("bags/") + name);
    fs::create_directories(path.parent_path());
    fs::copy(folder / "bags/a.mcap", path);
  }
  ASSERT_EQ(runShell("mkfifo bags/d.mcap; mkdir bags/run; cp bags/a.mcap "
                     "bags/run/day_0.mcap")
                .status,
            0);
  const std::string remark =
      "'bags': left out: 2 folders (day, ...) and 4 other files (a.db3-wal, ...); "
      "folders in it are not searched, and bags are named .mcap, .db3 or .bag; "
      "'bags/run' seems to be a bag without metadata.yaml: name this folder to encode "
      "it\n";
  const ProgramRun result = expectRemark("encode bags -r 0.05 --json -o made", remark);
  const nlohmann::json summary = nlohmann::json::parse(result.output);
  EXPECT_EQ(summary["bags"].size(), 2u);
  EXPECT_EQ(summary["left_out"],
            (std::vector<std::string>{"bags/day",
                                      "bags/run",
                                      "bags/a.db3-wal",
                                      "bags/c",
                                      "bags/c.mcap.bak",
                                      "bags/d.mcap"}));
  EXPECT_EQ(run("encode bags/run -r 0.05 -q -o run.mcap").status, 0);
  // Also where one bag is left.
  fs::remove(folder / "bags/b.mcap");
  EXPECT_TRUE(hasPart(run("encode bags -r 0.05 -o a.mcap").errors, remark));
}

} // namespace pcl_ext::tools::test

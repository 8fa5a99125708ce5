// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording/bag_reader.h"
#include "recording/point_cloud_messages.h"
#include "recording/rosbag2_metadata.h"
#include "support/recorded_streams.h"

#include <gtest/gtest.h>

namespace pcl_ext::PCL_EXT_ABI::recording::test {

namespace {

constexpr char numbered[] = "- history: 3\n  depth: 0\n  reliability: 1\n  deadline:\n"
                            "    sec: 9223372036\n    nsec: 854775807";
constexpr char named[] = "- history: unknown\n  depth: 0\n  reliability: reliable\n"
                         "  deadline:\n    sec: 9223372036\n    nsec: 854775807";

/** \brief The metadata of a bag whose topics have the keys of these texts. */
std::string
metadataOf(const std::string& topics)
{
  return "rosbag2_bagfile_information:\n  version: 5\n  topics_with_message_count:\n" +
         topics + "  files:\n    - path: bag_0.mcap\n      name: no topic\n";
}

/** \brief Writes a folder with a topic of this QoS, and returns that in the channel of
 * the folder when metadata.yaml alone has it. */
std::string
throughMetadata(const TestFolder& folder, const std::string& qos)
{
  std::filesystem::remove_all(folder / "bag");
  std::filesystem::remove_all(folder / "bare");
  for (const std::string name : {"bag", "bare"}) {
    McapChannel points = pointCloudChannel("/points");
    if (name == "bag")
      points.metadata["offered_qos_profiles"] = qos;
    writeMcap(folder / name, {points});
  }
  const auto replace = std::filesystem::copy_options::overwrite_existing;
  std::filesystem::copy_file(
      folder / "bag/metadata.yaml", folder / "bare/metadata.yaml", replace);
  BagReader reader;
  EXPECT_TRUE(reader.open(folder / "bare").ok());
  return reader.channels()[0].metadata.at("offered_qos_profiles");
}

} // namespace

TEST(Rosbag2Metadata, QosIsReadInAllStyles)
{
  const std::string text = metadataOf(
      "    - topic_metadata:\n        name: /escaped\n        type: a/msg/B\n"
      "        offered_qos_profiles: \"- history: 3\\n  depth: 0\\n  reliability: 1\\n"
      "  deadline:\\n    sec: 9223372036\\n    nsec: 854775807\"\n      message_count: "
      "2\n"
      "    - topic_metadata:\n        name: \"/folded\"\n        offered_qos_profiles: "
      "\"- history: 3\\n  depth: 0\\n  reliability:\\\n          \\ 1\\n  deadline:\\n"
      "    sec:\n          9223372036\\n    nsec: 854775807\"\n"
      "    - topic_metadata:\n        name: /block\n        offered_qos_profiles: |-\n"
      "          - history: 3\n            depth: 0\n            reliability: 1\n"
      "            deadline:\n              sec: 9223372036\n              nsec: "
      "854775807\n"
      "    - topic_metadata:\n        name: /list\n        offered_qos_profiles:\n"
      "          - history: unknown\n            depth: 0\n            reliability: "
      "reliable\n            deadline:\n              sec: 9223372036\n"
      "              nsec: 854775807\n        type_description_hash: RIHS01_1\n"
      "    - topic_metadata:\n        name: /none\n        offered_qos_profiles: \"\"\n"
      "    - topic_metadata:\n        name: /empty\n        offered_qos_profiles: []\n"
      "    - topic_metadata:\n        name: '/it''s'\n        offered_qos_profiles: "
      "'- depth: 1'\n");
  const std::map<std::string, std::string> expected = {{"/escaped", numbered},
                                                       {"/folded", numbered},
                                                       {"/block", numbered},
                                                       {"/list", named},
                                                       {"/it's", "- depth: 1"}};
  EXPECT_EQ(readOfferedQos(text), expected);
}

TEST(Rosbag2Metadata, ListsNeedNoIndentation)
{
  const std::string text =
      "rosbag2_bagfile_information:\n  topics_with_message_count:\n"
      "  - message_count: 1\n    topic_metadata:\n"
      "      name: /a\n      offered_qos_profiles:\n"
      "      - depth: 7\n        reliability: reliable\n"
      "      serialization_format: cdr\n"
      "  - message_count: 1\n    topic_metadata:\n"
      "      name: /b\n      offered_qos_profiles: ''\n";
  const std::map<std::string, std::string> expected = {
      {"/a", "- depth: 7\n  reliability: reliable"}};
  EXPECT_EQ(readOfferedQos(text), expected);
}

TEST(Rosbag2Metadata, EachLineIsReadOnce)
{
  // With a search from each of the lines it would take hours.
  std::string text;
  for (int i = 0; i < 1'000'000; ++i)
    text += "topic_metadata:\n";
  text += metadataOf("    - topic_metadata:\n        name: /a\n        "
                     "offered_qos_profiles: '- depth: 1'\n");
  const std::map<std::string, std::string> expected = {{"/a", "- depth: 1"}};
  EXPECT_EQ(readOfferedQos(text), expected);
}

TEST(Rosbag2Metadata, AnyTextIsRead)
{
  const std::string text =
      metadataOf("    - topic_metadata:\n        name: \"/a\n        "
                 "offered_qos_profiles: 'x''\n    - topic_metadata:\n      - - -\n");
  for (std::size_t end = 0; end <= text.size(); ++end)
    readOfferedQos(text.substr(0, end));
  for (std::size_t i = 0; i < text.size(); ++i)
    for (const char other : {'\n', '"', '\\', '\'', '-', ':', '|'}) {
      std::string changed = text;
      changed[i] = other;
      EXPECT_LE(readOfferedQos(changed).size(), 2u);
    }
}

TEST(Rosbag2Metadata, QosOfChannelsIsWrittenAndRead)
{
  const TestFolder folder;
  EXPECT_EQ(throughMetadata(folder, numbered), numbered);
  EXPECT_TRUE(hasPart(textOf(folder / "bag/metadata.yaml"), "version: 5"));
  // rosbag2 reads names of policies since version 9 alone.
  EXPECT_EQ(throughMetadata(folder, named), named);
  EXPECT_TRUE(hasPart(textOf(folder / "bag/metadata.yaml"), "version: 9"));
}

TEST(Rosbag2Metadata, NumbersOfPoliciesHaveNames)
{
  EXPECT_EQ(withNamedPolicies(numbered), named);
  EXPECT_EQ(withNamedPolicies(named), named);
  EXPECT_EQ(withNamedPolicies("- depth: 2\n  reliability: 2\n  durability: 9\n"
                              "  liveliness: 1\n  history:"),
            "- depth: 2\n  reliability: best_effort\n  durability: 9\n"
            "  liveliness: automatic\n  history:");
  EXPECT_EQ(withNamedPolicies(""), "");
}

TEST(Rosbag2Metadata, TopicsOfOldAndNewBagsKeepTheirQos)
{
  const TestFolder folder;
  std::vector<McapChannel> channels = {pointCloudChannel("/old"),
                                       pointCloudChannel("/new")};
  channels[0].metadata["offered_qos_profiles"] = numbered;
  channels[1].metadata["offered_qos_profiles"] = named;
  writeMcap(folder / "bag", channels);
  const std::map<std::string, std::string> expected = {{"/old", named},
                                                       {"/new", named}};
  EXPECT_EQ(readOfferedQos(textOf(folder / "bag/metadata.yaml")), expected);
}

TEST(Rosbag2Metadata, FilesThatItNamesAreMissed)
{
  EXPECT_EQ(
      readFileNames("  relative_file_paths:\n    - bag_0.mcap\r\n    - 'old/b_1.mcap'"
                    "\n    - \"b 2.mcap\"\n  duration: 5\n    - none\n"),
      (std::vector<std::string>{"bag_0.mcap", "b_1.mcap", "b 2.mcap"}));
  EXPECT_TRUE(readFileNames("relative_file_paths: []").empty());
  EXPECT_TRUE(readFileNames("").empty());
  const TestFolder folder;
  writeMcap(folder / "bag", {});
  BagReader reader;
  ASSERT_TRUE(reader.open(folder / "bag").ok());
  EXPECT_TRUE(reader.damage().empty());
  std::string text = textOf(folder / "bag/metadata.yaml");
  const std::size_t item = text.find("    - \"bag_0.mcap\"");
  ASSERT_NE(item, std::string::npos) << text;
  text.insert(item, "    - bag_1.mcap\n    - bag_2.mcap\n");
  writeText(folder / "bag/metadata.yaml", text);
  ASSERT_TRUE(reader.open(folder / "bag").ok());
  ASSERT_EQ(reader.damage().size(), 1u);
  EXPECT_EQ(reader.damage()[0].message,
            "it names 'bag_1.mcap', which is not there, and 1 more");
}

} // namespace pcl_ext::PCL_EXT_ABI::recording::test

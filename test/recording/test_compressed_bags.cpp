// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#include "recording/bag_test.h"
#include "recording/mcap_writer.h"
#include "support/database_bags.h"

#include <filesystem>

namespace pcl_ext::PCL_EXT_ABI::recording::test {

namespace {

namespace fs = std::filesystem;

Bytes
bytesOfText(std::size_t i)
{
  Bytes bytes(100 * i + 8, static_cast<std::uint8_t>(i));
  bytes[0] = 0;
  return bytes;
}

void
writeTexts(const std::string& path, std::size_t begin, std::size_t end, bool compresses)
{
  std::vector<McapMessage> messages(end - begin);
  for (std::size_t i = begin; i < end; ++i) {
    McapMessage& message = messages[i - begin];
    message.log_time = message.publish_time = Time(static_cast<std::int64_t>(i));
    message.bytes = compresses ? compressed(bytesOfText(i)) : bytesOfText(i);
  }
  writeMcap(path,
            {{"/x", "cdr", {"std_msgs/msg/String", "ros2msg", "string data\n"}, {}}},
            messages);
}

std::size_t
countTexts(BagReader& reader)
{
  std::size_t count = 0;
  for (const BagEntry& entry : reader.index()) {
    McapMessage message;
    if (!reader.read(entry, message).ok())
      continue;
    EXPECT_EQ(message.bytes, bytesOfText(count));
    ++count;
  }
  return count;
}

} // namespace

using CompressedBags = BagTest;

TEST_F(CompressedBags, OfFilesAreRead)
{
  fs::create_directories(folder / "bag");
  for (std::size_t part = 0; part < 3; ++part) {
    const std::string path = (folder / "bag/bag_") + std::to_string(part) + ".mcap";
    writeTexts(path, 10 * part, 10 * part + 10, false);
    writeBytes(path + ".zstd", compressed(bytesOf(path)));
    if (part != 1) // one is there in both forms
      fs::remove(path);
  }
  EXPECT_TRUE(BagReader::isBag(folder / "bag"));
  EXPECT_TRUE(BagReader::isBag(folder / "bag/bag_0.mcap.zstd"));
  ASSERT_TRUE(reader.open(folder / "bag").ok());
  EXPECT_TRUE(reader.isCompressed());
  EXPECT_EQ(countTexts(reader), 30u);
  EXPECT_TRUE(reader.damage().empty());
  const std::string listed =
      "x:\n  relative_file_paths:\n    - bag_0.mcap.zstd\n"
      "    - bag_1.mcap.zstd\n    - bag_2.mcap\n    - bag_3.mcap\n";
  writeText(folder / "bag/metadata.yaml", listed);
  ASSERT_TRUE(reader.open(folder / "bag").ok());
  ASSERT_EQ(reader.damage().size(), 1u);
  EXPECT_TRUE(hasPart(reader.damage()[0].message, "'bag_3.mcap', which is not there"));
}

TEST_F(CompressedBags, ThatAreCutOffAreReadAsFarAsTheyGo)
{
  writeTexts(folder / "x.mcap", 0, 40, false);
  const Bytes whole = compressed(bytesOf(folder / "x.mcap"));
  for (std::size_t size = 0; size < whole.size(); size += 13) {
    writeBytes(folder / "y.mcap.zstd",
               Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)));
    if (reader.open(folder / "y.mcap.zstd").ok()) {
      EXPECT_FALSE(reader.damage().empty());
      EXPECT_LE(countTexts(reader), 40u);
    }
  }
}

TEST_F(CompressedBags, OfDatabasesAreRead)
{
  {
    DatabaseBag bag(folder / "x.db3");
    bag.addTopic(1, "/x", "std_msgs/msg/String", "");
    for (std::size_t i = 0; i < 20; ++i)
      bag.addMessage(1, static_cast<std::int64_t>(i), bytesOfText(i));
  }
  writeBytes(folder / "x.db3.zstd", compressed(bytesOf(folder / "x.db3")));
  EXPECT_TRUE(BagReader::isBag(folder / "x.db3.zstd"));
  ASSERT_TRUE(reader.open(folder / "x.db3.zstd").ok());
  EXPECT_TRUE(reader.hasDatabases());
  EXPECT_EQ(countTexts(reader), 20u);
}

TEST_F(CompressedBags, OfMessagesAreRead)
{
  writeTexts(folder / "x.mcap", 0, 20, true);
  ASSERT_TRUE(reader.open(folder / "x.mcap").ok());
  EXPECT_EQ(countTexts(reader), 20u);
  EXPECT_TRUE(reader.damage().empty());
}

TEST_F(CompressedBags, MessagesThatAreNotWholeOrHaveTooManyBytesAreDamage)
{
  Bytes cut = compressed(bytesOfText(3));
  cut.pop_back();
  const Bytes bomb = compressed(Bytes(max_chunk_bytes + 1));
  EXPECT_LT(bomb.size(), 100'000u);
  {
    DatabaseBag bag(folder / "x.db3");
    bag.addTopic(1, "/x", "std_msgs/msg/String", "");
    bag.addMessage(1, 0, compressed(bytesOfText(0)));
    bag.addMessage(1, 1, cut);
    bag.addMessage(1, 2, bomb);
  }
  ASSERT_TRUE(reader.open(folder / "x.db3").ok());
  EXPECT_EQ(countTexts(reader), 1u);
  ASSERT_EQ(reader.damage().size(), 2u);
  EXPECT_TRUE(
      hasPart(reader.damage()[1].message, "larger than the limit of 268435456 bytes"));
}

TEST_F(CompressedBags, FilesThatHaveFarMoreBytesThanTheyHadAreRefused)
{
  // The header of a frame of zstd whose content has 2 GiB.
  Bytes bomb = {0x28, 0xb5, 0x2f, 0xfd, 0xa0, 0, 0, 0, 0x80};
  bomb.resize(1000);
  writeBytes(folder / "x.mcap.zstd", bomb);
  const RecordingStatus status = reader.open(folder / "x.mcap.zstd");
  EXPECT_EQ(status.code(), RecordingCode::InputFailed);
  EXPECT_TRUE(hasPart(status.message(), "zstd -d")) << status;
}

} // namespace pcl_ext::PCL_EXT_ABI::recording::test

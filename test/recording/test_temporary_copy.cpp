// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording/system_files.h"
#include "recording/temporary_copy.h"
#include "support/recorded_streams.h"

#include <gtest/gtest.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>

namespace pcl_ext::PCL_EXT_ABI::recording::test {

TEST(TemporaryCopies, APipeIsCopiedToItsEnd)
{
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  const std::string text = "frames";
  const std::string whole = "a " + text;
  ASSERT_EQ(::write(ends[1], text.data(), text.size()), 6);
  ::close(ends[1]);
  std::string path;
  {
    TemporaryFile copy;
    ASSERT_TRUE(copyToTemporaryFile(ends[0], "pipe", {}, {'a', ' '}, copy).ok());
    ::close(ends[0]);
    path = copy.path();
    for (int i = 0; i < 2; ++i) // again
      EXPECT_EQ(bytesOf(path), Bytes(whole.begin(), whole.end()));
    std::vector<std::uint8_t> end(6);
    EXPECT_TRUE(readAt(copy.descriptor(), 2, end.data(), end.size()));
    EXPECT_EQ(std::string(end.begin(), end.end()), text);
    EXPECT_FALSE(readAt(copy.descriptor(), 3, end.data(), end.size()));
  }
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(TemporaryCopies, ACopyThatIsNotWantedEnds)
{
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  ASSERT_EQ(::write(ends[1], "x", 1), 1);
  TemporaryFile copy;
  const RecordingStatus status = copyToTemporaryFile(
      ends[0], "pipe", [] { return false; }, {}, copy);
  EXPECT_EQ(status.code(), RecordingCode::InputFailed);
  EXPECT_TRUE(hasPart(status.message(), "interrupted"));
  EXPECT_FALSE(copy.exists());
  ::close(ends[0]);
  ::close(ends[1]);
}

TEST(TemporaryCopies, DevicesAreRefused)
{
  for (const char* device : {"/dev/zero", "/dev/null"}) {
    RecordingReader reader;
    const RecordingStatus status = reader.open(device);
    EXPECT_EQ(status.code(), RecordingCode::InputFailed);
    EXPECT_TRUE(hasPart(status.message(), "is a device"));
  }
}

TEST(Rosbag2Folders, PipesInThemAreNotWaitedFor)
{
  const TestFolder folder;
  const std::vector<KnownStream> streams = {knownStream(0, 5, 3)};
  record(streams, folder / "bag");
  std::filesystem::remove(folder / "bag/metadata.yaml");
  ASSERT_EQ(::mkfifo((folder / "bag/metadata.yaml").c_str(), 0600), 0);
  EXPECT_EQ(readAll(folder / "bag", streams).decoded[0], 5u);
  ASSERT_EQ(::mkfifo((folder / "bag/bag_1.mcap").c_str(), 0600), 0);
  RecordingReader reader;
  const RecordingStatus status = reader.open(folder / "bag");
  EXPECT_EQ(status.code(), RecordingCode::InputFailed);
  EXPECT_TRUE(hasPart(status.message(), "bag_1.mcap' is no file"));
}

} // namespace pcl_ext::PCL_EXT_ABI::recording::test

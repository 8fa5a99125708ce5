#include "recording/temporary_copy.h"
#include "support/recorded_streams.h"

#include <gtest/gtest.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>

namespace pcl_ext {
namespace recording {
namespace test {

TEST(TemporaryCopies, APipeIsCopiedToItsEnd)
{
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  const std::string text = "frames";
  ASSERT_EQ(::write(ends[1], text.data(), text.size()), 6);
  ::close(ends[1]);
  int copy = -1;
  ASSERT_TRUE(copyToTemporaryFile(ends[0], "pipe", {}, {'a', ' '}, copy).ok());
  ::close(ends[0]);
  std::string read(16, ' ');
  for (int i = 0; i < 2; ++i) // at any place, and again
    EXPECT_EQ(::pread(copy, read.data(), read.size(), 0), 8);
  EXPECT_EQ(read.substr(0, 8), "a frames");
  ::close(copy);
}

TEST(TemporaryCopies, ACopyThatIsNotWantedEnds)
{
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  ASSERT_EQ(::write(ends[1], "x", 1), 1);
  int copy = -1;
  const RecordingStatus status = copyToTemporaryFile(
      ends[0], "pipe", [] { return false; }, {}, copy);
  EXPECT_EQ(status.code(), RecordingCode::InputFailed);
  EXPECT_NE(status.message().find("interrupted"), std::string::npos);
  ::close(ends[0]);
  ::close(ends[1]);
}

TEST(TemporaryCopies, DevicesAreRefused)
{
  for (const char* device : {"/dev/zero", "/dev/null"}) {
    RecordingReader reader;
    const RecordingStatus status = reader.open(device);
    EXPECT_EQ(status.code(), RecordingCode::InputFailed);
    EXPECT_NE(status.message().find("is a device"), std::string::npos) << status;
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
  EXPECT_NE(status.message().find("bag_1.mcap' is no file"), std::string::npos)
      << status;
}

} // namespace test
} // namespace recording
} // namespace pcl_ext

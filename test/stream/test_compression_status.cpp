#include <pcl_ext/status.h>

#include <gtest/gtest.h>

namespace {

using namespace pcl_ext::io;

TEST(CompressionStatus, DefaultIsPlainSuccess)
{
  const CompressionStatus status;
  EXPECT_TRUE(status.ok());
  EXPECT_EQ(status.code(), CompressionCode::Ok);
  EXPECT_TRUE(status.message().empty());
}

TEST(CompressionStatus, KeepsCodeAndMessageAndOnlyOkIsSuccess)
{
  for (int number = static_cast<int>(CompressionCode::Ok);
       number <= static_cast<int>(CompressionCode::InputFailed);
       ++number) {
    const auto code = static_cast<CompressionCode>(number);
    const CompressionStatus status(code, "a message");
    EXPECT_EQ(status.ok(), code == CompressionCode::Ok);
    EXPECT_EQ(status.code(), code);
    EXPECT_EQ(status.message(), "a message");
  }
}

} // namespace

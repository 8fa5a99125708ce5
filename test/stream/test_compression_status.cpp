// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/status.h>

#include <gtest/gtest.h>

#include <sstream>
#include <type_traits>

namespace {

using namespace pcl_ext::io;

TEST(CompressionStatus, DefaultIsPlainSuccess)
{
  const CompressionStatus status;
  EXPECT_TRUE(status.ok());
  EXPECT_EQ(status.code(), CompressionCode::Ok);
  EXPECT_TRUE(status);
  EXPECT_FALSE(status.hasWarning());
  EXPECT_TRUE(status.message().empty());
}

TEST(CompressionStatus, OnlySuccessWithAMessageIsAWarning)
{
  EXPECT_TRUE(CompressionStatus(CompressionCode::Ok, "2 of 3 points").hasWarning());
  EXPECT_FALSE(CompressionStatus(CompressionCode::Corrupt, "a byte").hasWarning());
}

TEST(CompressionStatus, IsPrintedAsItsMessage)
{
  const auto printed = [](const CompressionStatus& status) {
    std::ostringstream stream;
    stream << status;
    return stream.str();
  };
  EXPECT_EQ(printed({}), "ok");
  EXPECT_EQ(printed({CompressionCode::Corrupt, "a byte"}), "a byte");
  EXPECT_EQ(printed({CompressionCode::Corrupt, ""}), "failed");
}

TEST(CompressionStatus, IsNoNumber)
{
  static_assert(!std::is_convertible_v<CompressionStatus, bool>, "explicit only");
  static_assert(std::is_constructible_v<bool, CompressionStatus>, "in conditions");
}

TEST(CompressionStatus, KeepsCodeAndMessageAndOnlyOkIsSuccess)
{
  for (int number = static_cast<int>(CompressionCode::Ok);
       number <= static_cast<int>(CompressionCode::InputFailed);
       ++number) {
    const auto code = static_cast<CompressionCode>(number);
    const CompressionStatus status(code, "a message");
    EXPECT_EQ(status.ok(), code == CompressionCode::Ok);
    EXPECT_EQ(static_cast<bool>(status), code == CompressionCode::Ok);
    EXPECT_EQ(status.code(), code);
    EXPECT_EQ(status.message(), "a message");
  }
}

} // namespace

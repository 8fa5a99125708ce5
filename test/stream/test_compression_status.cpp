// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/status.h>

#include <gtest/gtest.h>

#include <sstream>
#include <type_traits>

namespace {

using namespace pcl_ext::io;

TEST(CompressionStatus, OnlyOkIsSuccessAndAWarningWithAMessage)
{
  EXPECT_TRUE(CompressionStatus().ok());
  EXPECT_FALSE(CompressionStatus().hasWarning());
  for (const auto code : {CompressionCode::Ok, CompressionCode::Corrupt}) {
    const CompressionStatus status(code, "a message");
    EXPECT_EQ(status.ok(), code == CompressionCode::Ok);
    EXPECT_EQ(static_cast<bool>(status), code == CompressionCode::Ok);
    EXPECT_EQ(status.hasWarning(), code == CompressionCode::Ok);
    EXPECT_EQ(status.code(), code);
    EXPECT_EQ(status.message(), "a message");
  }
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

} // namespace

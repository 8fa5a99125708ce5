// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include <gtest/gtest.h>

namespace pcl_ext::test {

/** \brief Expects a code, and a message with everything but success. */
template <typename StatusT, typename CodeT>
void
expectCode(const StatusT& status, CodeT code)
{
  EXPECT_EQ(static_cast<int>(status.code()), static_cast<int>(code))
      << status.message();
  EXPECT_EQ(status.message().empty(), code == CodeT::Ok);
}

} // namespace pcl_ext::test

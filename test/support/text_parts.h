// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include <gtest/gtest.h>

#include <string>

namespace pcl_ext::test {

/** \return with the text as its message */
inline ::testing::AssertionResult
hasPart(const std::string& text, const std::string& part)
{
  const bool has_part = text.find(part) != std::string::npos;
  return ::testing::AssertionResult(has_part)
         << "'" << part << "' is " << (has_part ? "" : "not ") << "in:\n"
         << text;
}

} // namespace pcl_ext::test

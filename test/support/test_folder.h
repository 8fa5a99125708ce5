// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

#pragma once

#include <pcl_ext/version.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <system_error>

namespace pcl_ext::PCL_EXT_ABI::recording::test {

/** \brief A folder for the files of a test, which is removed with them. Other runs of the
 * test have others. */
class TestFolder {
public:
  TestFolder()
  {
    const auto* const test = ::testing::UnitTest::GetInstance()->current_test_info();
    std::string name =
        std::string("pcl_ext_") + test->test_suite_name() + "_" + test->name();
    std::replace(name.begin(), name.end(), '/', '_'); // of parametrised tests
    name = ::testing::TempDir() + name + "_XXXXXX";
    EXPECT_NE(::mkdtemp(name.data()), nullptr);
    path_ = name;
  }

  ~TestFolder()
  {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }

  TestFolder(const TestFolder&) = delete;
  TestFolder&
  operator=(const TestFolder&) = delete;

  std::string
  operator/(const std::string& name) const
  {
    return (path_ / name).string();
  }

private:
  std::filesystem::path path_;
};

} // namespace pcl_ext::PCL_EXT_ABI::recording::test

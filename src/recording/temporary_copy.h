// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/export.h>
#include <pcl_ext/recording/recording_status.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace pcl_ext::PCL_EXT_ABI::recording {

/** \brief A temporary file, which is removed with this. On Linux it has no name, so that
 * nothing is left of it if the program is killed. */
class PCL_EXT_RECORDING_EXPORT TemporaryFile {
public:
  TemporaryFile() = default;
  ~TemporaryFile();
  TemporaryFile(TemporaryFile&& other) noexcept;
  TemporaryFile&
  operator=(TemporaryFile&& other) noexcept;

  /** \brief Makes one.
   * \return false if that fails; errno says why
   */
  bool
  create();

  bool
  exists() const
  {
    return descriptor_ >= 0;
  }

  int
  descriptor() const
  {
    return descriptor_;
  }

  /** \brief A path at which it can be opened. */
  const std::string&
  path() const
  {
    return path_;
  }

private:
  int descriptor_ = -1;
  std::string path_;
};

/** \brief Copies an input that cannot seek, such as a pipe, into a temporary file.
 * Devices and terminals are refused, as they may have no end.
 *
 * It is exported for the program pcl_ext, which reads clouds, too, from pipes.
 * \param[in] input descriptor of the input
 * \param[in] name of the input, for messages
 * \param[in] is_wanted is asked after signals and before each part; false ends the
 * copy. Empty: it is wanted
 * \param[in] beginning bytes of the input that were read already
 * \param[out] copy is empty after a failure
 */
PCL_EXT_RECORDING_EXPORT RecordingStatus
copyToTemporaryFile(int input,
                    const std::string& name,
                    const std::function<bool()>& is_wanted,
                    const std::vector<std::uint8_t>& beginning,
                    TemporaryFile& copy);

} // namespace pcl_ext::PCL_EXT_ABI::recording

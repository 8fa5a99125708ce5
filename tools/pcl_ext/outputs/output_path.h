// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/recording/recording_status.h>

#include "recording/output_paths.h"

#include <string>
#include <vector>

namespace pcl_ext::tools {

using recording::OutputKind;

/** \brief An output that the user named. */
struct Output {
  std::string path;
  bool may_replace = false; ///< what is there

  /** \brief What becomes of a file that is there when all is written. */
  recording::ExistingFile
  existing() const
  {
    return may_replace ? recording::ExistingFile::Replace
                       : recording::ExistingFile::Keep;
  }
};

/** \brief The kind of an output by its name.
 * \throws UsageError for other extensions
 */
OutputKind
kindOfOutput(const std::string& path);

/** \brief Refuses an output that cannot become one: a device, a folder that exists, the
 * standard output if it is a terminal.
 * \throws UsageError, also as kindOfOutput()
 */
void
checkOutput(const std::string& path);

/** \brief Refuses devices and pipes, which cannot be given a name when all is written.
 * \throws UsageError
 */
void
refuseDevice(const std::string& path);

/** \brief What is added to the name of an output until it is complete. */
constexpr const char* unfinished_suffix = ".unfinished";

/** \brief Refuses an output that is an input, as reading it would fail half way, or a
 * file in the folder of an input bag, whose part it would be; and a file that exists,
 * unless it may be replaced.
 * \throws UsageError
 */
void
refuseTakenFile(const std::vector<std::string>& inputs,
                const std::string& output,
                bool may_replace);

} // namespace pcl_ext::tools

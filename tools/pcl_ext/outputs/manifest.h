// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "outputs/output_path.h"
#include "recording/system_files.h"

#include <nlohmann/json.hpp>

#include <cstdint>
#include <map>
#include <string>

namespace pcl_ext::tools {

/** \brief What tells whether an input has changed. */
struct InputState {
  std::uintmax_t bytes = 0;
  std::int64_t mtime_ns = 0; ///< since 1970, of the file of the folder changed last

  bool
  operator==(const InputState& other) const
  {
    return bytes == other.bytes && mtime_ns == other.mtime_ns;
  }
};

/** \brief The state of a file, or of all files in a folder.
 * \throws std::runtime_error if it cannot be read
 */
InputState
stateOf(const std::string& path);

/** \brief A bag and the recording that is made of it. */
struct BagToEncode {
  std::string input;
  std::string output;
};

/** \brief Which bags of a folder of recordings are done, so that a run goes on where
 * another one ended: a file in that folder, with a line of JSON when a bag is begun and
 * one when it is finished. The last line of a bag holds. */
class Manifest {
public:
  static constexpr const char* file_name = "manifest.jsonl";

  /** \brief Opens or makes the manifest of a folder, which it makes, too.
   * \param[in] options with which bags are encoded, as text
   * \param[in] forgets_others bags that were encoded with other options, and recordings
   *   of other bags, are not done, instead of refused
   * \throws UsageError if another run uses the folder
   * \throws std::runtime_error if it cannot be read or written
   */
  Manifest(const std::string& folder, const std::string& options, bool forgets_others);

  /** \brief True if a recording of a bag is complete and the bag unchanged.
   * \throws UsageError if it is one of another bag, or what is at its place was encoded
   * with other options
   */
  bool
  isDone(const BagToEncode& bag) const;

  /** \brief True if what is at the place of an output is of this run or one before. */
  bool
  isOwn(const BagToEncode& bag) const;

  nlohmann::ordered_json
  lineOf(const BagToEncode& bag) const;

  /** \brief Notes that a bag is begun. */
  void
  begin(const BagToEncode& bag);

  /** \brief Notes what became of a bag.
   * \param[in] line "status", "frames" and what else there is to tell
   */
  void
  finish(const BagToEncode& bag, const nlohmann::ordered_json& line);

private:
  void
  read();

  void
  append(const nlohmann::ordered_json& line);

  std::string path_;
  std::string options_;
  bool forgets_others_;
  recording::Descriptor file_;
  std::map<std::string, nlohmann::ordered_json> lines_; // by the name of the output
};

} // namespace pcl_ext::tools

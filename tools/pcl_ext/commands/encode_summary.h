// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "options/encoding_options.h"
#include "streams/stream_encoder.h"

#include <nlohmann/json_fwd.hpp>

#include <cstddef>
#include <string>
#include <vector>

namespace pcl_ext::tools {

/** \brief What became of the clouds of a stream. */
struct StreamSummary {
  std::string name;
  std::size_t frames = 0;
  std::size_t bytes = 0;    ///< of the frames
  std::size_t failures = 0; ///< clouds that could not be read or encoded
};

/** \brief What became of a bag, or of the files of one output. */
struct BagSummary {
  std::vector<StreamSummary> streams; ///< without those that are refused
  EncodedSums sums;
  std::size_t failures = 0; ///< clouds, of all streams
  std::size_t other_messages = 0;
  double bytes_a_second = 0.0; ///< of all frames; 0: unknown
};

/** \brief The line of a summary.
 * \param[in] interruption see FrameOutput::finish()
 */
std::string
describeBag(const std::string& output,
            const BagSummary& summary,
            const EncodingOptions& options,
            const std::string& interruption);

/** \brief What became of a bag: "done", "incomplete" (a part is lost), "interrupted" or
 * "failed" (nothing was written). */
std::string
statusName(int exit_status);

/** \brief A text that is UTF-8 whatever names it has, with a line end. */
std::string
asText(const nlohmann::ordered_json& json);

/** \brief A bag for programs.
 * \param[in] status see statusName()
 * \param[in] errors that were printed
 */
nlohmann::ordered_json
toJson(const std::vector<std::string>& inputs,
       const std::string& output,
       const std::string& status,
       const BagSummary& summary,
       const std::vector<std::string>& errors);

} // namespace pcl_ext::tools

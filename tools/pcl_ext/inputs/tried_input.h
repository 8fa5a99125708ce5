// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "console/console.h"
#include "inputs/held_clouds.h"
#include "options/encoding_options.h"

#include <CLI/App.hpp>

#include <string>
#include <vector>

namespace pcl_ext::tools {

/** \brief Clouds on which settings are tried, and nothing is written: the input of
 * encode or the simulated robot cell. */
struct TriedInput {
  InputOptions input;
  bool takes_cell = false; ///< or there is no input
};

/** \brief Adds the input, --cell, --rate, --bin-fields and --topics.
 * \param[in] description of the input
 */
void
addTriedInput(CLI::App& app,
              TriedInput& tried,
              const std::string& description = "clouds or a bag, as encode takes them");

/** \brief Completes and checks what addTriedInput() added.
 * \param[in,out] options the cell has a resolution and a law of its own, unless they are
 * given
 * \throws UsageError if both or options of the other one are given
 */
void
completeTriedInput(const CLI::App& app, TriedInput& tried, EncodingOptions& options);

/** \brief Reads the first clouds of the streams, and prints what could not be read.
 * \param[in,out] options the cell has a pose, a crop box and a sensor of its own
 * \param[in] clouds the most of each stream; of the cell 60
 * \throws UsageError if options name a stream that there is not
 */
std::vector<HeldClouds>
holdTriedInput(const TriedInput& tried,
               EncodingOptions& options,
               std::size_t clouds,
               Console& console);

/** \brief An option that the user gave. */
struct GivenOption {
  std::string name;  ///< with its hyphens
  std::string value; ///< empty: none
  bool is_flag = false;

  /** \brief As a shell takes it. */
  std::string
  text() const;
};

/** \brief The options that the user gave, but no inputs. */
std::vector<GivenOption>
givenOptions(const CLI::App& app);

/** \brief A word as a shell takes it. */
std::string
quoted(const std::string& word);

} // namespace pcl_ext::tools

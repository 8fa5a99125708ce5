// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

namespace pcl_ext::tools {

/** \brief Largest recording that is put into a page, bytes. It is a text there, and
 * browsers have none of more than 2^29 characters; four of these are three bytes. */
constexpr std::uint64_t max_embedded_bytes = 384'000'000;

/** \brief Refuses a recording that is too large for a page; a folder is not looked
 * into.
 * \throws std::runtime_error
 */
void
checkSizeForPage(const std::string& recording);

/** \brief Reads the viewer's page.
 * \param[in] path of it; empty: the one that was installed or built with this program
 * \throws std::runtime_error with the remedy if there is none, and if it is another page
 */
std::string
readPage(const std::string& path);

/** \brief Writes a page with a recording in it, beside its name until it is complete.
 * \param[in] page of readPage()
 * \param[in] recording path of a file
 * \param[in] output path of the page to write
 * \return bytes of it; 0: the program was interrupted, and there is no output
 * \throws std::runtime_error
 */
std::uint64_t
writePageWithRecording(const std::string& page,
                       const std::string& recording,
                       const std::string& output);

} // namespace pcl_ext::tools

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <cstddef>
#include <string_view>

namespace pcl_ext {

/** \brief Bytes of the character of UTF-8 that begins somewhere; 0: there is none.
 * \param[in] at below the size of the text
 */
inline std::size_t
utf8CharacterLength(std::string_view text, std::size_t at)
{
  const auto byteAt = [text](std::size_t i) {
    return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u;
  };
  const unsigned int first = byteAt(at);
  if (first < 0x80)
    return 1;
  if (first < 0xc2 || first > 0xf4)
    return 0;
  // What the second byte is at least and at most: no longer forms of other characters,
  // surrogates, or numbers above U+10FFFF.
  const unsigned int least = first == 0xe0 ? 0xa0 : first == 0xf0 ? 0x90 : 0x80;
  const unsigned int most = first == 0xed ? 0x9f : first == 0xf4 ? 0x8f : 0xbf;
  if (byteAt(at + 1) < least || byteAt(at + 1) > most)
    return 0;
  const std::size_t length = first < 0xe0 ? 2 : first < 0xf0 ? 3 : 4;
  for (std::size_t i = 2; i < length; ++i)
    if (byteAt(at + i) < 0x80 || byteAt(at + i) > 0xbf)
      return 0;
  return length;
}

} // namespace pcl_ext

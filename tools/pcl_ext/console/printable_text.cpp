// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "console/printable_text.h"

#include "bytes/utf8.h"

#include <cstddef>
#include <cstdio>

namespace pcl_ext::tools {

namespace {

/** \brief True if a character changes the direction of the text: U+202A to U+202E,
 * U+2066 to U+2069. */
bool
isDirection(const std::string& text, std::size_t at)
{
  const std::string character = text.substr(at, 3);
  return (character >= "\xe2\x80\xaa" && character <= "\xe2\x80\xae") ||
         (character >= "\xe2\x81\xa6" && character <= "\xe2\x81\xa9");
}

/** \brief True if a character controls the terminal: below U+0020, U+007F to U+009F. */
bool
isControl(const std::string& text, std::size_t at)
{
  const auto first = static_cast<unsigned char>(text[at]);
  return first < 0x20 || first == 0x7f ||
         (first == 0xc2 && static_cast<unsigned char>(text[at + 1]) < 0xa0);
}

/** \brief Bytes of the character of UTF-8 that begins somewhere; 0: there is none, or
 * it controls the terminal. */
std::size_t
lengthOfCharacter(const std::string& text, std::size_t at)
{
  const std::size_t length = utf8CharacterLength(text, at);
  return length == 0 || isControl(text, at) || isDirection(text, at) ? 0 : length;
}

} // namespace

std::string
printable(const std::string& text)
{
  std::string shown;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = lengthOfCharacter(text, at);
    if (length > 0) {
      shown.append(text, at, length);
      at += length;
      continue;
    }
    char escaped[5];
    std::snprintf(
        escaped, sizeof(escaped), "\\x%02x", static_cast<unsigned char>(text[at]));
    shown += escaped;
    ++at;
  }
  return shown;
}

} // namespace pcl_ext::tools

#include "console/printable_text.h"

#include <cstddef>
#include <cstdio>

namespace pcl_ext {
namespace tools {

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

/** \brief Bytes of the character of UTF-8 that begins somewhere; 0: there is none, or
 * it controls the terminal. */
std::size_t
lengthOfCharacter(const std::string& text, std::size_t at)
{
  const auto byteAt = [&text](std::size_t i) {
    return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u;
  };
  const unsigned int first = byteAt(at);
  if (first < 0x80)
    return first >= 0x20 && first != 0x7f ? 1 : 0;
  if (first < 0xc2 || first > 0xf4)
    return 0;
  // What the second byte is at least and at most: no controls of U+0080 to U+009F,
  // longer forms of other characters, surrogates, or numbers above U+10FFFF.
  const unsigned int least = first == 0xc2 || first == 0xe0 ? 0xa0
                             : first == 0xf0                ? 0x90
                                                            : 0x80;
  const unsigned int most = first == 0xed ? 0x9f : first == 0xf4 ? 0x8f : 0xbf;
  if (byteAt(at + 1) < least || byteAt(at + 1) > most)
    return 0;
  const std::size_t length = first < 0xe0 ? 2 : first < 0xf0 ? 3 : 4;
  for (std::size_t i = 2; i < length; ++i)
    if (byteAt(at + i) < 0x80 || byteAt(at + i) > 0xbf)
      return 0;
  return isDirection(text, at) ? 0 : length;
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

} // namespace tools
} // namespace pcl_ext

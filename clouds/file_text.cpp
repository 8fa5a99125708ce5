// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "clouds/file_text.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <system_error>

namespace pcl_ext {
namespace clouds {

namespace {

template <typename NumberT>
bool
isWhole(std::string_view word, NumberT& number)
{
  const char* const end = word.data() + word.size();
  const auto result = std::from_chars(word.data(), end, number);
  return result.ec == std::errc() && result.ptr == end;
}

template <typename NumberT>
void
appendBytes(NumberT number, std::vector<std::uint8_t>& bytes)
{
  const std::size_t size = bytes.size();
  bytes.resize(size + sizeof(number));
  std::memcpy(&bytes[size], &number, sizeof(number));
}

template <typename NumberT>
bool
appendWhole(std::string_view word, std::vector<std::uint8_t>& bytes)
{
  NumberT number = 0;
  if (!isWhole(word, number))
    return false;
  appendBytes(number, bytes);
  return true;
}

bool
appendReal(std::string_view word, std::uint64_t size, std::vector<std::uint8_t>& bytes)
{
  float number = 0.0f;
  if (size == sizeof(float) && isWhole(word, number)) {
    appendBytes(number, bytes);
    return true;
  }
  // Also of 4 bytes, as a number that is too small for a float is 0, and one that is too
  // large infinite.
  double precise = 0.0;
  if (!isWhole(word, precise))
    return false;
  constexpr float infinity = std::numeric_limits<float>::infinity();
  if (size == sizeof(double))
    appendBytes(precise, bytes);
  else if (std::abs(precise) < 1.0)
    appendBytes(0.0f, bytes);
  else
    appendBytes(precise < 0.0 ? -infinity : infinity, bytes);
  return true;
}

/** \brief Appends a whole number.
 * \return false if the word is none, or none of the field
 */
bool
appendInteger(std::string_view word,
              const FileField& field,
              std::vector<std::uint8_t>& bytes)
{
  // The 32 bits of a colour are written as either.
  if ((field.name == "rgb" || field.name == "rgba") && field.bytes == 4)
    return appendWhole<std::uint32_t>(word, bytes) ||
           appendWhole<std::int32_t>(word, bytes);
  return visitZero(field,
                   [&](auto zero) { return appendWhole<decltype(zero)>(word, bytes); });
}

/** \brief Appends the number that a word is.
 * \return false if it is no number of the field
 */
bool
appendNumber(std::string_view word,
             const FileField& field,
             std::vector<std::uint8_t>& bytes)
{
  if (field.kind == FieldKind::Ignored) {
    bytes.resize(bytes.size() + field.bytes);
    return true;
  }
  if (word.size() > 1 && word[0] == '+' && word[1] != '-')
    word.remove_prefix(1);
  if (field.kind == FieldKind::Real)
    return appendReal(word, field.bytes, bytes);
  if (appendInteger(word, field, bytes))
    return true;
  // Whole numbers may be written as 255.0.
  double number = 0.0;
  constexpr double most = 9007199254740992.0; // has each whole number up to it
  return isWhole(word, number) && std::abs(number) <= most &&
         number == std::floor(number) &&
         appendInteger(std::to_string(static_cast<std::int64_t>(number)), field, bytes);
}

/** \brief The words of a line, one after the other. */
class Words {
public:
  explicit Words(std::string_view line) : rest_(line) {}

  /** \brief The next word; empty at the end. */
  std::string_view
  next()
  {
    constexpr std::string_view blanks = " \t\r";
    rest_.remove_prefix(std::min(rest_.find_first_not_of(blanks), rest_.size()));
    const std::string_view word = rest_.substr(0, rest_.find_first_of(blanks));
    rest_.remove_prefix(word.size());
    return word;
  }

private:
  std::string_view rest_;
};

/** \brief The words of a line in which commas are between numbers, with blanks in their
 * place: only if there are as many numbers as promised, as 1,5 may be one number. */
std::string
withoutCommas(const std::string& line, const std::vector<FileField>& fields)
{
  std::uint64_t promised = 0;
  for (const FileField& field : fields)
    promised += field.count;
  std::string separated = line;
  std::replace(separated.begin(), separated.end(), ',', ' ');
  Words words(separated);
  std::uint64_t count = 0;
  while (!words.next().empty())
    ++count;
  return count == promised ? separated : line;
}

bool
isBlank(const std::string& line)
{
  return line.find_first_not_of(" \t\r") == std::string::npos;
}

void
readPoint(const std::string& line,
          const std::vector<FileField>& fields,
          std::uint64_t number,
          std::vector<std::uint8_t>& bytes)
{
  const auto failAtLine = [number](const std::string& reason) {
    fail("line " + std::to_string(number) + reason);
  };
  Words words(line);
  std::uint64_t count = 0;
  for (const FileField& field : fields) {
    if (field.kind == FieldKind::IgnoredList) {
      std::uint64_t numbers = 0;
      bool is_whole = isWhole(words.next(), numbers);
      for (; is_whole && numbers > 0; --numbers)
        is_whole = !words.next().empty();
      if (!is_whole)
        failAtLine(": the list '" + shownText(field.name) +
                   "' has fewer numbers than it promises");
      continue;
    }
    for (std::uint64_t i = 0; i < field.count; ++i, ++count) {
      const std::string_view word = words.next();
      if (word.empty())
        failAtLine(" has " + std::to_string(count) +
                   " numbers, fewer than its header promises");
      if (!appendNumber(word, field, bytes))
        failAtLine(": '" + shownText(std::string(word)) +
                   "' is no number of the field '" + shownText(field.name) + "'" +
                   (word.find(',') != word.npos
                        ? "; numbers are written as 1.5, and blanks "
                          "are between them"
                        : ""));
    }
  }
  if (!words.next().empty())
    failAtLine(" has more than " + std::to_string(count) +
               " numbers, which its header promises");
}

} // namespace

void
fail(const std::string& reason)
{
  throw std::runtime_error(reason);
}

std::string
upperCase(std::string word)
{
  for (char& letter : word)
    if (letter >= 'a' && letter <= 'z')
      letter = static_cast<char>(letter - 'a' + 'A');
  return word;
}

std::string
lowerCase(std::string word)
{
  for (char& letter : word)
    if (letter >= 'A' && letter <= 'Z')
      letter = static_cast<char>(letter - 'A' + 'a');
  return word;
}

bool
isCoordinateName(const std::string& name)
{
  const std::string small = lowerCase(name);
  return small == "x" || small == "y" || small == "z";
}

std::uint64_t
bytesOf(const std::vector<FileField>& fields)
{
  std::uint64_t bytes = 0;
  for (const FileField& field : fields)
    bytes += field.bytes * field.count;
  return bytes;
}

std::string
shownText(std::string text)
{
  constexpr std::size_t longest = 40;
  text.resize(std::min(text.size(), longest));
  for (char& character : text)
    if (std::isprint(static_cast<unsigned char>(character)) == 0)
      character = '?';
  return text;
}

std::vector<std::string>
wordsOf(const std::string& line)
{
  std::istringstream stream(line);
  std::vector<std::string> words;
  std::string word;
  while (stream >> word)
    words.push_back(word);
  return words;
}

bool
isCount(const std::string& text)
{
  constexpr std::size_t most_digits = 18;
  return !text.empty() && text.size() <= most_digits &&
         text.find_first_not_of("0123456789") == std::string::npos;
}

std::uint64_t
countOf(const std::string& name, const std::string& text)
{
  if (!isCount(text))
    fail("its header has no valid " + name);
  return std::stoull(text);
}

char
lineEndOf(std::istream& file)
{
  const std::istream::pos_type begin = file.tellg();
  int next = file.get();
  for (std::uint64_t bytes = 0; bytes < most_header_bytes && next != '\n' &&
                                next != '\r' && next != std::char_traits<char>::eof();
       ++bytes)
    next = file.get();
  const char end = next == '\r' && file.peek() != '\n' ? '\r' : '\n';
  file.clear();
  file.seekg(begin);
  return end;
}

bool
readLine(std::istream& file, std::string& line, char end, std::uint64_t most)
{
  line.clear();
  for (int next = file.get(); next != std::char_traits<char>::eof();
       next = file.get()) {
    if (next == end)
      return true;
    if (line.size() == most)
      return false;
    line += static_cast<char>(next);
  }
  return !line.empty();
}

void
readTextPoints(std::istream& file,
               char end,
               const std::vector<FileField>& fields,
               std::uint64_t points,
               std::uint64_t header_lines,
               std::vector<std::uint8_t>& bytes)
{
  std::string line;
  std::uint64_t number = header_lines;
  for (std::uint64_t point = 0; point < points;) {
    ++number;
    if (!readLine(file, line, end))
      fail(line.empty() ? "it was cut off: it has " + std::to_string(point) +
                              " lines of points, not " + std::to_string(points)
                        : "line " + std::to_string(number) + " is too long");
    if (isBlank(line))
      continue;
    readPoint(line.find(',') == line.npos ? line : withoutCommas(line, fields),
              fields,
              number,
              bytes);
    ++point;
  }
}

std::string
describeFurtherLines(std::istream& file, char end)
{
  std::string line;
  while (readLine(file, line, end))
    if (!isBlank(line))
      return "lines after the points that its header promises are left out: '" +
             shownText(line) + "'";
  return {};
}

std::string
describeFurtherPoints(std::uint64_t further_bytes, std::uint64_t point_bytes)
{
  if (point_bytes == 0 || further_bytes < point_bytes)
    return {};
  return std::to_string(further_bytes) +
         " bytes after the points that its header promises are left out";
}

} // namespace clouds
} // namespace pcl_ext

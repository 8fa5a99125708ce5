#include "clouds/text_points.h"

#include <algorithm>
#include <cctype>
#include <charconv>
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

bool
isNumber(std::string_view word, const TextField& field)
{
  if (field.kind == TextField::Kind::Ignored)
    return true;
  if (word.size() > 1 && word[0] == '+' && word[1] != '-')
    word.remove_prefix(1);
  const std::uint64_t bits = 8 * field.bytes;
  if (field.kind == TextField::Kind::Unsigned) {
    std::uint64_t number = 0;
    return isWhole(word, number) && (bits >= 64 || number >> bits == 0);
  }
  if (field.kind == TextField::Kind::Signed) {
    std::int64_t number = 0;
    const std::int64_t most = INT64_MAX >> (64 - std::min<std::uint64_t>(bits, 64));
    return isWhole(word, number) && number <= most && number >= -most - 1;
  }
  double number = 0.0;
  return isWhole(word, number);
}

/** \brief A word of a file for messages: short, and in letters of ASCII. */
std::string
shown(std::string_view word)
{
  std::string text(word.substr(0, 40));
  for (char& character : text)
    if (std::isprint(static_cast<unsigned char>(character)) == 0)
      character = '?';
  return text;
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

void
checkLine(const std::string& line,
          const std::vector<TextField>& fields,
          std::uint64_t number)
{
  const auto fail = [number](const std::string& reason) {
    throw std::runtime_error("line " + std::to_string(number) + reason);
  };
  Words words(line);
  std::uint64_t count = 0;
  for (const TextField& field : fields)
    for (std::uint64_t i = 0; i < field.count; ++i, ++count) {
      const std::string_view word = words.next();
      if (word.empty())
        fail(" has " + std::to_string(count) +
             " numbers, fewer than its header promises");
      if (!isNumber(word, field))
        fail(": '" + shown(word) + "' is no number of the field '" + shown(field.name) +
             "'" +
             (word.find(',') != word.npos ? "; numbers are written as 1.5, and blanks "
                                            "are between them"
                                          : ""));
    }
  if (!words.next().empty())
    fail(" has more than " + std::to_string(count) +
         " numbers, which its header promises");
}

} // namespace

bool
readLine(std::istream& file, std::string& line)
{
  constexpr std::size_t longest = std::size_t{1} << 16;
  line.clear();
  for (int next = file.get(); next != std::char_traits<char>::eof();
       next = file.get()) {
    if (next == '\n')
      return true;
    if (line.size() == longest)
      return false;
    line += static_cast<char>(next);
  }
  return !line.empty();
}

void
checkTextPoints(std::istream& file,
                const std::vector<TextField>& fields,
                std::uint64_t points,
                std::uint64_t header_lines,
                bool may_have_empty_lines)
{
  std::string line;
  std::uint64_t number = header_lines;
  for (std::uint64_t point = 0; point < points;) {
    ++number;
    if (!readLine(file, line))
      throw std::runtime_error(
          line.empty() ? "it was cut off: it has " + std::to_string(point) +
                             " lines of points, not " + std::to_string(points)
                       : "line " + std::to_string(number) + " is too long");
    if (line.empty() && may_have_empty_lines)
      continue;
    checkLine(line, fields, number);
    ++point;
  }
}

} // namespace clouds
} // namespace pcl_ext

#include "standard_input.h"

#include "interruption.h"

#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <vector>

namespace pcl_ext {
namespace tools {

namespace {

std::string kept_path; // empty: the standard input was not read

} // namespace

std::string
keepStandardInput()
{
  if (!kept_path.empty()) // it can be read once only
    return kept_path;
  std::FILE* const file = std::tmpfile();
  const auto fail = [](const std::string& what) {
    throw std::runtime_error(what + ": " + std::strerror(errno));
  };
  if (file == nullptr)
    fail("cannot make a file for the standard input in /tmp");
  std::vector<char> bytes(std::size_t{1} << 20);
  while (true) {
    // Unlike read() it ends with a signal.
    pollfd input{STDIN_FILENO, POLLIN, 0};
    ::poll(&input, 1, -1);
    if (isInterrupted())
      throw std::runtime_error("interrupted while reading the standard input");
    const ssize_t count = ::read(STDIN_FILENO, bytes.data(), bytes.size());
    if (count == 0)
      break;
    if (count < 0)
      fail("reading the standard input failed");
    if (std::fwrite(bytes.data(), 1, static_cast<std::size_t>(count), file) !=
        static_cast<std::size_t>(count))
      fail("keeping the standard input in /tmp failed");
  }
  if (std::fflush(file) != 0)
    fail("keeping the standard input in /tmp failed");
  kept_path = "/proc/self/fd/" + std::to_string(fileno(file));
  return kept_path;
}

std::string
pathOfInput(const std::string& path)
{
  return path == "-" ? keepStandardInput() : path;
}

std::string
shown(std::string text)
{
  for (std::size_t at = 0;
       !kept_path.empty() && (at = text.find(kept_path, at)) != std::string::npos;)
    text.replace(at, kept_path.size(), "standard input");
  return text;
}

} // namespace tools
} // namespace pcl_ext

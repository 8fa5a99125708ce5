#include "standard_input.h"

#include "interruption.h"
#include "recording/temporary_copy.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cctype>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <map>
#include <stdexcept>

namespace pcl_ext {
namespace tools {

namespace {

constexpr const char* standard_input = "-";

/** \brief Paths of copies by the path that the user gave: a pipe can be read once only. */
std::map<std::string, std::string> copies;

std::string
shownName(const std::string& path)
{
  return path == standard_input ? "standard input" : path;
}

std::string
pathOfDescriptor(int descriptor)
{
  return "/proc/self/fd/" + std::to_string(descriptor);
}

/** \brief Opens an input that is no regular file. A pipe without a writer is waited for
 * later, where an interruption ends it. */
int
openInput(const std::string& path)
{
  const int descriptor = path == standard_input
                             ? ::dup(STDIN_FILENO)
                             : ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0)
    throw std::runtime_error("cannot open '" + shownName(path) +
                             "': " + std::strerror(errno));
  if (path != standard_input)
    ::fcntl(descriptor, F_SETFL, ::fcntl(descriptor, F_GETFL) & ~O_NONBLOCK);
  return descriptor;
}

std::string
keepCopy(const std::string& path)
{
  const int input = openInput(path);
  int copy = -1;
  const recording::RecordingStatus status = recording::copyToTemporaryFile(
      input, shownName(path), [] { return !isInterrupted(); }, copy);
  ::close(input);
  if (!status.ok())
    throw std::runtime_error(status.message());
  return pathOfDescriptor(copy);
}

} // namespace

std::string
pathOfInput(const std::string& path)
{
  if (const auto known = copies.find(path); known != copies.end())
    return known->second;
  struct stat properties {};
  const int result = path == standard_input ? ::fstat(STDIN_FILENO, &properties)
                                            : ::stat(path.c_str(), &properties);
  const bool is_file =
      result == 0 && (S_ISREG(properties.st_mode) || S_ISDIR(properties.st_mode));
  if (path != standard_input && (result != 0 || is_file))
    return path;
  const std::string copy = is_file ? pathOfDescriptor(STDIN_FILENO) : keepCopy(path);
  return copies[path] = copy;
}

std::string
streamNameOfInput(const std::string& path)
{
  return path == standard_input ? "stdin" : std::filesystem::path(path).stem().string();
}

std::string
shown(std::string text)
{
  for (const auto& [given, copy] : copies)
    for (std::size_t at = 0; (at = text.find(copy, at)) != std::string::npos;) {
      const std::size_t end = at + copy.size();
      const bool is_longer =
          end < text.size() && std::isdigit(static_cast<unsigned char>(text[end])) != 0;
      if (!is_longer)
        text.replace(at, copy.size(), shownName(given));
      at += is_longer ? copy.size() : shownName(given).size();
    }
  return text;
}

} // namespace tools
} // namespace pcl_ext

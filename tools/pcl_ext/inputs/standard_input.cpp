#include "inputs/standard_input.h"

#include "console/interruption.h"
#include "recording/temporary_copy.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cctype>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <vector>

namespace pcl_ext {
namespace tools {

namespace {

constexpr const char* standard_input = "-";

/** \brief Paths of copies by the path that the user gave: a pipe can be read once
 * only. */
std::map<std::string, std::string> copies;

std::string
pathOfDescriptor(int descriptor)
{
  return "/proc/self/fd/" + std::to_string(descriptor);
}

/** \brief Opens an input that is no regular file. A pipe without a writer is waited for
 * later, where an interruption ends it. */
Descriptor
openInput(const std::string& path)
{
  Descriptor descriptor(path == standard_input
                            ? ::dup(STDIN_FILENO)
                            : ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (descriptor.get() < 0)
    throw std::runtime_error("cannot open '" + shownName(path) +
                             "': " + std::strerror(errno));
  if (path != standard_input)
    ::fcntl(
        descriptor.get(), F_SETFL, ::fcntl(descriptor.get(), F_GETFL) & ~O_NONBLOCK);
  return descriptor;
}

std::string
keepCopy(const std::string& path,
         const Descriptor& input,
         const std::vector<std::uint8_t>& beginning)
{
  int copy = -1;
  const recording::RecordingStatus status = recording::copyToTemporaryFile(
      input.get(), shownName(path), [] { return !isInterrupted(); }, beginning, copy);
  if (!status.ok())
    throw std::runtime_error(status.message());
  return pathOfDescriptor(copy);
}

} // namespace

Descriptor::~Descriptor()
{
  if (number_ >= 0)
    ::close(number_);
}

std::string
shownName(const std::string& path)
{
  return path == standard_input ? "standard input" : path;
}

bool
mustWaitFor(int descriptor)
{
  // Who writes a file into the pipe is a little slower than who reads it.
  constexpr int timeout_ms = 10;
  pollfd input{descriptor, POLLIN, 0};
  return ::poll(&input, 1, timeout_ms) == 0;
}

std::size_t
readPipe(int descriptor, std::uint8_t* bytes, std::size_t count)
{
  while (!isInterrupted()) {
    // Unlike read() it ends with a signal.
    pollfd input{descriptor, POLLIN, 0};
    constexpr int timeout_ms = 200;
    if (::poll(&input, 1, timeout_ms) <= 0)
      continue;
    const ssize_t read = ::read(descriptor, bytes, count);
    if (read >= 0)
      return static_cast<std::size_t>(read);
    if (errno != EINTR && errno != EAGAIN)
      throw std::runtime_error(std::string("reading a pipe failed: ") +
                               std::strerror(errno));
  }
  return 0;
}

std::optional<Descriptor>
mcapPipeOf(const std::string& path)
{
  struct stat properties {};
  const int result = path == standard_input ? ::fstat(STDIN_FILENO, &properties)
                                            : ::stat(path.c_str(), &properties);
  const bool is_pipe =
      result == 0 && (S_ISFIFO(properties.st_mode) || S_ISSOCK(properties.st_mode));
  if (!is_pipe || copies.count(path) != 0)
    return std::nullopt;
  constexpr char magic[] = "\x89MCAP0\r\n";
  Descriptor input = openInput(path);
  std::vector<std::uint8_t> beginning(sizeof(magic) - 1);
  std::size_t size = 0;
  while (size < beginning.size()) {
    const std::size_t read =
        readPipe(input.get(), &beginning[size], beginning.size() - size);
    if (read == 0)
      break;
    size += read;
  }
  beginning.resize(size);
  if (std::string(beginning.begin(), beginning.end()) == magic)
    return std::optional(std::move(input));
  copies[path] = keepCopy(path, input, beginning);
  return std::nullopt;
}

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
  const std::string copy =
      is_file ? pathOfDescriptor(STDIN_FILENO) : keepCopy(path, openInput(path), {});
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

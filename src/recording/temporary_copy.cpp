#include "recording/temporary_copy.h"

#include "recording/files.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <cstring>

namespace pcl_ext {
namespace recording {

namespace {

RecordingStatus
failure(const std::string& what)
{
  return {RecordingCode::InputFailed, what + ": " + std::strerror(errno)};
}

/** \brief Why an input is refused; empty if it is not. */
std::string
whyRefused(int input, const std::string& name)
{
  if (::isatty(input) != 0)
    return "'" + name + "' is a terminal: name a file, or pipe one into the program";
  struct stat properties {};
  if (::fstat(input, &properties) == 0 &&
      (S_ISCHR(properties.st_mode) || S_ISBLK(properties.st_mode)))
    return "'" + name + "' is a device: only files and pipes can be read";
  return {};
}

RecordingStatus
copyAll(int input,
        const std::string& name,
        const std::function<bool()>& is_wanted,
        int copy)
{
  std::array<std::uint8_t, std::size_t{1} << 16> buffer;
  for (;;) {
    // Unlike read() it returns after each signal, also one whose calls are restarted; a
    // signal that came before it is noticed after the timeout.
    pollfd waited{input, POLLIN, 0};
    constexpr int timeout_ms = 200;
    const int ready = ::poll(&waited, 1, timeout_ms);
    if (is_wanted && !is_wanted())
      return {RecordingCode::InputFailed, "interrupted while reading '" + name + "'"};
    if (ready == 0)
      continue;
    const ssize_t count = ::read(input, buffer.data(), buffer.size());
    if (count < 0 && (errno == EINTR || errno == EAGAIN))
      continue;
    if (count < 0)
      return failure("cannot read '" + name + "'");
    if (count == 0)
      return {};
    if (!writeAll(copy, buffer.data(), static_cast<std::size_t>(count)))
      return failure("cannot keep '" + name + "' in a temporary file");
  }
}

} // namespace

RecordingStatus
copyToTemporaryFile(int input,
                    const std::string& name,
                    const std::function<bool()>& is_wanted,
                    const std::vector<std::uint8_t>& beginning,
                    int& copy)
{
  if (const std::string reason = whyRefused(input, name); !reason.empty())
    return {RecordingCode::InputFailed, reason};
  const char* folder = std::getenv("TMPDIR");
  std::string path =
      std::string(folder != nullptr ? folder : "/tmp") + "/pcl_extXXXXXX";
  copy = ::mkostemp(path.data(), O_CLOEXEC);
  if (copy < 0)
    return failure("cannot make the temporary file '" + path + "' for '" + name + "'");
  ::unlink(path.c_str());
  const RecordingStatus status =
      writeAll(copy, beginning.data(), beginning.size())
          ? copyAll(input, name, is_wanted, copy)
          : failure("cannot keep '" + name + "' in a temporary file");
  if (!status.ok())
    ::close(copy);
  return status;
}

} // namespace recording
} // namespace pcl_ext

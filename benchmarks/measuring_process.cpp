#include "measuring_process.h"

#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <system_error>

namespace pcl_ext {
namespace measuring {

namespace {

/** \brief The frame number that ends a process. */
constexpr std::uint64_t no_more_frames = std::numeric_limits<std::uint64_t>::max();

/** \brief Header of a result. */
struct ResultHeader {
  std::uint64_t is_error = 0; ///< the bytes are a message
  std::uint64_t bytes = 0;
};

bool
sendAll(int socket, const void* bytes, std::size_t size)
{
  const char* remaining = static_cast<const char*>(bytes);
  while (size > 0) {
    const ssize_t sent = send(socket, remaining, size, MSG_NOSIGNAL);
    if (sent <= 0)
      return false;
    remaining += sent;
    size -= static_cast<std::size_t>(sent);
  }
  return true;
}

bool
receiveAll(int socket, void* bytes, std::size_t size)
{
  return size == 0 ||
         recv(socket, bytes, size, MSG_WAITALL) == static_cast<ssize_t>(size);
}

template <typename BytesT>
bool
sendResult(int socket, bool is_error, const BytesT& bytes)
{
  const ResultHeader header{is_error ? 1u : 0u, bytes.size()};
  return sendAll(socket, &header, sizeof(header)) &&
         sendAll(socket, bytes.data(), bytes.size());
}

/** \brief Loop of the new process. */
void
serve(int socket, const std::function<MeasuringProcess::Measure()>& make)
{
  MeasuringProcess::Measure measure;
  std::uint64_t frame = 0;
  bool is_connected = true;
  while (is_connected && receiveAll(socket, &frame, sizeof(frame)) &&
         frame != no_more_frames) {
    try {
      if (!measure)
        measure = make();
      is_connected = sendResult(socket, false, measure(frame));
    }
    catch (const std::exception& error) {
      is_connected = sendResult(socket, true, std::string(error.what()));
    }
  }
}

} // namespace

MeasuringProcess::MeasuringProcess(const std::function<Measure()>& make)
{
  int sockets[2];
  if (socketpair(AF_UNIX, SOCK_STREAM, 0, sockets) != 0)
    throw std::system_error(errno, std::generic_category(), "socketpair");
  process_ = fork();
  if (process_ < 0) {
    const int error = errno;
    close(sockets[0]);
    close(sockets[1]);
    throw std::system_error(error, std::generic_category(), "fork");
  }
  if (process_ == 0) {
    // Ends with the parent, even if that is killed.
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    close(sockets[0]);
    serve(sockets[1], make);
    // Not exit(), which would print what the parent has buffered.
    _exit(0);
  }
  close(sockets[1]);
  socket_ = sockets[0];
}

MeasuringProcess::~MeasuringProcess()
{
  sendAll(socket_, &no_more_frames, sizeof(no_more_frames));
  close(socket_);
  waitpid(process_, nullptr, 0);
}

std::vector<char>
MeasuringProcess::measure(std::size_t frame)
{
  const std::uint64_t number = frame;
  ResultHeader header;
  if (!sendAll(socket_, &number, sizeof(number)) ||
      !receiveAll(socket_, &header, sizeof(header)))
    throw std::runtime_error("the process ended; is there enough memory?");
  std::vector<char> bytes(header.bytes);
  if (!receiveAll(socket_, bytes.data(), bytes.size()))
    throw std::runtime_error("the process ended within its result");
  if (header.is_error != 0)
    throw std::runtime_error(std::string(bytes.begin(), bytes.end()));
  return bytes;
}

} // namespace measuring
} // namespace pcl_ext

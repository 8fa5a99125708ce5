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

/** \brief What comes before the bytes of an answer. */
struct AnswerHeader {
  std::uint64_t is_error = 0; ///< the bytes are a message
  std::uint64_t bytes = 0;
};

bool
sendAll(int socket, const void* bytes, std::size_t size)
{
  const char* rest = static_cast<const char*>(bytes);
  while (size > 0) {
    const ssize_t sent = send(socket, rest, size, MSG_NOSIGNAL);
    if (sent <= 0)
      return false;
    rest += sent;
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
answer(int socket, bool is_error, const BytesT& bytes)
{
  const AnswerHeader header{is_error ? 1u : 0u, bytes.size()};
  return sendAll(socket, &header, sizeof(header)) &&
         sendAll(socket, bytes.data(), bytes.size());
}

/** \brief What the new process does until it is told to end. */
void
serve(int socket, const std::function<MeasuringProcess::Measure()>& make)
{
  MeasuringProcess::Measure measure;
  std::uint64_t frame = 0;
  bool goes_on = true;
  while (goes_on && receiveAll(socket, &frame, sizeof(frame)) &&
         frame != no_more_frames) {
    try {
      if (!measure)
        measure = make();
      goes_on = answer(socket, false, measure(frame));
    }
    catch (const std::exception& error) {
      goes_on = answer(socket, true, std::string(error.what()));
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
    // Or it would wait for ever for a parent that was killed.
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    close(sockets[0]);
    serve(sockets[1], make);
    // Not exit: what the parent has not printed yet is the parent's.
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
  AnswerHeader header;
  if (!sendAll(socket_, &number, sizeof(number)) ||
      !receiveAll(socket_, &header, sizeof(header)))
    throw std::runtime_error("the process died; is there enough memory?");
  std::vector<char> bytes(header.bytes);
  if (!receiveAll(socket_, bytes.data(), bytes.size()))
    throw std::runtime_error("the process died in the midst of its answer");
  if (header.is_error != 0)
    throw std::runtime_error(std::string(bytes.begin(), bytes.end()));
  return bytes;
}

} // namespace measuring
} // namespace pcl_ext

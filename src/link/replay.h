#pragma once

#include "link/connection.h"

#include <chrono>

namespace pcl_ext {
namespace link {

/** \brief Reads the frames of a site that a server keeps, in the order of their arrival.
 * For one thread at a time. */
class Replay {
public:
  Replay() = default;
  ~Replay();
  Replay(const Replay&) = delete;
  Replay&
  operator=(const Replay&) = delete;

  /** \brief Begins.
   * \param[in] connection an open one, which outlives this
   * \param[in] from time of arrival of the first frame; 0: the oldest one
   */
  LinkStatus
  open(const Connection& connection, Time from);

  /** \brief The next message.
   * \return EndOfReplay after the last one; NoFrame if none came in time
   */
  LinkStatus
  next(std::chrono::nanoseconds timeout, MessageHandle& message);

private:
  JetStreamHandle stream_;
  natsSubscription* subscription_ = nullptr;
  bool is_at_end_ = false;
};

} // namespace link
} // namespace pcl_ext

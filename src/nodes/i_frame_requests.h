#pragma once

#include <cstddef>

namespace pcl_ext {
namespace nodes {

/** \brief Decides when requests for I-frames are passed on to an encoder. A request that
 * arrives right after an I-frame on request may be older than that frame: it waits until one
 * more frame is sent, so that requests never cause two I-frames in a row. */
class IFrameRequests {
public:
  /** \brief A receiver requests an I-frame, or there is a new receiver. */
  void
  add()
  {
    is_due_ = true;
  }

  /** \brief True if the frame that comes next has to be an I-frame; the request is done. */
  bool
  take()
  {
    if (!is_due_ || frames_since_ < 2)
      return false;
    is_due_ = false;
    frames_since_ = 0;
    return true;
  }

  /** \brief A frame was sent. */
  void
  countFrame()
  {
    ++frames_since_;
  }

private:
  bool is_due_ = false;
  std::size_t frames_since_ = 2; // since a request was passed on
};

} // namespace nodes
} // namespace pcl_ext

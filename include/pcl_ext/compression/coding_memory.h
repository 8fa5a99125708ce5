#pragma once

#include <pcl_ext/export.h>

#include <memory>

namespace pcl_ext {
namespace io {

class CodingWorkspace;

/** \brief Memory that decoding a frame needs and no stream has to remember.
 *
 * A decoder has its own. A computer with hundreds of streams takes their frames in turn:
 * what a decoder last touched a round ago is no longer in the caches, so it should be
 * little. Decoders that one thread calls in turn may share one such memory, which then
 * stays in the caches; CentralNode has one for each of its threads. For one call at a time.
 * What one large frame needed is given back a few frames later.
 */
class PCL_EXT_EXPORT CodingMemory {
public:
  CodingMemory();
  ~CodingMemory();
  CodingMemory(CodingMemory&&) noexcept;
  CodingMemory&
  operator=(CodingMemory&&) noexcept;

private:
  friend class FrameDecoder;
  std::unique_ptr<CodingWorkspace> workspace_;
};

} // namespace io
} // namespace pcl_ext

#include "payload_coder.h"

#include "context_payload.h"
#include "fast_payload.h"

namespace pcl_ext {
namespace io {

PayloadCoder&
PayloadCoders::of(Effort effort)
{
  std::unique_ptr<PayloadCoder>& coder = coders_[static_cast<std::size_t>(effort)];
  if (!coder && effort == Effort::Fast)
    coder = std::make_unique<FastPayload>();
  else if (!coder)
    coder = std::make_unique<ContextPayload>(effort == Effort::Small);
  return *coder;
}

} // namespace io
} // namespace pcl_ext

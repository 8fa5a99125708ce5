// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "codec/payload_coder.h"

#include "codec/changes/last_frame.h"
#include "codec/context/payload.h"
#include "codec/fast/payload.h"

namespace pcl_ext::PCL_EXT_ABI::io {

CodingWorkspace::CodingWorkspace() = default;
CodingWorkspace::~CodingWorkspace() = default;

fast::Workspace&
CodingWorkspace::fast()
{
  if (!fast_)
    fast_ = std::make_unique<fast::Workspace>();
  return *fast_;
}

changes::FrameChanges&
CodingWorkspace::changes()
{
  if (!changes_)
    changes_ = std::make_unique<changes::FrameChanges>();
  return *changes_;
}

void
CodingWorkspace::endFrame(std::size_t needed, std::size_t taken)
{
  if (!memory_rule_.shouldRelease(needed, taken))
    return;
  fast_.reset();
  changes_.reset();
}

void
CodingWorkspace::releaseMemory() noexcept
{
  fast_.reset();
  changes_.reset();
  memory_rule_ = MemoryRule();
}

PayloadCoder&
PayloadCoders::of(Effort effort)
{
  std::unique_ptr<PayloadCoder>& coder = coders_[static_cast<std::size_t>(effort)];
  if (!coder && effort == Effort::Fast)
    coder = std::make_unique<fast::Payload>();
  else if (!coder)
    coder = std::make_unique<context::Payload>(effort == Effort::Small);
  return *coder;
}

std::size_t
PayloadCoders::trackedVoxels(Effort effort) const
{
  const std::unique_ptr<PayloadCoder>& coder =
      coders_[static_cast<std::size_t>(effort)];
  return coder ? coder->trackedVoxels() : 0;
}

std::size_t
PayloadCoders::memoryBytes() const
{
  constexpr std::size_t bytes_of_few_voxels = std::size_t{1} << 17;
  std::size_t bytes = 0;
  for (const std::unique_ptr<PayloadCoder>& coder : coders_)
    if (coder)
      bytes += bytes_of_few_voxels + coder->modelBytes() +
               kept_bytes_of_block * coder->trackedBlocks();
  return bytes;
}

void
PayloadCoders::keepOnly(Effort effort) noexcept
{
  for (std::size_t i = 0; i < coders_.size(); ++i)
    if (i != static_cast<std::size_t>(effort))
      coders_[i].reset();
}

void
PayloadCoders::clear() noexcept
{
  for (std::unique_ptr<PayloadCoder>& coder : coders_)
    coder.reset();
}

} // namespace pcl_ext::PCL_EXT_ABI::io

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "coders/stream_coder.h"

namespace pcl_ext {
namespace measuring {

#ifndef PCL_EXT_BENCHMARKS_DRACO
void
addDracoCoders(const Workload& /*workload*/, StreamCoders& /*coders*/)
{}

void
addDracoPointsCoders(const Workload& /*workload*/, StreamCoders& /*coders*/)
{}
#endif

StreamCoders
makeAllCoders(const Workload& workload)
{
  StreamCoders coders;
  addLibraryCoders(workload, coders);
  addPclVoxelGridCoder(workload, coders);
  addPclMillimetreCoder(workload, coders);
  addDracoCoders(workload, coders);
  addZstdCoder(coders);
  return coders;
}

StreamCoders
makePointsCoders(const Workload& workload, const std::string& cloudini)
{
  StreamCoders coders;
  addLibraryPointsCoders(workload, coders);
  addCloudiniCoder(workload, cloudini, coders);
  addDracoPointsCoders(workload, coders);
  addPclPointsCoder(workload, coders);
  addZstdPointsCoder(workload, coders);
  return coders;
}

} // namespace measuring
} // namespace pcl_ext

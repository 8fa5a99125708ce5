#pragma once

#include "workload.h"

#include <cstddef>
#include <memory>
#include <vector>

namespace pcl_ext {
namespace benchmarks {

/** \brief Gives each frame to all, beginning with another one each time. */
template <typename RunnerT>
void
takeTurns(const InputStream& stream,
          const Workload& workload,
          std::vector<std::unique_ptr<RunnerT>>& runners)
{
  FrameReader reader(stream, workload);
  InputFrame frame;
  for (std::size_t index = 0; index < stream.clouds->size(); ++index) {
    reader.read(index, frame);
    for (std::size_t turn = 0; turn < runners.size(); ++turn)
      runners[(index + turn) % runners.size()]->run(frame);
  }
}

} // namespace benchmarks
} // namespace pcl_ext

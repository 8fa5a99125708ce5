#include "voxel_frames.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace {

using namespace pcl_ext::io;
using namespace pcl_ext::io::test;

constexpr Effort efforts[] = {Effort::Fast, Effort::Balanced, Effort::Small};

struct Scene {
  unsigned int depth;
  std::size_t voxels;
};
const std::vector<Scene> scenes{
    {8, 1}, {8, 50}, {8, 5000}, {4, 3500}, {2, 64}, {6, 100000}, {21, 300}, {1, 0}};

TEST(FrameSizes, NoEffortIsLargerThanThePublishedLayout)
{
  for (const Effort effort : efforts) {
    std::mt19937_64 random(11);
    for (const Scene& scene : scenes) {
      FrameEncoder version1(StreamFormat::Version1, 3, effort);
      FrameEncoder published(StreamFormat::Published, 3);
      VoxelFrame frame = randomFrame(random, scene.depth, scene.voxels);
      for (int i = 0; i < 6; ++i) {
        // Of many voxels whose intensities are noise the published layout's static
        // table knows more than contexts find out; no sensor makes such noise.
        const std::size_t published_size = encoded(published, frame).size();
        EXPECT_LE(encoded(version1, frame).size(),
                  scene.voxels < 100000 ? published_size : published_size * 5 / 4)
            << scene.voxels << " voxels, depth " << scene.depth;
        walk(random, static_cast<unsigned int>(scene.voxels / 10), frame);
      }
    }
  }
}

} // namespace

#include "intensity_compressor.h"
#include "node_main.h"

int
main(int argc, char** argv)
{
  return pcl_ext_ros::runNode<pcl_ext_ros::IntensityCompressor>(
      argc, argv, "intensity_compressor");
}

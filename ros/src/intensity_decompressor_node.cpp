#include "intensity_decompressor.h"
#include "node_main.h"

int
main(int argc, char** argv)
{
  return pcl_ext_ros::runNode<pcl_ext_ros::IntensityDecompressor>(
      argc, argv, "intensity_decompressor");
}

/** \file
 * How many streams one central computer decodes and one link carries. Prints the tables
 * of doc/benchmarks.md about them.
 */
#include "measuring/machine.h"
#include "scale_options.h"
#include "scale_tables.h"

#include <exception>
#include <iostream>
#include <optional>

int
main(int argc, char** argv)
{
  try {
    const std::optional<pcl_ext::measuring::ScaleOptions> options =
        pcl_ext::measuring::parseScaleOptions(argc, argv);
    if (!options)
      return 0;
    pcl_ext::measuring::printMachine(std::cout);
    pcl_ext::measuring::printManyStreams(*options, std::cout);
    pcl_ext::measuring::printSixSensors(*options, std::cout);
    return 0;
  }
  catch (const std::exception& error) {
    std::cerr << "measure_scale: " << error.what() << '\n';
    return 1;
  }
}

/** \file
 * This library's efforts against the published layout, PCL's class, Draco and zstd: the
 * same clouds, one run, one thread. Prints the tables of doc/benchmarks.md.
 */
#include "comparison_options.h"
#include "comparison_tables.h"
#include "measuring/machine.h"

#include <exception>
#include <iostream>
#include <optional>
#include <string>
#include <utility>

namespace {

using pcl_ext::measuring::ComparisonOptions;

void
printTables(const ComparisonOptions& options)
{
  using Print = void (*)(const ComparisonOptions&, std::ostream&);
  const std::pair<const char*, Print> tables[] = {
      {"peers", pcl_ext::measuring::printPeers},
      {"efforts", pcl_ext::measuring::printEfforts},
      {"stages", pcl_ext::measuring::printStages},
      {"raw", pcl_ext::measuring::printRawToBytes},
      {"recorded", pcl_ext::measuring::printRecorded},
      {"bits", pcl_ext::measuring::printBits},
      {"points", pcl_ext::measuring::printGrowthWithPoints},
      {"edges", pcl_ext::measuring::printGrowthWithEdge}};
  pcl_ext::measuring::printMachine(std::cout);
  for (const auto& [name, print] : tables)
    if (options.wants(name)) {
      std::cerr << "compare_with_peers: " << name << '\n';
      print(options, std::cout);
      std::cout.flush();
    }
}

} // namespace

int
main(int argc, char** argv)
{
  try {
    const std::optional<ComparisonOptions> options =
        pcl_ext::measuring::parseComparisonOptions(argc, argv);
    if (options)
      printTables(*options);
    return 0;
  }
  catch (const std::exception& error) {
    std::cerr << "compare_with_peers: " << error.what() << '\n';
    return 1;
  }
}

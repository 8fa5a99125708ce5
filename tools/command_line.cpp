#include "command_line.h"

#include <boost/program_options/parsers.hpp>
#include <boost/program_options/positional_options.hpp>

#include <iostream>

namespace pcl_ext {
namespace tools {

namespace options = boost::program_options;

bool
parseCommandLine(int argc,
                 const char* const* argv,
                 const options::options_description& description,
                 const std::string& positional,
                 options::variables_map& values)
{
  options::positional_options_description positions;
  positions.add(positional.c_str(), -1);
  options::store(options::command_line_parser(argc, argv)
                     .options(description)
                     .positional(positions)
                     .run(),
                 values);
  if (values.count("help") != 0) {
    std::cout << description << '\n';
    return false;
  }
  options::notify(values);
  return true;
}

} // namespace tools
} // namespace pcl_ext

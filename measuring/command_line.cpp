#include "measuring/command_line.h"

#include <boost/program_options/parsers.hpp>
#include <boost/program_options/positional_options.hpp>

#include <iostream>
#include <stdexcept>

namespace pcl_ext {
namespace measuring {

namespace options = boost::program_options;

bool
parseCommandLine(int argc,
                 const char* const* argv,
                 const options::options_description& description,
                 const std::string& positional,
                 options::variables_map& values)
{
  options::positional_options_description positions;
  if (!positional.empty())
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

unsigned int
checkedCount(const std::string& option,
             std::int64_t count,
             std::int64_t lowest,
             std::int64_t highest)
{
  if (count < lowest || count > highest)
    throw std::invalid_argument("--" + option + " is " + std::to_string(count) +
                                "; it must be " + std::to_string(lowest) + " to " +
                                std::to_string(highest));
  return static_cast<unsigned int>(count);
}

} // namespace measuring
} // namespace pcl_ext

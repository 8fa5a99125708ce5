#include "measuring/command_line.h"

#include <boost/program_options/parsers.hpp>
#include <boost/program_options/positional_options.hpp>

#include <iostream>
#include <sstream>

namespace pcl_ext {
namespace measuring {

namespace options = boost::program_options;

namespace {

template <typename NumberT>
void
checkRange(const std::string& option, NumberT number, NumberT lowest, NumberT highest)
{
  if (number >= lowest && number <= highest)
    return;
  std::ostringstream message;
  message << "--" << option << " is " << number << "; it must be " << lowest << " to "
          << highest;
  throw std::invalid_argument(message.str());
}

} // namespace

int
runProgram(const std::string& name, const std::function<int()>& run)
{
  try {
    return run();
  }
  catch (const std::exception& error) {
    std::cerr << name << ": " << error.what() << '\n';
    return 1;
  }
}

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
  checkRange(option, count, lowest, highest);
  return static_cast<unsigned int>(count);
}

options::typed_value<double>*
number(const std::string& option, double& result, double lowest, double highest)
{
  return options::value<double>()->notifier(
      [option, &result, lowest, highest](double given) {
        checkRange(option, given, lowest, highest);
        result = given;
      });
}

} // namespace measuring
} // namespace pcl_ext

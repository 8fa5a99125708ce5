#pragma once

#include <boost/program_options/options_description.hpp>
#include <boost/program_options/value_semantic.hpp>
#include <boost/program_options/variables_map.hpp>

#include <cstdint>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace pcl_ext {
namespace measuring {

/** \brief Runs a program and catches what it throws.
 * \param[in] name of the program, for the message
 * \param[in] run the program; returns the exit status
 * \return the exit status; 1 after an exception, whose message is printed
 */
int
runProgram(const std::string& name, const std::function<int()>& run);

/** \brief Reads a program's command line.
 * \param[in] argc,argv of main
 * \param[in] description of the options, `help` among them
 * \param[in] positional option that arguments without a name are values of; empty: none
 * \param[out] values the options that were given; variables bound to options are set
 * \return false if only the help was asked for, which is then printed
 * \throws std::exception with a message for the user if the command line is invalid
 */
bool
parseCommandLine(int argc,
                 const char* const* argv,
                 const boost::program_options::options_description& description,
                 const std::string& positional,
                 boost::program_options::variables_map& values);

/** \brief Checks that the value of an option is within its range.
 * \throws std::invalid_argument with the option and its range
 */
unsigned int
checkedCount(const std::string& option,
             std::int64_t count,
             std::int64_t lowest,
             std::int64_t highest);

/** \brief The largest count that options take. */
constexpr std::int64_t largest_count = std::numeric_limits<std::int32_t>::max();

/** \brief An option that counts something. It is read as a signed number, as Boost
 * reads -1 into an unsigned one as 4294967295.
 * \param[in] option its name, for messages
 * \param[out] result the count, an unsigned integer
 * \param[in] lowest,highest range
 */
template <typename CountT>
boost::program_options::typed_value<std::int64_t>*
count(const std::string& option,
      CountT& result,
      std::int64_t lowest,
      std::int64_t highest = largest_count)
{
  static_assert(std::is_unsigned<CountT>::value, "counts are not negative");
  return boost::program_options::value<std::int64_t>()->notifier(
      [option, &result, lowest, highest](std::int64_t given) {
        result = checkedCount(option, given, lowest, highest);
      });
}

/** \brief An option that is a number in a range; see count(). */
boost::program_options::typed_value<double>*
number(const std::string& option, double& result, double lowest, double highest);

/** \brief Names that an option takes, and what they stand for. */
template <typename ValueT>
using Choices = std::vector<std::pair<std::string, ValueT>>;

/** \brief The value that a name stands for.
 * \throws std::invalid_argument with the option and all names
 */
template <typename ValueT>
const ValueT&
valueNamed(const std::string& option,
           const std::string& name,
           const Choices<ValueT>& choices)
{
  std::string names;
  for (const auto& [known_name, value] : choices) {
    if (known_name == name)
      return value;
    names += ' ' + known_name;
  }
  throw std::invalid_argument("--" + option + ": invalid value '" + name +
                              "'; possible values:" + names);
}

/** \brief An option with a few named values; see valueNamed(). */
template <typename ValueT>
boost::program_options::typed_value<std::string>*
choice(const std::string& option, ValueT& result, const Choices<ValueT>& choices)
{
  return boost::program_options::value<std::string>()->notifier(
      [option, &result, choices](const std::string& name) {
        result = valueNamed(option, name, choices);
      });
}

/** \brief An option that takes several names at once; see valueNamed(). */
template <typename ValueT>
boost::program_options::typed_value<std::vector<std::string>>*
choiceOfSeveral(const std::string& option,
                std::vector<ValueT>& result,
                const Choices<ValueT>& choices)
{
  return boost::program_options::value<std::vector<std::string>>()
      ->multitoken()
      ->notifier([option, &result, choices](const std::vector<std::string>& names) {
        result.clear();
        for (const std::string& name : names)
          result.push_back(valueNamed(option, name, choices));
      });
}

} // namespace measuring
} // namespace pcl_ext

#pragma once

#include <boost/program_options/options_description.hpp>
#include <boost/program_options/variables_map.hpp>

#include <cstdint>
#include <string>

namespace pcl_ext {
namespace measuring {

/** \brief Reads a program's command line.
 * \param[in] argc,argv of main
 * \param[in] description of the options, `help` among them
 * \param[in] positional option that arguments without a name belong to; empty: there are
 * none
 * \param[out] values what was given; variables that options are bound to are set, too
 * \return false if only the help was asked for, which is then printed
 * \throws std::exception with a sentence for the user if the line makes no sense
 */
bool
parseCommandLine(int argc,
                 const char* const* argv,
                 const boost::program_options::options_description& description,
                 const std::string& positional,
                 boost::program_options::variables_map& values);

/** \brief Tells whether an option that counts something is within its range. Its type is
 * std::int64_t: an unsigned one would read -1 as four thousand million.
 * \throws std::invalid_argument naming the option and its range
 */
unsigned int
checkedCount(const std::string& option,
             std::int64_t count,
             std::int64_t lowest,
             std::int64_t highest);

} // namespace measuring
} // namespace pcl_ext

/** \file
 * The tables of parameters in README files are those of the library.
 */
#include <pcl_ext/nodes/node_parameters.h>

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace {

using namespace pcl_ext::nodes;

const std::string root = PCL_EXT_TEST_DATA "/../..";

std::string
tableOf(const std::vector<ParameterDescription>& parameters)
{
  std::string table =
      "| parameter | unit | default | allowed | |\n|---|---|---|---|---|\n";
  for (const ParameterDescription& parameter : parameters)
    table += "| `" + parameter.name + "` | " + parameter.unit + " | " +
             textOf(parameter.default_value) + " | " + allowedValues(parameter) +
             " | " + parameter.description + " |\n";
  return table;
}

/** \brief What is between two marks of a file; the file's end if there are none. */
std::string
section(const std::string& file, const std::string& name)
{
  std::ifstream stream(root + '/' + file);
  const std::string content{std::istreambuf_iterator<char>(stream),
                            std::istreambuf_iterator<char>()};
  const std::string begin = "<!-- " + name + " -->\n";
  const std::size_t at = content.find(begin);
  const std::size_t end = content.find("<!-- end of " + name + " -->");
  if (at == std::string::npos || end == std::string::npos)
    return "no section " + name;
  return content.substr(at + begin.size(), end - at - begin.size());
}

TEST(ParameterTables, AreThoseOfTheLibrary)
{
  const std::string readme = "ros2/pcl_ext_point_cloud_transport/README.md";
  EXPECT_EQ(section(readme, "encoding parameters"),
            "\n" + tableOf(encodingParameters()) + "\n");
  EXPECT_EQ(section(readme, "noise parameters"),
            "\n" + tableOf(noiseParameters()) + "\n");
}

} // namespace

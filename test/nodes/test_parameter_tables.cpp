// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

/** \file
 * The tables of parameters in doc/nodes.md are those of the sources.
 */
#include <pcl_ext/nodes/node_parameters.h>

#include "simulator/cell_parameters.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>
#include <utility>
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
  const std::vector<std::pair<std::string, std::vector<ParameterDescription>>> tables =
      {{"encoding parameters", encodingParameters()},
       {"sensor node parameters", sensorNodeParameters()},
       {"noise parameters", noiseParameters()},
       {"central node parameters", centralNodeParameters()},
       {"stream parameters", streamParameters()},
       {"cell parameters", pcl_ext::cell::cellParameters()}};
  for (const auto& [name, parameters] : tables)
    EXPECT_EQ(section("doc/nodes.md", name), "\n" + tableOf(parameters) + "\n");
}

} // namespace

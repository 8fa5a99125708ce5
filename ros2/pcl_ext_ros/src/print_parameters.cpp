/** \file
 * \brief Prints the tables of README.md that lie between its marks of parameters.
 */
#include "parameter_tables.h"

#include <algorithm>
#include <iostream>

namespace {

using pcl_ext::nodes::ParameterDescription;
using pcl_ext_ros::Descriptions;

/** \brief A cell of a table: a bar would end it. */
std::string
cell(std::string text)
{
  std::replace(text.begin(), text.end(), '|', '/');
  return text;
}

void
print(const std::string& title, const std::vector<std::string>& rows)
{
  std::cout << "\n### " << title << "\n\n| parameter | unit | default | allowed | |\n"
            << "|---|---|---|---|---|\n";
  for (const std::string& row : rows)
    std::cout << row;
}

std::vector<std::string>
rowsOf(const Descriptions& parameters, const std::string& prefix = "")
{
  std::vector<std::string> rows;
  for (const ParameterDescription& parameter : parameters)
    rows.push_back("| `" + prefix + parameter.name + "` | " + parameter.unit + " | " +
                   pcl_ext::nodes::textOf(parameter.default_value) + " | " +
                   cell(allowedValues(parameter)) + " | " +
                   cell(parameter.description) + " |\n");
  return rows;
}

std::vector<std::string>
together(std::vector<std::string> first, const std::vector<std::string>& second)
{
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

} // namespace

int
main()
{
  using namespace pcl_ext_ros;
  print("sensor_node",
        together(rowsOf(pcl_ext::nodes::encodingParameters()),
                 rowsOf(sensorNodeParameters())));
  std::vector<std::string> central = {
      std::string("| `streams` | | ['input'] | a list of topics | ") +
      description_of_streams + " |\n"};
  central = together(central, rowsOf(pcl_ext::nodes::noiseParameters()));
  central = together(central, rowsOf(centralNodeParameters()));
  central = together(central, rowsOf(streamParameters(), "<stream>."));
  print("central_node", central);
  print("simulated_cell", rowsOf(cellParameters()));
  std::cout << std::endl;
}

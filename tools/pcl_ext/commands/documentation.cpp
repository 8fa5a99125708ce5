#include "commands/commands.h"
#include "console/exit_status.h"
#include "options/bash_completion.h"
#include "options/man_page.h"

#include <fstream>
#include <iostream>
#include <memory>
#include <stdexcept>

namespace pcl_ext {
namespace tools {

namespace {

struct DocumentationOptions {
  std::string kind;
  std::string output;
};

int
document(const DocumentationOptions& options, const CLI::App& program)
{
  std::ofstream file(options.output);
  if (options.kind == "man")
    writeManPage(program, file);
  else
    writeBashCompletion(program, file);
  file.close();
  if (!file)
    throw std::runtime_error("cannot write '" + options.output + "'");
  return all_done;
}

} // namespace

Run
addDocumentation(CLI::App& app, const CLI::App& program)
{
  const auto options = std::make_shared<DocumentationOptions>();
  app.group(""); // not in the help
  app.add_option("KIND", options->kind, "man or bash")
      ->required()
      ->check(CLI::IsMember({"man", "bash"}));
  app.add_option("OUT", options->output, "file")->required();
  return [options, &program] { return document(*options, program); };
}

} // namespace tools
} // namespace pcl_ext

#include "options/man_page.h"

#include <pcl_ext/version.h>

#include "options/help_format.h"
#include "options/help_texts.h"

#include <algorithm>
#include <cctype>
#include <ostream>
#include <string>
#include <vector>

namespace pcl_ext {
namespace tools {

namespace {

/** \brief Text for roff: characters that are special there are escaped. */
std::string
escaped(const std::string& text)
{
  std::string result;
  for (const char character : text) {
    if (character == '\\')
      result += "\\e";
    else if (character == '-')
      result += "\\-";
    else if (character == '\'')
      result += "\\(aq";
    else
      result += character;
  }
  // At the beginning of a line a dot is a request.
  return (result.empty() || result.front() != '.' ? "" : "\\&") + result;
}

/** \brief The options that are shown, positional ones first. */
std::vector<const CLI::Option*>
optionsOf(const CLI::App& app)
{
  std::vector<const CLI::Option*> options = app.get_options(
      [](const CLI::Option* option) { return !option->get_group().empty(); });
  std::stable_partition(options.begin(), options.end(), [](const CLI::Option* option) {
    return option->get_positional();
  });
  return options;
}

void
writeOptions(const CLI::App& app, std::ostream& output)
{
  for (const CLI::Option* option : optionsOf(app)) {
    std::string names = synopsisOf(*option);
    std::string type;
    if (const std::size_t space = names.find(' '); space != std::string::npos) {
      type = " \\fI" + escaped(names.substr(space + 1)) + "\\fR";
      names.resize(space);
    }
    for (std::size_t comma = names.find(','); comma != std::string::npos;
         comma = names.find(',', comma + 2))
      names.insert(comma + 1, " ");
    output << ".TP\n\\fB" << escaped(names) << "\\fR" << type << '\n'
           << escaped(option->get_description()) << '\n';
  }
}

void
writeCommand(const CLI::App& program, const CLI::App& command, std::ostream& output)
{
  output << ".SS " << escaped(command.get_name()) << '\n'
         << escaped(command.get_description()) << ".\n.PP\n\\fB"
         << escaped(program.get_name() + " " + command.get_name()) << "\\fR";
  for (const CLI::Option* option : optionsOf(command))
    if (option->get_positional())
      output << " \\fI" << escaped(synopsisOf(*option)) << "\\fR";
  output << " [\\fIoptions\\fR]\n";
  writeOptions(command, output);
}

} // namespace

void
writeManPage(const CLI::App& program, std::ostream& output)
{
  std::string title = program.get_name();
  std::transform(title.begin(), title.end(), title.begin(), [](unsigned char letter) {
    return static_cast<char>(std::toupper(letter));
  });
  output << ".TH " << title << " 1 \"\" \"" << program.get_name() << ' ' << version()
         << "\" \"User Commands\"\n"
         << ".SH NAME\n"
         << escaped(program.get_name()) << " \\- " << escaped(one_line) << '\n'
         << ".SH SYNOPSIS\n\\fB" << escaped(program.get_name())
         << "\\fR \\fICOMMAND\\fR [\\fIoptions\\fR]\n"
         << ".SH DESCRIPTION\n"
         << escaped(program_description) << '\n';
  for (const char* paragraph : man_paragraphs)
    output << ".PP\n" << escaped(paragraph) << '\n';
  output << ".SH COMMANDS\n";
  for (const CLI::App* command : program.get_subcommands(
           [](const CLI::App* app) { return !app->get_group().empty(); }))
    writeCommand(program, *command, output);
  output << ".SH EXIT STATUS\n";
  for (const auto& [status, meaning] : exit_statuses)
    output << ".TP\n\\fB" << status << "\\fR\n" << escaped(meaning) << '\n';
  output << ".SH EXAMPLES\n";
  for (const auto& [command, meaning] : examples)
    output << ".TP\n\\fB" << escaped(command) << "\\fR\n" << escaped(meaning) << '\n';
}

} // namespace tools
} // namespace pcl_ext

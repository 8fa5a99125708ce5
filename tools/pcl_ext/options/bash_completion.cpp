#include "options/bash_completion.h"

#include <algorithm>
#include <ostream>
#include <string>
#include <vector>

namespace pcl_ext {
namespace tools {

namespace {

std::vector<const CLI::App*>
commandsOf(const CLI::App& program)
{
  return program.get_subcommands(
      [](const CLI::App* app) { return !app->get_group().empty(); });
}

/** \brief All names of the options of a command, with spaces between them. */
std::string
optionNames(const CLI::App& app)
{
  std::string names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_snames())
      names += " -" + name;
    for (const std::string& name : option->get_lnames())
      names += " --" + name;
  }
  return names.empty() ? names : names.substr(1);
}

/** \brief The names of an option as a pattern of case. */
std::string
pattern(const CLI::Option& option)
{
  std::string names;
  for (const std::string& name : option.get_snames())
    names += " | -" + name;
  for (const std::string& name : option.get_lnames())
    names += " | --" + name;
  return names.substr(std::min<std::size_t>(3, names.size()));
}

/** \brief Writes what may follow the options of a command, and which it has. */
void
writeCommand(const CLI::App& command, std::ostream& output)
{
  output << "        " << command.get_name() << ")\n"
         << "            options='" << optionNames(command) << "'\n"
         << "            case $last in\n";
  for (const CLI::Option* option : command.get_options()) {
    std::string type = option->get_type_name();
    if (option->get_positional() || option->get_items_expected_max() == 0 ||
        type == "OUT" || type == "FILE")
      continue;
    // A dot stands for values that cannot be listed.
    const bool has_list = type.find('|') != std::string::npos;
    std::replace(type.begin(), type.end(), '|', ' ');
    output << "                " << pattern(*option) << ") values='"
           << (has_list ? type : ".") << "' ;;\n";
  }
  output << "            esac\n            ;;\n";
}

} // namespace

void
writeBashCompletion(const CLI::App& program, std::ostream& output)
{
  std::string commands;
  for (const CLI::App* command : commandsOf(program))
    commands += (commands.empty() ? "" : " ") + command->get_name();
  output
      << "# bash completion for " << program.get_name()
      << "                               -*- shell-script -*-\n\n"
      << '_' << program.get_name() << "()\n{\n"
      << "    local word=${COMP_WORDS[COMP_CWORD]} last=${COMP_WORDS[COMP_CWORD-1]}\n"
      << "    local command=${COMP_WORDS[1]} options= values=\n"
      << "    COMPREPLY=()\n"
      << "    if [ \"$COMP_CWORD\" -eq 1 ]; then\n"
      << "        COMPREPLY=($(compgen -W '" << commands << ' ' << optionNames(program)
      << "' -- \"$word\"))\n"
      << "        return\n    fi\n"
      << "    case $command in\n";
  for (const CLI::App* command : commandsOf(program))
    writeCommand(*command, output);
  output << "    esac\n"
         << "    if [ \"$values\" = . ]; then\n        return\n"
         << "    elif [ -n \"$values\" ]; then\n"
         << "        COMPREPLY=($(compgen -W \"$values\" -- \"$word\"))\n"
         << "    elif [[ $word == -* ]]; then\n"
         << "        COMPREPLY=($(compgen -W \"$options\" -- \"$word\"))\n"
         << "    else\n"
         << "        compopt -o filenames 2> /dev/null\n"
         << "        COMPREPLY=($(compgen -f -- \"$word\"))\n"
         << "    fi\n}\n"
         << "complete -F _" << program.get_name() << ' ' << program.get_name() << '\n';
}

} // namespace tools
} // namespace pcl_ext

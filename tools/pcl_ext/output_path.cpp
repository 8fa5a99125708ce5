#include "output_path.h"

#include "exit_status.h"

#include <filesystem>

namespace pcl_ext {
namespace tools {

namespace fs = std::filesystem;

OutputKind
kindOfOutput(const std::string& path)
{
  if (path.empty())
    throw UsageError("--output is empty");
  const std::string extension = fs::path(path).extension().string();
  if (path == "-" || extension == ".pcxi")
    return OutputKind::Frames;
  if (extension == ".mcap")
    return OutputKind::Mcap;
  if (extension.empty())
    return OutputKind::Folder;
  throw UsageError("'" + path +
                   "' is no kind of output: name x.pcxi (one stream), x.mcap, or a "
                   "folder");
}

void
refuseSameFile(const std::vector<std::string>& inputs, const std::string& output)
{
  if (output == "-" || !fs::exists(output))
    return;
  for (const std::string& input : inputs) {
    std::error_code ignored;
    if (fs::equivalent(input, output, ignored))
      throw UsageError("the output '" + output + "' is an input: name another one");
  }
}

} // namespace tools
} // namespace pcl_ext

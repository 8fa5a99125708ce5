// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "inputs/bag_list.h"

#include "clouds/cloud_files.h"
#include "clouds/natural_order.h"
#include "console/exit_status.h"
#include "recording/bag_reader.h"
#include "recording/rosbag2_folder.h"

#ifdef _WIN32
#include <io.h>
#else
#include <glob.h>
#endif

#include <algorithm>
#include <filesystem>
#include <stdexcept>

namespace pcl_ext::tools {

namespace fs = std::filesystem;

namespace {

/** \brief Whether a name is that of a bag; rosbag records into NAME.bag.active. */
bool
hasNameOfBag(const fs::path& path)
{
  const std::string extension = clouds::lowerCase(path.extension().string());
  const bool is_of_ros1 =
      extension == ".bag" ||
      (extension == ".active" &&
       clouds::lowerCase(path.stem().extension().string()) == ".bag");
  return recording::hasNameOfBagFile(path.string()) ||
         (is_of_ros1 && path.filename().string().rfind("._", 0) != 0);
}

/** \brief True if a path is a bag, or a file that has the name of one. */
bool
isBagOrNamedSo(const fs::path& path)
{
  if (fs::is_directory(path))
    return recording::isRosbag2Folder(path.string());
  if (!fs::is_regular_file(path)) // a pipe is not read before it is encoded
    return false;
  return hasNameOfBag(path) ||
         (!clouds::hasNameOfCloud(path.string()) && isBag(path.string()));
}

/** \brief The bags in a folder that is none itself.
 * \param[out] cloud a file of a cloud in it; empty if there is none
 */
std::vector<std::string>
bagsIn(const fs::path& folder, std::string& cloud)
{
  std::vector<std::string> bags;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const fs::path& path = entry.path();
    if (entry.is_regular_file() && clouds::hasNameOfCloud(path.string()))
      cloud = path.string();
    // Opening a pipe or a device may block for ever.
    if (entry.is_directory() ? isBagOrNamedSo(path)
                             : hasNameOfBag(path) && !entry.is_other())
      bags.push_back(path.string());
  }
  std::sort(bags.begin(), bags.end(), clouds::comesBefore);
  return bags;
}

/** \brief The bags in a folder that is none itself and has no clouds. */
std::vector<std::string>
bagsIn(const fs::path& folder)
{
  std::string cloud;
  const std::vector<std::string> bags = bagsIn(folder, cloud);
  return cloud.empty() ? bags : std::vector<std::string>();
}

void
refuseBagsBesideClouds(const std::string& folder)
{
  std::string cloud;
  const std::vector<std::string> bags = bagsIn(folder, cloud);
  if (!cloud.empty() && !bags.empty())
    throw UsageError("'" + folder + "' has clouds and bags, such as '" + cloud +
                     "' and '" + bags.front() + "': name what is meant, such as '" +
                     (fs::path(folder) / "*").string() +
                     fs::path(cloud).extension().string() + "'");
}

/** \brief True for a bag, and for what SQLite leaves beside one. */
bool
isOfBag(const std::string& path, const std::vector<std::string>& bags)
{
  return std::any_of(bags.begin(), bags.end(), [&path](const std::string& bag) {
    return path == bag || path == bag + "-wal" || path == bag + "-shm";
  });
}

/** \brief True for a folder that has the parts of a bag, no other bags and no clouds. */
bool
hasPartsOfBag(const std::string& folder)
{
  const std::vector<std::string> bags = bagsIn(folder);
  return std::all_of(
             bags.begin(),
             bags.end(),
             [](const std::string& bag) { return recording::hasNameOfBagFile(bag); }) &&
         bags.size() > 1 && recording::mayBeParts(folder);
}

#ifdef _WIN32
/** \brief Only the last part of the pattern may have * and ?. */
std::vector<std::string>
pathsThatMatch(const fs::path& pattern)
{
  std::vector<std::string> paths;
  _wfinddata_t found{};
  const std::intptr_t search = ::_wfindfirst(pattern.c_str(), &found);
  if (search == -1)
    return paths;
  do {
    const fs::path name = found.name;
    if (name != "." && name != "..")
      paths.push_back((pattern.parent_path() / name).string());
  }
  while (::_wfindnext(search, &found) == 0);
  ::_findclose(search);
  return paths;
}
#else
std::vector<std::string>
pathsThatMatch(const std::string& pattern)
{
  glob_t found{};
  std::vector<std::string> paths;
  if (::glob(pattern.c_str(), 0, nullptr, &found) == 0)
    paths.assign(found.gl_pathv, found.gl_pathv + found.gl_pathc);
  ::globfree(&found);
  return paths;
}
#endif

} // namespace

std::vector<std::string>
pathsOf(const std::string& pattern)
{
  if (pattern == "-" || fs::exists(pattern))
    return {pattern};
  std::vector<std::string> paths = pathsThatMatch(pattern);
  std::sort(paths.begin(), paths.end(), clouds::comesBefore);
  if (paths.empty())
    throw std::runtime_error("there is no '" + pattern + "'");
  return paths;
}

bool
isBag(const std::string& path)
{
  if (recording::BagReader::isBag(path))
    return true;
  return fs::is_directory(path) && hasPartsOfBag(path);
}

std::string
onlyBagIn(const std::string& path)
{
  if (!fs::is_directory(path) || isBag(path))
    return {};
  const std::vector<std::string> bags = bagsIn(path);
  return bags.size() == 1 ? bags.front() : std::string();
}

std::vector<std::string>
severalBags(const std::vector<std::string>& inputs, bool takes_one, bool is_for_file)
{
  std::vector<std::string> bags;
  std::size_t paths = 0;
  std::string other; // that is no bag
  bool has_folder = false;
  for (const std::string& input : inputs)
    for (const std::string& path : pathsOf(input)) {
      ++paths;
      if (isBagOrNamedSo(path)) {
        bags.push_back(path);
        continue;
      }
      if (fs::is_directory(path) && !is_for_file)
        refuseBagsBesideClouds(path);
      const std::vector<std::string> found =
          fs::is_directory(path) ? bagsIn(path) : std::vector<std::string>();
      has_folder |= !found.empty();
      if (found.empty())
        other = path;
      bags.insert(bags.end(), found.begin(), found.end());
    }
  const bool is_one =
      paths == 1 && (bags.size() == 1 ||
                     (is_for_file && fs::is_directory(inputs[0]) && isBag(inputs[0])));
  if (bags.empty() || (is_one && (is_for_file || (!has_folder && !takes_one))))
    return {};
  if (!other.empty())
    throw UsageError("'" + bags[0] + "' is a bag and '" + other +
                     "' is not: encode them one after the other");
  return bags;
}

std::vector<FolderOfBags>
foldersWithOthers(const std::vector<std::string>& inputs)
{
  std::vector<FolderOfBags> folders;
  for (const std::string& input : inputs)
    for (const std::string& path : pathsOf(input)) {
      if (!fs::is_directory(path) || isBagOrNamedSo(path))
        continue;
      FolderOfBags folder{path, {}, {}, {}};
      const std::vector<std::string> bags = bagsIn(path);
      for (const fs::directory_entry& entry : fs::directory_iterator(path)) {
        const std::string name = entry.path().filename().string();
        if (name.front() != '.' && !isOfBag(entry.path().string(), bags))
          (entry.is_directory() ? folder.other_folders : folder.other_files)
              .push_back(name);
      }
      for (auto* const names : {&folder.other_folders, &folder.other_files})
        std::sort(names->begin(), names->end(), clouds::comesBefore);
      for (const std::string& name : folder.other_folders)
        if (const std::string other = (fs::path(path) / name).string();
            folder.unfinished.empty() && recording::mayBeParts(other))
          folder.unfinished = other;
      if (!bags.empty() &&
          !(folder.other_folders.empty() && folder.other_files.empty()))
        folders.push_back(std::move(folder));
    }
  return folders;
}

} // namespace pcl_ext::tools

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "outputs/cloud_folder.h"

#include "clouds/file_stamps.h"
#include "clouds/pcd_file.h"
#include "clouds/ply_file.h"
#include "clouds/point_fields.h"
#include "console/exit_status.h"
#include "console/interruption.h"
#include "inputs/point_cloud_conversions.h"
#include "outputs/cloud_mark.h"
#include "outputs/frame_output.h"
#include "outputs/output_path.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <map>
#include <set>
#include <stdexcept>
#include <utility>

namespace pcl_ext::tools {

namespace fs = std::filesystem;

namespace {

/** \brief Whether nameOfFile() may have made the name; others are names of the user. */
bool
isCloudOfFrame(const fs::path& file)
{
  return clouds::isNameOfFrame(file.string()) &&
         (file.extension() == ".pcd" || file.extension() == ".ply");
}

std::string
nameOfFile(std::size_t number, recording::Time stamp, CloudFormat format)
{
  constexpr std::chrono::seconds clocks_begin{1'000'000'000}; // in 2001
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(stamp);
  std::array<char, 64> name{};
  const int length = std::snprintf(name.data(), name.size(), "%06zu", number);
  if (seconds >= clocks_begin)
    std::snprintf(name.data() + length,
                  name.size() - static_cast<std::size_t>(length),
                  "_%lld.%09lld",
                  static_cast<long long>(seconds.count()),
                  static_cast<long long>((stamp - seconds).count()));
  return name.data() + std::string(format == CloudFormat::Ply ? ".ply" : ".pcd");
}

/** \brief Makes a name of a field one word that no other field has.
 * \param[in,out] taken names; the new one is added
 */
std::string
nameInHeader(std::string name, std::set<std::string>& taken)
{
  for (char& character : name)
    if (const auto code = static_cast<unsigned char>(character);
        code <= ' ' || code == 0x7f)
      character = '_';
  while (!taken.insert(name).second)
    name += '_';
  return name;
}

/** \brief The fields of a cloud as a file can have them. Those of several values become
 * several of one value in PLY files, as PCL reads no others there. */
std::vector<pcl::PCLPointField>
fieldsOfFile(const std::vector<pcl::PCLPointField>& fields, CloudFormat format)
{
  std::vector<pcl::PCLPointField> written;
  std::set<std::string> taken = {"_"}; // fills gaps
  for (pcl::PCLPointField field : fields) {
    const std::string name = field.name;
    const std::uint32_t parts = format == CloudFormat::Ply ? field.count : 1;
    field.count /= std::max(parts, 1u);
    for (std::uint32_t i = 0; i < parts; ++i) {
      field.name =
          nameInHeader(parts > 1 ? name + '_' + std::to_string(i) : name, taken);
      written.push_back(field);
      field.offset +=
          static_cast<std::uint32_t>(clouds::bytesOf({clouds::fileFieldOf(field)}));
    }
  }
  return written;
}

/** \brief The bytes of the file of a cloud, with the fields that a file can have. */
std::vector<std::uint8_t>
bytesOfFile(const pcl::PCLPointCloud2& cloud,
            CloudFormat format,
            const Viewpoint& viewpoint)
{
  pcl::PCLPointCloud2 changed = cloud;
  changed.fields = fieldsOfFile(cloud.fields, format);
  const auto storage = format == CloudFormat::PcdCompressed
                           ? clouds::PcdStorage::Compressed
                       : format == CloudFormat::PcdAscii ? clouds::PcdStorage::Ascii
                                                         : clouds::PcdStorage::Binary;
  std::vector<std::uint8_t> bytes = format == CloudFormat::Ply
                                        ? clouds::writePly(changed)
                                        : clouds::writePcd(changed, viewpoint, storage);
  markAsOurs(bytes);
  return bytes;
}

/** \brief Writes a new file; of one that fails nothing is left. */
void
writeFile(const std::string& path, const std::vector<std::uint8_t>& bytes)
{
  errno = 0;
  std::FILE* const file = std::fopen(path.c_str(), "wb");
  bool is_written = file != nullptr &&
                    std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size();
  int reason = errno;
  if (file != nullptr && std::fclose(file) != 0 && is_written) {
    is_written = false;
    reason = errno;
  }
  if (is_written)
    return;
  if (file != nullptr)
    std::remove(path.c_str());
  throw std::runtime_error("cannot write '" + path + "': " + std::strerror(reason));
}

/** \brief Adds the clouds in a folder that decoding may have written; none if it does
 * not exist. */
void
addCloudsIn(const fs::path& folder, std::vector<fs::path>& clouds)
{
  std::error_code is_new;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, is_new))
    if (isCloudOfFrame(entry.path()))
      clouds.push_back(entry.path());
}

/** \brief Refuses a folder with clouds of other streams, which would seem to be of the
 * new recording, and which may be the user's.
 * \param[in] folders of the streams in it
 */
void
checkForOtherStreams(const fs::path& path, const std::vector<std::string>& folders)
{
  std::set<fs::path> others = {path};
  for (const fs::directory_entry& entry : fs::directory_iterator(path))
    if (entry.is_directory() && !entry.is_symlink())
      others.insert(entry.path());
  for (const std::string& folder : folders)
    others.erase(folder.empty() ? path : path / folder);
  for (const fs::path& other : others) {
    std::vector<fs::path> clouds;
    addCloudsIn(other, clouds);
    if (!clouds.empty())
      throw UsageError("the folder '" + other.string() +
                       "' has clouds that are not of this recording's streams: remove "
                       "them, or name another output");
  }
}

/** \brief Creates a folder of a name for files until they are complete. What has the
 * name already, as another run may be writing there or the user called something so,
 * stays as it is. */
fs::path
makeFolderBeside(const fs::path& path)
{
  const std::string name = path.string() + unfinished_suffix;
  std::string folder = name;
  std::error_code error;
  for (unsigned int number = 1; !fs::create_directory(folder, error); ++number) {
    if (error && error != std::errc::file_exists)
      throw std::runtime_error("cannot create the folder '" + folder +
                               "': " + error.message());
    folder = name + '.' + std::to_string(number);
  }
  return folder;
}

/** \brief True if what is in a folder can be moved to another one: they are on one file
 * system, and none of the two is a mount of its own. */
bool
canMove(const fs::path& from, const fs::path& to)
{
  std::error_code error;
  const fs::path probe = to / from.filename();
  fs::create_directory(from / "probe", error);
  if (!error)
    fs::rename(from / "probe", probe, error);
  std::error_code ignored;
  fs::remove(error ? from / "probe" : probe, ignored);
  return !error;
}

/** \brief Creates a folder for files until they are complete: beside the output, or in
 * it where it is on another file system than its parent. */
fs::path
makeUnfinishedFolder(const fs::path& path)
{
  std::error_code ignored;
  if (path.has_parent_path())
    fs::create_directories(path.parent_path(), ignored);
  if (!fs::is_directory(path))
    return makeFolderBeside(path);
  const fs::path target = fs::canonical(path);
  try {
    const fs::path folder = makeFolderBeside(target);
    if (canMove(folder, target))
      return folder;
    fs::remove(folder, ignored);
  }
  catch (const std::runtime_error&) {
    // The parent may be another user's, or read only.
  }
  return makeFolderBeside(target / "clouds");
}

} // namespace

std::vector<std::string>
folderNames(const std::vector<std::string>& streams)
{
  constexpr const char* usual = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                                "0123456789_-";
  std::map<std::string, int> uses;
  std::vector<std::string> names;
  for (const std::string& stream : streams) {
    const std::string topic = topicOf(stream);
    std::string name =
        topic.substr(std::min(topic.find_first_not_of('/'), topic.size()));
    constexpr std::size_t longest = 200;
    name.resize(std::min(name.size(), longest));
    for (char& character : name)
      if (std::string(usual).find(character) == std::string::npos)
        character = '_';
    if (name.empty())
      name = "stream";
    while (++uses[name] > 1)
      name += "_" + std::to_string(uses[name]);
    names.push_back(name);
  }
  return names;
}

void
refuseTakenFolder(const std::string& path, bool may_replace)
{
  if (fs::exists(path) && !fs::is_directory(path))
    throw UsageError("'" + path + "' is a file; the clouds need a folder");
  if (fs::exists(path) && !fs::is_empty(path) && !may_replace)
    throw UsageError("the folder '" + path +
                     "' is not empty: name another one, or replace the clouds in it "
                     "with --overwrite");
}

CloudFolder::CloudFolder(const std::string& path,
                         CloudFormat format,
                         bool may_replace,
                         std::vector<std::string> folders)
: path_(fs::path(path).has_filename() ? fs::path(path) : fs::path(path).parent_path())
, format_(format)
, may_replace_(may_replace)
, folders_(std::move(folders))
{
  if (folders_.size() == 1)
    folders_.front().clear();
  refuseTakenFolder(path_.string(), may_replace);
  if (fs::exists(path_))
    checkForOtherStreams(path_, folders_);
  unfinished_ = makeUnfinishedFolder(path_);
  for (const std::string& folder : folders_) {
    std::error_code error;
    fs::create_directories(unfinished_ / folder, error);
    if (!error)
      continue;
    std::error_code ignored;
    fs::remove_all(unfinished_, ignored);
    throw std::runtime_error("cannot create the folder '" +
                             (unfinished_ / folder).string() + "': " + error.message());
  }
}

CloudFolder::~CloudFolder()
{
  std::error_code ignored;
  if (!unfinished_.empty())
    fs::remove_all(unfinished_, ignored);
}

void
CloudFolder::write(std::size_t stream,
                   std::size_t number,
                   const pcl::PCLPointCloud2& cloud,
                   recording::Time stamp,
                   const Viewpoint& viewpoint)
{
  const fs::path name = fs::path(folders_[stream]) / nameOfFile(number, stamp, format_);
  try {
    writeFile((unfinished_ / name).string(), bytesOfFile(cloud, format_, viewpoint));
  }
  catch (const std::exception& error) {
    if (!has_written_)
      throw;
    throw std::runtime_error(error.what() + ("; what was written until then is in '" +
                                             keepUnfinished().string() + "'"));
  }
  has_written_ = true;
}

fs::path
CloudFolder::keepUnfinished()
{
  return std::exchange(unfinished_, fs::path());
}

/** \brief Clouds in the folders of the streams that have names as an earlier run gives
 * them. They may be the user's. */
std::vector<fs::path>
CloudFolder::earlierClouds() const
{
  std::vector<fs::path> clouds;
  for (const std::string& folder : folders_)
    addCloudsIn(folder.empty() ? path_ : path_ / folder, clouds);
  std::sort(clouds.begin(), clouds.end());
  return clouds;
}

/** \brief The earlier clouds that no new one replaces. */
std::vector<fs::path>
CloudFolder::leftOver(const std::vector<fs::path>& earlier) const
{
  std::vector<fs::path> clouds;
  for (const fs::path& cloud : earlier)
    if (!fs::exists(unfinished_ / cloud.lexically_relative(path_)))
      clouds.push_back(cloud);
  return clouds;
}

/** \brief Refuses to leave clouds of others among the new ones. */
void
CloudFolder::checkForClouds(const std::vector<fs::path>& left_over)
{
  const auto is_other = [](const fs::path& cloud) { return !isOurs(cloud); };
  const auto first = std::find_if(left_over.begin(), left_over.end(), is_other);
  if (first == left_over.end())
    return;
  const auto others = std::count_if(first, left_over.end(), is_other);
  throw std::runtime_error(
      "the clouds in '" + path_.string() +
      "' stay as they were: " + counted(static_cast<std::size_t>(others), "cloud") +
      " that pcl_ext has not written, such as '" + first->string() +
      "', would be mixed with the new ones, which are in '" +
      keepUnfinished().string() + "'; remove what is old, or name another folder");
}

std::string
CloudFolder::finish()
{
  const std::vector<fs::path> earlier = earlierClouds();
  if (isInterrupted() && !earlier.empty())
    return "; interrupted: the clouds in '" + path_.string() +
           "' are still the earlier ones; what was written until then is in '" +
           keepUnfinished().string() + "'";
  const std::vector<fs::path> left_over = leftOver(earlier);
  checkForClouds(left_over);
  const fs::path unfinished = keepUnfinished(); // if a step fails
  if (!fs::exists(fs::symlink_status(path_))) {
    std::error_code error;
    fs::rename(unfinished, path_, error);
    if (!error)
      return describeInterruption(path_.string(), false);
  }
  // Another program may have filled it in the meantime.
  const bool is_inside = unfinished.parent_path() == fs::canonical(path_);
  if (!may_replace_ && (is_inside ? !earlier.empty() : !fs::is_empty(path_)))
    throw std::runtime_error("the folder '" + path_.string() +
                             "' is not empty any more; the clouds are in '" +
                             unfinished.string() + "'");
  try {
    moveClouds(unfinished);
    for (const fs::path& cloud : left_over)
      fs::remove(cloud);
  }
  catch (const fs::filesystem_error& failure) {
    throw std::runtime_error("not all clouds are in their folder; the others are in '" +
                             unfinished.string() + "': " + failure.what());
  }
  std::error_code ignored;
  fs::remove_all(unfinished, ignored);
  return describeInterruption(path_.string(), false);
}

/** \brief Moves the new clouds to their folders. */
void
CloudFolder::moveClouds(const fs::path& from) const
{
  for (const std::string& folder : folders_) {
    const fs::path target = folder.empty() ? path_ : path_ / folder;
    fs::create_directories(target);
    for (const fs::directory_entry& entry : fs::directory_iterator(from / folder))
      if (!entry.is_directory())
        fs::rename(entry.path(), target / entry.path().filename());
  }
}

} // namespace pcl_ext::tools

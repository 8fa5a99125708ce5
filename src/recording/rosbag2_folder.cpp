// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "recording/rosbag2_folder.h"

#include "recording/files.h"
#include "recording/rosbag2_metadata.h"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <map>
#include <sstream>
#include <system_error>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::recording {

namespace {

namespace fs = std::filesystem;

constexpr char metadata_name[] = "metadata.yaml";
constexpr char compressed_extension[] = ".zstd"; // of rosbag2

/** \brief The extension of a file's name in small letters, as systems that do not tell
 * them from capitals leave these behind. */
std::string
extensionOf(const fs::path& file)
{
  std::string extension = file.extension().string();
  for (char& letter : extension)
    if (letter >= 'A' && letter <= 'Z')
      letter = static_cast<char>(letter - 'A' + 'a');
  return extension;
}

/** \brief A file's name without the extension of compressed ones. */
fs::path
withoutCompression(const fs::path& file)
{
  const std::string extension = extensionOf(file);
  return extension == compressed_extension || extension == ".zst" ? file.stem()
                                                                  : file.filename();
}

/** \brief The number at the end of the name of a bag's file, such as 12 of bag_12.mcap,
 * so that 10 comes after 9. */
std::pair<std::size_t, std::string>
orderOf(const fs::path& file)
{
  const std::string stem = nameOfBagFile(file.string());
  const std::size_t digits = stem.find_last_not_of("0123456789") + 1;
  return {stem.size() - digits, stem.substr(digits)};
}

/** \brief A text in double quotes, for YAML. */
std::string
quoted(const std::string& text)
{
  std::ostringstream output;
  output << '"';
  for (const char character : text) {
    if (character == '"' || character == '\\')
      output << '\\' << character;
    else if (character == '\n')
      output << "\\n";
    else if (static_cast<unsigned char>(character) < 0x20)
      output << ' ';
    else
      output << character;
  }
  output << '"';
  return output.str();
}

std::string
valueOf(const McapChannel& channel, const std::string& key)
{
  const auto found = channel.metadata.find(key);
  return found == channel.metadata.end() ? std::string() : found->second;
}

/** \brief A text with blanks before each of its lines. */
std::string
indented(const std::string& text, std::size_t blanks)
{
  std::istringstream lines(text);
  std::string result;
  for (std::string line; std::getline(lines, line);)
    result += '\n' + std::string(blanks, ' ') + line;
  return result;
}

/** \brief The QoS of a topic for metadata.yaml, after its key. Version 9 has a list,
 * where others have its text. */
std::string
qosOf(const McapChannel& channel, bool is_version_9)
{
  const std::string qos = valueOf(channel, qos_metadata);
  constexpr std::size_t blanks = 10;
  if (!is_version_9)
    return " " + quoted(qos);
  return qos.empty() ? std::string(" []") : indented(withNamedPolicies(qos), blanks);
}

void
writeTopic(const Rosbag2Topic& topic, bool is_version_9, std::ostream& text)
{
  text << "\n    - topic_metadata:\n        name: " << quoted(topic.channel->topic)
       << "\n        type: " << quoted(topic.channel->schema.name)
       << "\n        serialization_format: " << quoted(topic.channel->message_encoding)
       << "\n        offered_qos_profiles:" << qosOf(*topic.channel, is_version_9);
  if (is_version_9)
    text << "\n        type_description_hash: "
         << quoted(valueOf(*topic.channel, "topic_type_hash"));
  text << "\n      message_count: " << topic.messages;
}

constexpr std::size_t most_metadata_bytes = std::size_t{1} << 24;

/** \brief The text of metadata.yaml, as far as it is read; empty if there is none. */
std::string
readMetadata(const std::string& folder)
{
  const fs::path path = fs::path(folder) / metadata_name;
  std::error_code ignored;
  InputFile file;
  if (!fs::is_regular_file(path, ignored) || !file.open(path.string()).ok())
    return {};
  std::string text(std::min<std::uint64_t>(file.size(), most_metadata_bytes), '\0');
  if (!file.read(0, text.size(), reinterpret_cast<std::uint8_t*>(text.data())))
    return {};
  return text;
}

/** \brief The name of a bag's file without its number. */
std::string
prefixOf(const fs::path& file)
{
  const std::string name = nameOfBagFile(file.string());
  return name.substr(0, name.find_last_not_of("0123456789") + 1);
}

/** \brief True if files are the parts of one bag that `ros2 bag record` named by the
 * time. */
bool
areNamedByTime(const std::vector<fs::path>& files)
{
  constexpr char beginning[] = "rosbag2_";
  return !files.empty() &&
         std::all_of(files.begin(), files.end(), [&](const fs::path& file) {
           const std::string prefix = prefixOf(file);
           return prefix.rfind(beginning, 0) == 0 && prefix.back() == '_' &&
                  prefix == prefixOf(files.front());
         });
}

/** \brief The files of a bag in a folder: those of MCAP, and where there are none those
 * of sqlite3; of a file that is there in both forms the one without compression. */
std::vector<fs::path>
bagFilesIn(const std::string& folder, std::error_code& error)
{
  std::vector<fs::path> mcap_files;
  std::vector<fs::path> databases;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    std::error_code ignored;
    const fs::path& path = entry->path();
    const fs::path name = withoutCompression(path);
    if (entry->is_directory(ignored) || !hasNameOfBagFile(path.string()) ||
        (name != path.filename() && fs::exists(path.parent_path() / name, ignored)))
      continue;
    (extensionOf(name) == ".mcap" ? mcap_files : databases).push_back(path);
  }
  return mcap_files.empty() ? databases : mcap_files;
}

/** \brief Why a folder with metadata.yaml has no files that can be read. */
std::string
whyNoFiles(const std::string& folder)
{
  const std::string metadata = readMetadata(folder);
  const std::string storage = readValue(metadata, "storage_identifier");
  const std::string compression = readValue(metadata, "compression_format");
  if (!compression.empty() && compression != "zstd")
    return ": its compression is '" + compression +
           "', and only zstd can be read: convert it with 'ros2 bag convert'";
  if (!storage.empty() && storage != "mcap" && storage != "sqlite3")
    return ": its storage is '" + storage +
           "', and only mcap and sqlite3 can be read: convert it with 'ros2 bag "
           "convert'";
  return "";
}

} // namespace

bool
hasNameOfBagFile(const std::string& path)
{
  const std::string extension = extensionOf(withoutCompression(path));
  return (extension == ".mcap" || extension == ".db3") &&
         fs::path(path).filename().string().rfind("._", 0) != 0;
}

std::string
nameOfBagFile(const std::string& path)
{
  return withoutCompression(path).stem().string();
}

bool
isRosbag2Folder(const std::string& path)
{
  std::error_code ignored;
  if (!fs::is_directory(path, ignored))
    return false;
  if (fs::exists(fs::path(path) / metadata_name, ignored))
    return true;
  // It is written last: a recorder that did not end in an orderly way left files alone.
  const fs::path given(path);
  std::string name =
      (given.has_filename() ? given : given.parent_path()).filename().string();
  const std::string suffix = unfinished_suffix;
  if (name.size() > suffix.size() &&
      name.compare(name.size() - suffix.size(), suffix.size(), suffix) == 0)
    name.resize(name.size() - suffix.size());
  const std::vector<fs::path> files = bagFilesIn(path, ignored);
  return areNamedByTime(files) ||
         std::any_of(files.begin(), files.end(), [&name](const fs::path& file) {
           return nameOfBagFile(file.string()) == name + "_0";
         });
}

bool
mayBeParts(const std::string& folder)
{
  std::error_code ignored;
  const std::vector<fs::path> files = bagFilesIn(folder, ignored);
  for (std::size_t number = 0; number < files.size(); ++number)
    if (std::none_of(files.begin(), files.end(), [&](const fs::path& file) {
          return nameOfBagFile(file.string()) ==
                 prefixOf(files.front()) + std::to_string(number);
        }))
      return false;
  return !files.empty() && prefixOf(files.front()).size() > 1 &&
         prefixOf(files.front()).back() == '_';
}

RecordingStatus
filesOfRosbag2Folder(const std::string& folder, std::vector<std::string>& files)
{
  std::error_code error;
  std::vector<fs::path> paths = bagFilesIn(folder, error);
  if (error)
    return {RecordingCode::InputFailed,
            "cannot read '" + folder + "': " + error.message()};
  // A pipe or a device might be waited for without end.
  for (const fs::path& path : paths)
    if (std::error_code ignored; !fs::is_regular_file(path, ignored))
      return {RecordingCode::InputFailed,
              "'" + path.string() + "' is no file: a bag has files only"};
  if (paths.empty())
    return {RecordingCode::NotARecording,
            "the bag '" + folder + "' has no file of MCAP or sqlite3" +
                whyNoFiles(folder)};
  std::sort(paths.begin(), paths.end(), [](const fs::path& a, const fs::path& b) {
    return std::make_pair(orderOf(a), a) < std::make_pair(orderOf(b), b);
  });
  for (const fs::path& path : paths)
    files.push_back(path.string());
  return {};
}

std::vector<RecordingDamage>
findMissingFiles(const std::string& folder)
{
  std::size_t missing = 0;
  std::string first;
  for (const std::string& name : readFileNames(readMetadata(folder))) {
    std::error_code ignored;
    const fs::path path = fs::path(folder) / name;
    if (fs::exists(path, ignored) ||
        fs::exists(path.string() + compressed_extension, ignored) ||
        fs::exists(path.parent_path() / withoutCompression(path), ignored))
      continue;
    if (++missing == 1)
      first = name;
  }
  if (missing == 0)
    return {};
  return {{0,
           "it names '" + first + "', which is not there" +
               (missing == 1 ? "" : ", and " + std::to_string(missing - 1) + " more"),
           (fs::path(folder) / metadata_name).string()}};
}

std::optional<RecordingDamage>
findMissingMessages(const std::string& folder, std::size_t found)
{
  // Where keys are sorted the first one is that of a file, which has no more.
  const std::string text = readValue(readMetadata(folder), "message_count");
  std::uint64_t counted = 0;
  const auto [end, fault] =
      std::from_chars(text.data(), text.data() + text.size(), counted);
  if (fault != std::errc() || found >= counted)
    return std::nullopt;
  return RecordingDamage{0,
                         "it counts " + std::to_string(counted) + " messages, and " +
                             std::to_string(found) + " were found",
                         (fs::path(folder) / metadata_name).string()};
}

void
addQosOfMetadata(const std::string& folder, std::vector<McapChannel>& channels)
{
  const std::map<std::string, std::string> profiles =
      readOfferedQos(readMetadata(folder));
  std::size_t added_bytes = 0; // many channels may have the same topic
  for (McapChannel& channel : channels)
    if (const auto found = profiles.find(channel.topic);
        found != profiles.end() && valueOf(channel, qos_metadata).empty() &&
        (added_bytes += found->second.size()) <= most_metadata_bytes)
      channel.metadata[qos_metadata] = found->second;
}

RecordingStatus
writeRosbag2Metadata(const std::string& folder,
                     const std::string& file,
                     const std::vector<Rosbag2Topic>& topics,
                     Time first_time,
                     Time last_time)
{
  std::uint64_t messages = 0;
  for (const Rosbag2Topic& topic : topics)
    messages += topic.messages;
  const bool is_version_9 =
      std::any_of(topics.begin(), topics.end(), [](const Rosbag2Topic& topic) {
        return hasNamedPolicies(valueOf(*topic.channel, qos_metadata));
      });
  std::ostringstream text;
  text << "rosbag2_bagfile_information:\n"
          "  version: "
       << (is_version_9 ? 9 : 5)
       << "\n"
          "  storage_identifier: mcap\n"
          "  duration:\n    nanoseconds: "
       << (last_time - first_time).count()
       << "\n  starting_time:\n    nanoseconds_since_epoch: " << first_time.count()
       << "\n  message_count: " << messages << "\n  topics_with_message_count:";
  for (const Rosbag2Topic& topic : topics)
    writeTopic(topic, is_version_9, text);
  text << (topics.empty() ? " []" : "")
       << "\n  compression_format: \"\"\n  compression_mode: \"\"\n"
          "  relative_file_paths:\n    - "
       << quoted(file) << "\n  files:\n    - path: " << quoted(file)
       << "\n      starting_time:\n        nanoseconds_since_epoch: "
       << first_time.count()
       << "\n      duration:\n        nanoseconds: " << (last_time - first_time).count()
       << "\n      message_count: " << messages << '\n'
       << (is_version_9 ? "  custom_data: {}\n  ros_distro: \"\"\n" : "");
  const std::string bytes = text.str();
  OutputFile output;
  RecordingStatus status = output.open((fs::path(folder) / metadata_name).string());
  if (status.ok())
    status =
        output.write(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
  return status.ok() ? output.close() : status;
}

} // namespace pcl_ext::PCL_EXT_ABI::recording

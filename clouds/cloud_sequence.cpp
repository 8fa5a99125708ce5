// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "clouds/cloud_sequence.h"

#include "clouds/bin_file.h"
#include "clouds/cloud_files.h"
#include "clouds/file_stamps.h"
#include "clouds/natural_order.h"
#include "clouds/pcd_file.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <map>
#include <optional>
#include <stdexcept>

namespace pcl_ext {
namespace clouds {

namespace {

namespace fs = std::filesystem;

std::string
describe(const PcdHeader& header)
{
  return header.width + " x " + header.height + " points with " + header.fields;
}

/** \brief Whether two clouds are hardly of one sensor: images have as many rows, and
 * about as many columns; one row has as many points as were seen. */
bool
areUnlike(const PcdHeader& one, const PcdHeader& other)
{
  constexpr double most_times = 2.0;
  const double width = std::strtod(one.width.c_str(), nullptr);
  const double other_width = std::strtod(other.width.c_str(), nullptr);
  return one.fields != other.fields || one.height != other.height ||
         (one.height != "1" &&
          std::max(width, other_width) > most_times * std::min(width, other_width));
}

/** \brief Tells whether the files of a stream may be of several sensors, as far as their
 * headers tell.
 * \param[out] viewpoints of the files
 * \return why they may be; empty if nothing tells
 */
std::string
describeSensors(const std::vector<std::string>& files,
                std::vector<std::string>& viewpoints)
{
  const std::string advice =
      "; if they are of several sensors, put those of each into a folder of their own "
      "and name the folders";
  std::string first_file;
  std::optional<PcdHeader> first;
  std::string unlike;
  bool has_moved = false;
  for (const std::string& file : files) {
    const std::optional<PcdHeader> header = readPcdHeader(file);
    viewpoints.push_back(header ? header->viewpoint : "");
    // One that cannot be read is reported when it is; one without points may be any.
    if (!header || header->width == "0" || header->height == "0")
      continue;
    if (!first) {
      first_file = file;
      first = header;
      continue;
    }
    if (unlike.empty() && areUnlike(*header, *first))
      unlike = "'" + file + "' (" + describe(*header) + ") is unlike '" + first_file +
               "' (" + describe(*first) + ")" + advice;
    has_moved |= header->viewpoint != first->viewpoint;
  }
  return !unlike.empty() ? unlike
         : has_moved     ? "the files have different viewpoints" + advice
                         : "";
}

class FileSequence : public CloudSequence {
public:
  FileSequence(std::string name,
               std::vector<std::string> files,
               const std::vector<FileField>& bin_fields,
               const LongIntegers& long_integers)
  : CloudSequence(std::move(name))
  , bin_fields_(bin_fields)
  , usual_fields_(long_integers)
  , files_(std::move(files))
  , remark_(describeSensors(files_, viewpoints_))
  , stamps_(stampsOfNames(files_))
  {}

  std::string
  remark() const override
  {
    const bool has_both = !remark_.empty() && !stamps_.problem.empty();
    const std::string remarks = remark_ + (has_both ? "; " : "") + stamps_.problem;
    return remarks.empty() ? remarks : name() + ": " + remarks;
  }

  std::vector<std::string>
  remarksOnClouds() const override
  {
    return remarks_on_clouds_;
  }

  std::size_t
  size() const override
  {
    return files_.size();
  }

  Eigen::Isometry3d
  sensorPose() const override
  {
    return Eigen::Isometry3d::Identity();
  }

  std::optional<std::chrono::nanoseconds>
  stampAt(std::size_t index) const override
  {
    return stamps_.stamps.empty() ? std::nullopt : std::optional(stamps_.stamps[index]);
  }

  std::string
  viewpointAt(std::size_t index) const override
  {
    return viewpoints_[index];
  }

  void
  read(std::size_t index, pcl::PCLPointCloud2& cloud) override
  {
    try {
      for (const std::string& remark :
           readCloud(files_[index], cloud, bin_fields_, &usual_fields_))
        if (std::find(remarks_on_clouds_.begin(), remarks_on_clouds_.end(), remark) ==
                remarks_on_clouds_.end() &&
            remarks_on_clouds_.size() < most_remarks)
          remarks_on_clouds_.push_back(remark);
    }
    catch (const FieldRefusal& error) {
      throw FieldRefusal("'" + files_[index] + "': " + error.what());
    }
    catch (const std::exception& error) {
      throw std::runtime_error("cannot read '" + files_[index] + "': " + error.what());
    }
  }

private:
  static constexpr std::size_t most_remarks = 32;

  std::vector<FileField> bin_fields_; // of a .bin file
  UsualFields usual_fields_;
  std::vector<std::string> files_;
  std::vector<std::string> viewpoints_; // of the files
  std::string remark_;
  std::vector<std::string> remarks_on_clouds_;
  StampsOfFiles stamps_;
};

bool
isCloudFile(const fs::directory_entry& entry)
{
  // Pipes and devices may never end.
  return hasNameOfCloud(entry.path().string()) && !entry.is_directory() &&
         !entry.is_other();
}

/** \brief A folder in a folder that has files of clouds. */
std::optional<std::string>
folderOfCloudsIn(const fs::path& folder)
{
  for (const fs::directory_entry& entry : fs::directory_iterator(folder))
    if (entry.is_directory() && std::any_of(fs::directory_iterator(entry),
                                            fs::directory_iterator(),
                                            isCloudFile))
      return entry.path().string();
  return std::nullopt;
}

std::vector<std::string>
cloudFilesOf(const fs::path& folder)
{
  std::vector<std::string> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder))
    if (isCloudFile(entry))
      files.push_back(entry.path().string());
  if (files.empty()) {
    const std::optional<std::string> inner = folderOfCloudsIn(folder);
    const std::string ignored = describeIgnored(folder.string());
    throw std::runtime_error("no PCD, PLY or .bin file in the folder '" +
                             folder.string() + "', and no bag" +
                             (inner ? "; name the folders in it, each of which is a "
                                      "stream, such as '" +
                                          *inner + "'"
                              : !ignored.empty() ? "; it has " + ignored
                                                 : ""));
  }
  std::sort(files.begin(), files.end(), comesBefore);
  sortByStamp(files);
  return files;
}

std::unique_ptr<CloudSequence>
makeSequence(const std::string& name,
             std::vector<std::string> files,
             std::size_t max_frames,
             const std::vector<FileField>& bin_fields,
             const LongIntegers& long_integers)
{
  if (max_frames != 0 && files.size() > max_frames)
    files.resize(max_frames);
  return std::make_unique<FileSequence>(
      name, std::move(files), bin_fields, long_integers);
}

/** \brief The last part of a folder's path. */
std::string
folderName(const fs::path& folder)
{
  const fs::path name =
      (folder.has_filename() ? folder : folder.parent_path()).filename();
  return (name == "." || name == ".." ? fs::canonical(folder).filename() : name)
      .string();
}

/** \brief Files named singly that are one sequence. */
struct FileGroup {
  fs::path folder;
  std::string first_name; ///< of the first file, without its extension
  std::vector<std::string> files;
};

void
addFile(const SequenceInput& input,
        FileGrouping grouping,
        std::vector<FileGroup>& groups)
{
  const fs::path name(input.name);
  const auto group =
      std::find_if(groups.begin(), groups.end(), [&](const FileGroup& other) {
        return grouping == FileGrouping::OneSequence ||
               other.folder == name.parent_path();
      });
  if (group != groups.end())
    group->files.push_back(input.path);
  else
    groups.push_back({name.parent_path(), stemOf(input.name), {input.path}});
}

/** \brief Numbers the sequences of the same name, as names become folders. */
void
makeNamesDistinct(std::vector<std::unique_ptr<CloudSequence>>& sequences)
{
  std::map<std::string, int> uses;
  for (const auto& sequence : sequences) {
    const int use = ++uses[sequence->name()];
    if (use > 1)
      sequence->rename(sequence->name() + "_" + std::to_string(use));
  }
}

} // namespace

std::vector<std::unique_ptr<CloudSequence>>
openSequences(const std::vector<SequenceInput>& inputs,
              std::size_t max_frames,
              FileGrouping grouping,
              const std::vector<FileField>& bin_fields,
              const LongIntegers& long_integers)
{
  std::vector<std::unique_ptr<CloudSequence>> sequences;
  std::vector<FileGroup> groups;
  for (const SequenceInput& input : inputs) {
    if (!fs::exists(input.path))
      throw std::runtime_error("there is no '" + input.name + "'");
    if (fs::is_directory(input.path))
      sequences.push_back(makeSequence(folderName(input.name),
                                       cloudFilesOf(input.path),
                                       max_frames,
                                       bin_fields,
                                       long_integers));
    else
      addFile(input, grouping, groups);
  }
  for (FileGroup& group : groups) {
    const std::string name = groups.size() > 1 ? folderName(group.folder) : "";
    sequences.push_back(makeSequence(name.empty() ? group.first_name : name,
                                     std::move(group.files),
                                     max_frames,
                                     bin_fields,
                                     long_integers));
  }
  makeNamesDistinct(sequences);
  return sequences;
}

std::vector<std::unique_ptr<CloudSequence>>
openSequences(const std::vector<std::string>& inputs, std::size_t max_frames)
{
  std::vector<SequenceInput> named;
  named.reserve(inputs.size());
  for (const std::string& input : inputs)
    named.push_back({input, input});
  auto sequences = openSequences(named, max_frames, FileGrouping::OneSequence);
  for (const auto& sequence : sequences)
    if (const std::string remark = sequence->remark(); !remark.empty())
      std::cerr << remark << '\n';
  return sequences;
}

bool
hasBinFile(const std::string& path)
{
  const auto isBin = [](const std::string& file) {
    // Who reads text, or a file of another program, says what it is.
    const FileKind kind = kindOf(file);
    return kind == FileKind::Bin || kind == FileKind::Unknown ||
           kind == FileKind::Text || kind == FileKind::Foreign;
  };
  if (!fs::is_directory(path))
    return isBin(path);
  return std::any_of(fs::directory_iterator(path),
                     fs::directory_iterator(),
                     [&isBin](const fs::directory_entry& entry) {
                       return isCloudFile(entry) && isBin(entry.path().string());
                     });
}

std::string
describeIgnored(const std::string& folder)
{
  std::vector<std::string> files;
  std::vector<std::string> folders;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (name.front() != '.' && !isCloudFile(entry))
      (entry.is_directory() ? folders : files).push_back(name);
  }
  return describeLeftOut(folders, files);
}

std::string
describeLeftOut(std::vector<std::string> folders, std::vector<std::string> files)
{
  const auto describeNames = [](std::vector<std::string> names, const char* what) {
    if (names.empty())
      return std::string();
    std::sort(names.begin(), names.end(), comesBefore);
    return std::to_string(names.size()) + " " + what + (names.size() > 1 ? "s" : "") +
           " (" + names.front() + (names.size() > 1 ? ", ...)" : ")");
  };
  const std::string of_folders = describeNames(std::move(folders), "folder");
  const std::string of_files = describeNames(std::move(files), "other file");
  return of_folders + (of_folders.empty() || of_files.empty() ? "" : " and ") +
         of_files;
}

} // namespace clouds
} // namespace pcl_ext

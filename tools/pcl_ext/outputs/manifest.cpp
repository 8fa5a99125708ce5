// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "outputs/manifest.h"

#include "console/exit_status.h"
#include "console/printable_text.h"
#include "recording/system_files.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>

namespace pcl_ext::tools {

namespace fs = std::filesystem;

using Json = nlohmann::ordered_json;

namespace {

[[noreturn]] void
throwError(const std::string& what, const std::string& path)
{
  throw std::runtime_error(what + " '" + path + "': " + std::strerror(errno));
}

/** \brief A path that is the same from any working folder, as JSON takes it. */
std::string
absolutePath(const std::string& path)
{
  std::string absolute = fs::weakly_canonical(path).string();
  if (absolute.size() > 1 && absolute.back() == '/')
    absolute.pop_back();
  return printable(absolute);
}

std::string
nameOf(const BagToEncode& bag)
{
  return printable(fs::path(bag.output).filename().string());
}

std::string
textIn(const Json& line, const char* key)
{
  const auto found = line.find(key);
  return found != line.end() && found->is_string() ? found->get<std::string>() : "";
}

template <typename NumberT>
NumberT
numberIn(const Json& line, const char* key)
{
  const auto found = line.find(key);
  return found != line.end() && found->is_number_integer() ? found->get<NumberT>()
                                                           : NumberT{0};
}

} // namespace

InputState
stateOf(const std::string& path)
{
  InputState state;
  const auto add = [&state](const std::string& file) {
    std::int64_t changed_ns = 0;
    if (!recording::lastChange(file, changed_ns))
      throwError("cannot read", file);
    if (!fs::is_regular_file(file))
      return;
    state.bytes += fs::file_size(file);
    state.mtime_ns = std::max(state.mtime_ns, changed_ns);
  };
  if (!fs::is_directory(path))
    add(path);
  else
    for (const fs::directory_entry& entry : fs::directory_iterator(path))
      add(entry.path().string());
  return state;
}

Manifest::Manifest(const std::string& folder,
                   const std::string& options,
                   bool forgets_others)
: path_((fs::path(folder) / file_name).string())
, options_(options)
, forgets_others_(forgets_others)
{
  std::error_code error;
  fs::create_directories(folder, error);
  if (error)
    throw std::runtime_error("cannot make the folder '" + folder +
                             "': " + error.message());
  file_ = recording::Descriptor(recording::openToWrite(path_));
  if (!file_.isOpen() && errno == EBUSY)
    throw UsageError("another run encodes bags into '" + folder +
                     "': wait for its end, or name another folder");
  if (!file_.isOpen())
    throwError("cannot open", path_);
  read();
}

void
Manifest::read()
{
  std::ifstream file(path_, std::ios::binary);
  std::uintmax_t end = 0; // of the last whole line; a run was killed in the next one
  for (std::string text; std::getline(file, text) && !file.eof();) {
    end += text.size() + 1;
    const Json line = Json::parse(text, nullptr, false);
    if (!line.is_object() || textIn(line, "output").empty())
      throw std::runtime_error("'" + path_ +
                               "' has a line that is none of a manifest, '" +
                               text.substr(0, 40) + "': name another folder");
    lines_[textIn(line, "output")] = line;
  }
  if (!recording::truncateFile(file_.get(), end))
    throwError("cannot write", path_);
}

nlohmann::ordered_json
Manifest::lineOf(const BagToEncode& bag) const
{
  const auto found = lines_.find(nameOf(bag));
  return found == lines_.end() ? Json::object() : found->second;
}

bool
Manifest::isOwn(const BagToEncode& bag) const
{
  return lines_.count(nameOf(bag)) != 0;
}

bool
Manifest::isDone(const BagToEncode& bag) const
{
  const auto found = lines_.find(nameOf(bag));
  if (found == lines_.end())
    return false;
  const Json& line = found->second;
  if (textIn(line, "input") != absolutePath(bag.input)) {
    if (forgets_others_)
      return false;
    throw UsageError("'" + bag.output + "' is of another bag, '" +
                     textIn(line, "input") +
                     "': name another folder, or replace it with --overwrite");
  }
  const bool has_options = textIn(line, "options") == options_;
  std::error_code error;
  if (!has_options && !forgets_others_ && fs::exists(bag.output, error))
    throw UsageError("'" + bag.output + "' was encoded with other options, '" +
                     textIn(line, "options") +
                     "': name another folder, or encode all again with --overwrite");
  const std::uintmax_t size = fs::file_size(bag.output, error);
  const InputState recorded = {numberIn<std::uintmax_t>(line, "input_bytes"),
                               numberIn<std::int64_t>(line, "input_mtime_ns")};
  return textIn(line, "status") == "done" && has_options && !error &&
         size == numberIn<std::uintmax_t>(line, "output_bytes") &&
         recorded == stateOf(bag.input);
}

void
Manifest::begin(const BagToEncode& bag)
{
  finish(bag, {{"status", "begun"}});
}

void
Manifest::finish(const BagToEncode& bag, const nlohmann::ordered_json& line)
{
  Json whole = {{"input", absolutePath(bag.input)},
                {"output", nameOf(bag)},
                {"options", options_}};
  whole.update(line);
  append(whole);
  lines_[nameOf(bag)] = whole;
}

void
Manifest::append(const nlohmann::ordered_json& line)
{
  const std::string text =
      line.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
  if (!recording::writeAll(
          file_.get(), reinterpret_cast<const std::uint8_t*>(text.data()), text.size()))
    throwError("cannot write", path_);
}

} // namespace pcl_ext::tools

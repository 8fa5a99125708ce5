// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "viewing/viewer_page.h"

#include <pcl_ext/view/view_server.h>

#include "console/interruption.h"

#ifdef __APPLE__
#include <mach-o/dyld.h>
#endif

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string_view>
#include <vector>

namespace pcl_ext::tools {

namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t bytes_of_a_megabyte = 1'000'000;

/** \brief What a page with a recording in it has, and where it begins. */
constexpr std::string_view element_of_recording = R"(id="pcl-ext-recording")";
constexpr std::string_view body = "<body>";

/** \brief Where the page is beside this program, installed or in a build tree. */
fs::path
installedPage()
{
#ifdef __APPLE__
  std::array<char, 4096> name{};
  auto size = static_cast<std::uint32_t>(name.size());
  const fs::path program = ::_NSGetExecutablePath(name.data(), &size) == 0
                               ? fs::weakly_canonical(name.data())
                               : fs::path();
#else
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
#endif
  return (program.parent_path() / PCL_EXT_PAGE_FROM_PROGRAM).lexically_normal();
}

/** \brief How to get the page that is not where it is looked for. */
std::string
remedyForPage(const fs::path& page)
{
  // In a build tree it is a link to the page of viewer/build.sh, in viewer/dist.
  std::error_code error;
  const fs::path built = fs::read_symlink(page, error);
  if (!error)
    return "this command makes it: bash " +
           (built.parent_path().parent_path() / "build.sh").string() +
           "; --page names another one";
  return "in a clone of pcl_ext the command bash viewer/build.sh makes it, as "
         "viewer/dist/viewer.html: name that with --page, or copy it to " +
         page.string();
}

[[noreturn]] void
fail(const std::string& what)
{
  throw std::runtime_error(what + ": " + std::strerror(errno));
}

/** \brief Three bytes, or what is left, as four characters. */
void
appendBase64(const char* bytes, std::size_t count, std::string& text)
{
  static constexpr char digits[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  for (std::size_t i = 0; i < count; i += 3) {
    std::uint32_t bits = 0;
    for (std::size_t j = 0; j < 3; ++j)
      bits =
          bits << 8 | (i + j < count ? static_cast<unsigned char>(bytes[i + j]) : 0u);
    for (std::size_t j = 0; j < 4; ++j)
      text += i + j <= count ? digits[bits >> (18 - 6 * j) & 63] : '=';
  }
}

/** \brief A text as the value of an attribute. */
std::string
escaped(const std::string& text)
{
  std::string result;
  for (const char character : text)
    switch (character) {
    case '&':
      result += "&amp;";
      break;
    case '<':
      result += "&lt;";
      break;
    case '>':
      result += "&gt;";
      break;
    case '"':
      result += "&quot;";
      break;
    default:
      result += character;
    }
  return result;
}

/** \brief A file that has its name when it is complete; else it is removed. */
class NewFile {
public:
  explicit NewFile(const std::string& path)
  : path_(path), unfinished_(path + ".unfinished")
  {
    file_.open(unfinished_, std::ios::binary | std::ios::trunc);
    if (!file_)
      fail("cannot write '" + path + "'");
  }

  ~NewFile()
  {
    if (file_.is_open()) {
      file_.close();
      std::error_code ignored;
      fs::remove(unfinished_, ignored);
    }
  }

  NewFile(const NewFile&) = delete;
  NewFile&
  operator=(const NewFile&) = delete;

  void
  write(const std::string& text)
  {
    if (!file_.write(text.data(), static_cast<std::streamsize>(text.size())))
      fail("cannot write '" + path_ + "'");
  }

  void
  finish()
  {
    if (!file_.flush())
      fail("cannot write '" + path_ + "'");
    fs::rename(unfinished_, path_);
    file_.close();
  }

private:
  std::string path_;
  std::string unfinished_;
  std::ofstream file_;
};

/** \brief Writes a file as base64; false if the program was interrupted. */
bool
writeBase64(const std::string& path, NewFile& output)
{
  std::ifstream input(path, std::ios::binary);
  constexpr std::size_t piece = std::size_t{3} << 18; // whole groups of three
  std::vector<char> bytes(piece);
  std::string text;
  while (input) {
    if (isInterrupted())
      return false;
    input.read(bytes.data(), static_cast<std::streamsize>(piece));
    text.clear();
    appendBase64(bytes.data(), static_cast<std::size_t>(input.gcount()), text);
    output.write(text);
  }
  if (!input.eof())
    fail("cannot read '" + path + "'");
  return true;
}

} // namespace

void
checkSizeForPage(const std::string& recording)
{
  std::error_code ignored;
  if (!fs::is_regular_file(recording, ignored))
    return;
  const std::uint64_t size = fs::file_size(recording);
  if (size > max_embedded_bytes)
    throw std::runtime_error("'" + recording + "' has " +
                             std::to_string(size / bytes_of_a_megabyte) +
                             " MB, and browsers take pages with " +
                             std::to_string(max_embedded_bytes / bytes_of_a_megabyte) +
                             " MB at most: take a part of it with pcl_ext cut");
}

std::string
readPage(const std::string& path)
{
  const std::string page = path.empty() ? installedPage().string() : path;
  if (path.empty() && !fs::exists(page))
    throw std::runtime_error("the viewer's page is not there; " + remedyForPage(page));
  std::ifstream file(page, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(file),
                   std::istreambuf_iterator<char>()};
  if (!file || text.empty())
    throw std::runtime_error("the page '" + page + "' cannot be read or is empty");
  const auto has = [&](std::string_view part) {
    return text.find(part) != std::string::npos;
  };
  if (has(element_of_recording))
    throw std::runtime_error(
        "the page '" + page +
        "' has a recording in it, as of --export, and would show that");
  if (!view::isViewerPage(text) || !has(body))
    throw std::runtime_error("'" + page +
                             "' is not the viewer's page, as viewer/build.sh makes it");
  return text;
}

std::uint64_t
writePageWithRecording(const std::string& page,
                       const std::string& recording,
                       const std::string& output)
{
  checkSizeForPage(recording);
  // Before the page's code, which looks for it.
  const std::size_t begin = page.find(body) + body.size();
  NewFile file(output);
  file.write(page.substr(0, begin));
  file.write(R"(<script type="application/octet-stream;base64" )" +
             std::string(element_of_recording) + " data-name=\"" +
             escaped(fs::path(recording).filename().string()) + "\">");
  if (!writeBase64(recording, file))
    return 0;
  file.write("</script>" + page.substr(begin));
  file.finish();
  return fs::file_size(output);
}

} // namespace pcl_ext::tools

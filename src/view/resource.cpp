// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "view/resource.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <functional>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace pcl_ext::PCL_EXT_ABI::view {

namespace {

class TextResource : public Resource {
public:
  TextResource(const std::string& type, std::string text)
  : Resource(type), text_(std::move(text))
  {
    size_ = text_.size();
    tag_ = '"' + std::to_string(std::hash<std::string>()(text_)) + '"';
  }

  bool
  read(std::uint64_t offset, std::size_t count, char* bytes) const override
  {
    if (offset > text_.size() || count > text_.size() - offset)
      return false;
    std::memcpy(bytes, text_.data() + offset, count);
    return true;
  }

private:
  std::string text_;
};

class FileResource : public Resource {
public:
  FileResource(const std::string& type, const std::string& path)
  : Resource(type), descriptor_(::open(path.c_str(), O_RDONLY | O_CLOEXEC))
  {
    struct stat status {};
    if (descriptor_ < 0 || ::fstat(descriptor_, &status) != 0 ||
        !S_ISREG(status.st_mode)) {
      const std::string reason = descriptor_ < 0 || S_ISREG(status.st_mode)
                                     ? std::strerror(errno)
                                     : "it is no regular file";
      if (descriptor_ >= 0)
        ::close(descriptor_);
      throw std::runtime_error("'" + path + "' cannot be read: " + reason);
    }
    size_ = static_cast<std::uint64_t>(status.st_size);
    std::error_code ignored;
    const auto changed =
        std::filesystem::last_write_time(path, ignored).time_since_epoch();
    tag_ = '"' + std::to_string(status.st_size) + '-' +
           std::to_string(changed.count()) + '"';
  }

  ~FileResource() override { ::close(descriptor_); }

  bool
  read(std::uint64_t offset, std::size_t count, char* bytes) const override
  {
    while (count > 0) {
      const ssize_t done =
          ::pread(descriptor_, bytes, count, static_cast<off_t>(offset));
      if (done < 0 && errno == EINTR)
        continue;
      if (done <= 0)
        return false;
      bytes += done;
      offset += static_cast<std::uint64_t>(done);
      count -= static_cast<std::size_t>(done);
    }
    return true;
  }

private:
  int descriptor_;
};

} // namespace

std::shared_ptr<const Resource>
textResource(const std::string& type, std::string text)
{
  return std::make_shared<TextResource>(type, std::move(text));
}

std::shared_ptr<const Resource>
fileResource(const std::string& type, const std::string& path)
{
  return std::make_shared<FileResource>(type, path);
}

} // namespace pcl_ext::PCL_EXT_ABI::view

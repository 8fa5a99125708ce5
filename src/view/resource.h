// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl_ext/version.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>

namespace pcl_ext::PCL_EXT_ABI::view {

/** \brief Something that is served: bytes of known number. */
class Resource {
public:
  explicit Resource(std::string type) : type_(std::move(type)) {}
  virtual ~Resource() = default;
  Resource(const Resource&) = delete;
  Resource&
  operator=(const Resource&) = delete;

  const std::string&
  type() const
  {
    return type_;
  }

  /** \brief Its entity tag, with quotation marks. */
  const std::string&
  tag() const
  {
    return tag_;
  }

  std::uint64_t
  size() const
  {
    return size_;
  }

  /** \brief Reads bytes from an offset; false unless all were read. */
  virtual bool
  read(std::uint64_t offset, std::size_t count, char* bytes) const = 0;

protected:
  std::string tag_;
  std::uint64_t size_ = 0;

private:
  std::string type_;
};

/** \brief What is served, by path; paths are looked up as they come. */
using Resources = std::map<std::string, std::shared_ptr<const Resource>, std::less<>>;

/** \brief Bytes in memory. */
std::shared_ptr<const Resource>
textResource(const std::string& type, std::string text);

/** \brief A file, which stays open. Its size is that of now.
 * \throws std::runtime_error if it cannot be read
 */
std::shared_ptr<const Resource>
fileResource(const std::string& type, const std::string& path);

} // namespace pcl_ext::PCL_EXT_ABI::view

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/status.h>

#include <algorithm>
#include <cstddef>

namespace pcl_ext::PCL_EXT_ABI {

SettingText
SettingText::of(const std::string& message)
{
  SettingText text;
  for (const char letter : message)
    text.marked += letter == '{' ? "{{" : std::string(1, letter);
  return text;
}

std::string
SettingText::with(
    const std::function<std::string(const std::string& id)>& name_of) const
{
  std::string text;
  for (std::size_t at = 0; at < marked.size();) {
    const std::size_t brace = std::min(marked.find('{', at), marked.size());
    text.append(marked, at, brace - at);
    at = brace + 1;
    const std::size_t end = marked.find('}', at);
    if (at < marked.size() && marked[at] == '{') {
      text += '{';
      ++at;
    }
    else if (brace < marked.size() && end != std::string::npos) {
      text += name_of(marked.substr(at, end - at));
      at = end + 1;
    }
  }
  return text;
}

std::string
SettingText::withIds() const
{
  return with([](const std::string& id) { return id; });
}

} // namespace pcl_ext::PCL_EXT_ABI

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include "bindings.h"

#include <utility>

namespace pcl_ext::python {

using recording::RecordingCode;

const char*
codeName(io::CompressionCode code)
{
  using Code = io::CompressionCode;
  constexpr std::pair<Code, const char*> names[] = {
      {Code::Ok, "Ok"},
      {Code::InvalidSettings, "InvalidSettings"},
      {Code::InvalidInput, "InvalidInput"},
      {Code::OutputFailed, "OutputFailed"},
      {Code::EndOfStream, "EndOfStream"},
      {Code::NoFrame, "NoFrame"},
      {Code::UnsupportedVersion, "UnsupportedVersion"},
      {Code::Truncated, "Truncated"},
      {Code::Corrupt, "Corrupt"},
      {Code::LimitExceeded, "LimitExceeded"},
      {Code::MissingReference, "MissingReference"},
      {Code::InputFailed, "InputFailed"},
      {Code::OldFrame, "OldFrame"},
      {Code::OutOfMemory, "OutOfMemory"},
      {Code::LeftOut, "LeftOut"}};
  for (const auto& [known, name] : names)
    if (known == code)
      return name;
  return "unknown";
}

const char*
codeName(OutlierRemovalCode code)
{
  switch (code) {
  case OutlierRemovalCode::Ok:
    return "Ok";
  case OutlierRemovalCode::InvalidSettings:
    return "InvalidSettings";
  case OutlierRemovalCode::UnsupportedResolution:
    return "UnsupportedResolution";
  case OutlierRemovalCode::NoDensities:
    return "NoDensities";
  case OutlierRemovalCode::DifferentCloud:
    return "DifferentCloud";
  case OutlierRemovalCode::InvalidCloud:
    return "InvalidCloud";
  case OutlierRemovalCode::NoImage:
    return "NoImage";
  }
  return "unknown";
}

const char*
codeName(TemporalFilterCode code)
{
  switch (code) {
  case TemporalFilterCode::Ok:
    return "Ok";
  case TemporalFilterCode::InvalidSettings:
    return "InvalidSettings";
  case TemporalFilterCode::HasPointCounts:
    return "HasPointCounts";
  }
  return "unknown";
}

const char*
codeName(RecordingCode code)
{
  switch (code) {
  case RecordingCode::Ok:
    return "Ok";
  case RecordingCode::EndOfRecording:
    return "EndOfRecording";
  case RecordingCode::InputFailed:
    return "InputFailed";
  case RecordingCode::NotARecording:
    return "NotARecording";
  case RecordingCode::Damaged:
    return "Damaged";
  case RecordingCode::InvalidArgument:
    return "InvalidArgument";
  case RecordingCode::OutputFailed:
    return "OutputFailed";
  case RecordingCode::OutOfMemory:
    return "OutOfMemory";
  }
  return "unknown";
}

} // namespace pcl_ext::python

// Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause
#include <pcl_ext/impl/named_value.h>

#include "bindings.h"

#include <array>

namespace pcl_ext::python {

const char*
codeName(io::CompressionCode code)
{
  using Code = io::CompressionCode;
  constexpr std::array<NamedValue<Code>, 15> names = {
      {{Code::Ok, "Ok"},
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
       {Code::LeftOut, "LeftOut"}}};
  return nameOf(names, code);
}

const char*
codeName(OutlierRemovalCode code)
{
  using Code = OutlierRemovalCode;
  constexpr std::array<NamedValue<Code>, 7> names = {
      {{Code::Ok, "Ok"},
       {Code::InvalidSettings, "InvalidSettings"},
       {Code::UnsupportedResolution, "UnsupportedResolution"},
       {Code::NoDensities, "NoDensities"},
       {Code::DifferentCloud, "DifferentCloud"},
       {Code::InvalidCloud, "InvalidCloud"},
       {Code::NoImage, "NoImage"}}};
  return nameOf(names, code);
}

const char*
codeName(TemporalFilterCode code)
{
  using Code = TemporalFilterCode;
  constexpr std::array<NamedValue<Code>, 3> names = {
      {{Code::Ok, "Ok"},
       {Code::InvalidSettings, "InvalidSettings"},
       {Code::HasPointCounts, "HasPointCounts"}}};
  return nameOf(names, code);
}

const char*
codeName(recording::RecordingCode code)
{
  using Code = recording::RecordingCode;
  constexpr std::array<NamedValue<Code>, 8> names = {
      {{Code::Ok, "Ok"},
       {Code::EndOfRecording, "EndOfRecording"},
       {Code::InputFailed, "InputFailed"},
       {Code::NotARecording, "NotARecording"},
       {Code::Damaged, "Damaged"},
       {Code::InvalidArgument, "InvalidArgument"},
       {Code::OutputFailed, "OutputFailed"},
       {Code::OutOfMemory, "OutOfMemory"}}};
  return nameOf(names, code);
}

} // namespace pcl_ext::python

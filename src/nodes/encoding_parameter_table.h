#pragma once

#include <pcl_ext/compression/compression_settings.h>
#include <pcl_ext/intensity/intensity_law.h>

#include "nodes/parameter_access.h"

#include <optional>

// The words of encodingParameters() and what they stand for.

namespace pcl_ext {
namespace nodes {

/** \brief The laws; auto: none, as it depends on the clouds. */
const Words<std::optional<IntensityLaw>>&
lawWords();

/** \brief The sensors that have a name. */
const Words<RuntimeSensor>&
sensorWords();

const Words<io::Effort>&
effortWords();

const Words<io::StreamFormat>&
formatWords();

const Words<io::Aggregation>&
aggregationWords();

const Words<io::IntensityCurve>&
curveWords();

} // namespace nodes
} // namespace pcl_ext

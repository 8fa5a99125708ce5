#!/usr/bin/env bash
# Measures all that the report and experiments/noise/README.md tell of noise.
# Usage: measure_all.sh <program measure_noise> <folder for the results> <most frames>
set -euo pipefail
program=$1
folder=$2
frames=$3

# name of the results, frames at most, options
measure() {
  local name=$1 most=$2
  shift 2
  echo "measure_noise: $name" >&2
  "$program" --frames $((frames < most ? frames : most)) \
    --results "$folder/results_noise_$name.csv" "$@" > /dev/null
}
measure laws 300 --part laws --sensor 1 2 3 4 5 6 7
measure laws_2cm 60 --part laws --sensor 1 --resolution 0.02
measure fused 300 --part fused
measure peers 60 --part peers
measure time 60 --part time
# The sensor with the most voxels.
measure time_2cm 20 --part time --sensor 5 --resolution 0.02
measure bytes 300 --part bytes

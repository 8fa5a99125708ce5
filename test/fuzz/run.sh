#!/usr/bin/env bash
# Copyright (c) 2026, the pcl_ext authors. SPDX-License-Identifier: BSD-3-Clause

# Builds the fuzz targets with AddressSanitizer and UndefinedBehaviorSanitizer and runs each
# on what it has found before and on the seeds; prints executions, executions a second and
# coverage of each. Stops with an error if an input fails, and says where it is.
#
# Usage: test/fuzz/run.sh [option ...] [target ...]
#   --seconds N     run each target for N seconds (default 60)
#   --runs N        run each target for N executions instead
#   --seed N        begin the fuzzer's random numbers with N (default 0: another one each time)
#   --workers N     processes of each target at the same time (default 1); several targets
#                   run at the same time while these are no more than PCL_EXT_JOBS (2)
#   --build FOLDER  where to build (default build-fuzz)
#   --coverage      afterwards: lines of the codec and of src/filters that the inputs reach,
#                   with a build of its own in FOLDER-coverage
#   --valgrind      afterwards: the inputs and the golden streams under valgrind, with a
#                   build of its own in FOLDER-valgrind
#   --inputs N      so many inputs of each target under valgrind (default 200)
# Inputs that are worth keeping stay in FOLDER/corpus, failing ones in FOLDER/failures.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
cd "$root"
seconds=60 runs=-1 seed=0 workers=1 build=build-fuzz coverage=no valgrind=no inputs=200
targets=()
while [ $# -gt 0 ]; do
  case $1 in
    --seconds | --runs | --seed | --workers | --build | --inputs)
      [ $# -ge 2 ] || { echo "run.sh: $1 needs a value" >&2; exit 2; }
      declare "${1#--}=$2"
      shift ;;
    --coverage) coverage=yes ;;
    --valgrind) valgrind=yes ;;
    -*) echo "run.sh: no option '$1'" >&2; exit 2 ;;
    *) targets+=("$1") ;;
  esac
  shift
done
[ "$runs" -lt 0 ] || seconds=0
[ ${#targets[@]} -gt 0 ] ||
  targets=(cloud_layouts decode_any_bytes frames recordings round_trip sequences)
tools/install_packages.sh build check fuzz
export CMAKE_CXX_COMPILER_LAUNCHER=ccache
# Files named on the command line that ccache would not hash.
export CCACHE_EXTRAFILES=$root/test/fuzz/uninstrumented.txt:$root/test/fuzz/uncovered.txt

configure_and_build() {
  local folder=$1
  shift
  cmake -S . -B "$folder" -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo \
    -DPCL_EXT_BUILD_EXAMPLES=OFF -DPCL_EXT_BUILD_BENCHMARKS=OFF "$@" > /dev/null
  cmake --build "$folder" -j "${PCL_EXT_JOBS:-2}" \
    --target fuzz_targets write_fuzz_seeds > "$folder/build.log" ||
    { tail -n 40 "$folder/build.log"; exit 1; }
}

# The library's instances of templates take a sixth of the time to compile; nothing here uses them.
configure_and_build "$build" -DCMAKE_CXX_COMPILER=clang++ -DPCL_EXT_FUZZ=ON -DPCL_EXT_UNITY_BUILD=ON \
  -DCMAKE_CXX_FLAGS_RELWITHDEBINFO="-O2 -g1 -DNDEBUG" \
  -DCMAKE_CXX_FLAGS="-DPCL_EXT_NO_INSTANCES -D_GLIBCXX_ASSERTIONS -fsanitize=address,undefined,fuzzer-no-link -fno-sanitize-recover=all"
mkdir -p "$build/corpus" "$build/failures" "$build/logs"
"$build/test/fuzz/write_fuzz_seeds" test/data "$build/seeds"

# Long inputs take long and are hardly worth more; those of streams hold a few frames.
longest_input() {
  case $1 in
    frames | decode_any_bytes) echo 1024 ;;
    recordings) echo 4096 ;;
    *) echo 256 ;;
  esac
}

run_target() {
  local target=$1 log=$build/logs/$1 options worker pids=() failed=0
  mkdir -p "$build/corpus/$target"
  options=(-max_len="$(longest_input "$target")" -runs="$runs" -seed="$seed" -max_total_time="$seconds"
    -timeout=10 -entropic=0 -reload=10 -print_final_stats=1
    -artifact_prefix="$build/failures/$target-")
  [ "$target" != decode_any_bytes ] || options+=(-dict=test/fuzz/frames.dict)
  local known=test/data/$target
  [ -d "$known" ] || known=
  for ((worker = 0; worker < workers; ++worker)); do
    "$build/test/fuzz/fuzz_$target" "${options[@]}" "$build/corpus/$target" \
      "$build/seeds/$target" $known > "$log.$worker" 2>&1 &
    pids+=($!)
  done
  for worker in "${!pids[@]}"; do
    wait "${pids[$worker]}" || { failed=1; tail -n 40 "$log.$worker"; }
  done
  cat "$log".[0-9]* | awk -v target="$target" '
    /^stat::number_of_executed_units:/ { runs += $2 }
    /^stat::average_exec_per_sec:/ { rate += $2 }
    / cov: / { for (i = 1; i < NF; ++i) {
                 if ($i == "cov:" && $(i + 1) > cov) cov = $(i + 1)
                 if ($i == "ft:" && $(i + 1) > features) features = $(i + 1) } }
    END { printf "%-18s %12d %10d %8d %9d\n", target, runs, rate, cov, features }'
  [ "$failed" -eq 0 ] || { echo "run.sh: $target failed; see $build/failures" >&2; exit 1; }
}

printf '%-18s %12s %10s %8s %9s\n' target executions exec/s cov features
# Ends what still runs if one has failed.
wait_for_one() { wait -n || { kill $(jobs -rp) 2> /dev/null || true; exit 1; }; }
for target in "${targets[@]}"; do
  while [ $(($(jobs -rp | wc -l) * workers + workers)) -gt "${PCL_EXT_JOBS:-2}" ] &&
    [ -n "$(jobs -rp)" ]; do wait_for_one; done
  rm -f "$build/logs/$target".[0-9]*
  run_target "$target" &
done
while [ -n "$(jobs -p)" ]; do wait_for_one; done

if [ "$coverage" = yes ]; then
  echo
  echo "Lines reached by the inputs of each target, and of all"
  folder=$build-coverage
  configure_and_build "$folder" -DCMAKE_CXX_COMPILER=clang++ \
    -DCMAKE_CXX_FLAGS="-O1 -fprofile-instr-generate -fcoverage-mapping"
  # Functions that targets have of one name and differ in, as main, are not ours to count.
  report() {
    local name=$1
    shift
    llvm-cov export -format=lcov -summary-only "$@" 2> /dev/null | awk -v name="$name" '
      /^SF:/ { folder = /src\/filters\// ? "filters" : /src\/(nodes|octree)\// ? "" : /\/src\// ? "codec" : "" }
      /^LF:/ { lines[folder] += substr($0, 4) }
      /^LH:/ { reached[folder] += substr($0, 4) }
      function share(folder) {
        return sprintf("%d of %d (%.1f %%)", reached[folder], lines[folder],
                       lines[folder] ? 100 * reached[folder] / lines[folder] : 0) }
      END { printf "%-18s %-24s %s\n", name, share("codec"), share("filters") }'
  }
  printf '%-18s %-24s %s\n' target codec src/filters
  objects=()
  rm -f "$folder"/*.profraw
  for target in "${targets[@]}"; do
    program=$folder/test/fuzz/fuzz_$target
    LLVM_PROFILE_FILE=$folder/$target.profraw \
      "$program" --random=0 "$build/corpus/$target" "$build/seeds/$target" > /dev/null
    llvm-profdata merge -sparse "$folder/$target.profraw" -o "$folder/$target.profdata"
    report "$target" -instr-profile="$folder/$target.profdata" "$program"
    objects+=(-object "$program")
  done
  llvm-profdata merge -sparse "$folder"/*.profraw -o "$folder/all.profdata"
  report all -instr-profile="$folder/all.profdata" "${objects[@]:1}"
  llvm-cov show -format=html -output-dir="$folder/html" \
    -instr-profile="$folder/all.profdata" "${objects[@]:1}" > /dev/null 2>&1
  echo "line by line: $folder/html/index.html"
fi

if [ "$valgrind" = yes ]; then
  echo
  echo "Under valgrind"
  folder=$build-valgrind
  # MemorySanitizer would need a standard library that is instrumented, too. valgrind has
  # no AVX-512; nothing here uses it.
  configure_and_build "$folder" -DCMAKE_CXX_COMPILER=g++ \
    -DCMAKE_CXX_FLAGS_RELWITHDEBINFO="-O1 -g -DNDEBUG"
  for target in "${targets[@]}"; do
    # Spread over all there are.
    mapfile -t files < <(find "$build/corpus/$target" "$build/seeds/$target" -type f |
      sort | awk -v most="$inputs" '{ file[NR] = $0 }
        END { step = NR > most ? NR / most : 1
              for (i = 1; i <= NR; i += step) print file[int(i)] }')
    case $target in
      frames | decode_any_bytes) files+=(test/data/golden/*.pcxi test/data/invalid/*.pcxi) ;;
    esac
    valgrind --quiet --error-exitcode=1 --leak-check=full --errors-for-leak-kinds=definite \
      "$folder/test/fuzz/fuzz_$target" --random=0 "${files[@]}" \
      > "$folder/$target.log" 2>&1 || { tail -n 40 "$folder/$target.log"; exit 1; }
    printf '%-18s %s\n' "$target" "$(tail -n 1 "$folder/$target.log")"
  done
fi

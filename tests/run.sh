#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Installs what is missing (Debian, Ubuntu), builds and runs all tests. Arguments go to ctest.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

.ci/packages g++ cmake make libeigen3-dev libboost-dev catch2 -- libhdf5-dev gnuplot-nox

build=build/tests
jobs=${JOBS:-$(nproc)}
cmake -S . -B $build -DCMAKE_BUILD_TYPE=Release -DJAMPACK_BUILD_EXAMPLES=OFF -DJAMPACK_BUILD_BENCH=OFF \
  -DJAMPACK_WERROR="${CI:-OFF}"
cmake --build $build --parallel "$jobs" --target all all_verify_interface_header_sets
ctest --test-dir $build --parallel "$jobs" --output-on-failure --no-tests=error "$@"
echo "all tests passed"

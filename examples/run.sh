#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Installs what is missing (Debian, Ubuntu), builds the programs and presses twenty soft spheres from loose
# to a packing fraction of 0.90.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

.ci/packages g++ cmake make libeigen3-dev libboost-dev -- gnuplot-nox libhdf5-dev

build=build/examples
out=$build/compaction
jobs=${JOBS:-$(nproc)}
cmake -S . -B $build -DCMAKE_BUILD_TYPE=Release -DJAMPACK_BUILD_TESTS=OFF -DJAMPACK_BUILD_BENCH=OFF
cmake --build $build --parallel "$jobs"
$build/examples/compact_spheres --grains 20 --cells 808 --until 0.90 --threads "$jobs" --out $out

echo "curve:    $PWD/$out/curve.csv"
echo "packing:  $PWD/$out/packing.pvd (ParaView)"
for picture in $out/*.png; do
  [ -e "$picture" ] && echo "picture:  $PWD/$picture"
done
exit 0

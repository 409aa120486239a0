#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Installs what is missing (Debian, Ubuntu), builds the programs and presses ten soft disks and twenty soft
# spheres from loose to a packing fraction of 0.90 (docs/results/compaction.md says what works beyond).
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

.ci/packages g++ cmake make libeigen3-dev libboost-dev -- gnuplot-nox libhdf5-dev

build=build/examples
out=$build/compaction
jobs=${JOBS:-$(nproc)}
cmake -S . -B $build -DCMAKE_BUILD_TYPE=Release -DJAMPACK_BUILD_TESTS=OFF -DJAMPACK_BUILD_BENCH=OFF
cmake --build $build --parallel "$jobs"
$build/examples/compact_disks --grains 10 --cells 100 --until 0.90 --every 0.01 --threads "$jobs" --out $out/disks
$build/examples/compact_spheres --grains 20 --cells 800 --until 0.90 --every 0.02 --threads "$jobs" --out $out/spheres

for folder in $out/disks $out/spheres; do
  echo "curve:    $PWD/$folder/curve.csv"
  echo "packing:  $PWD/$folder/packing.pvd (ParaView)"
  for picture in "$folder"/*.png; do
    [ -e "$picture" ] && echo "picture:  $PWD/$picture"
  done
done
exit 0

#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# build.sh <folder> : builds the consumer in `folder` with pkg-config and no build system, and runs
# it. CXX and CXXFLAGS as usual.
set -eu
source=$(cd "$(dirname "$0")" && pwd)
mkdir -p "$1"
cd "$1"

# embed <shader> <name of its words> [-D...]
embed() {
    shader=$1
    words=$2
    shift 2
    glslangValidator --quiet -V --target-env vulkan1.3 "$@" -I"$source/shaders" \
        -I"$(pkg-config --variable=shadersdir ockham)" --vn "$words" -o "$words.h" \
        "$source/shaders/consumer/$shader"
}
embed triangle.vert triangle_vert
embed triangle.frag triangle_frag
embed tint.comp tint_comp
embed tint.comp tint_comp_inverted -DINVERTED=1

# The libraries come after what uses them.
# shellcheck disable=SC2046,SC2086
${CXX:-g++} -std=c++20 ${CXXFLAGS:-} -I. -I"$source/shaders" "$source/main.cpp" \
    "$source/embedded_shaders.cpp" $(pkg-config --cflags --libs --static ockham) -o consumer
./consumer

# SPDX-License-Identifier: Apache-2.0
# The Debian 12 packages that building, testing and the demo need; the only list of them. What
# fetches this repository and runs these scripts comes first: apt-get install cmake git
set(OCKHAM_PACKAGES
  # tools
  g++ ninja-build pkg-config glslang-tools
  # libraries
  glslang-dev libcli11-dev libfmt-dev libglm-dev libopenexr-dev libspirv-cross-c-shared-dev
  libstb-dev libtinygltf-dev libvulkan-dev nlohmann-json3-dev zlib1g-dev
  # volumes, each optional: medical formats; .vdb, which wants Boost's headers; .nvdb
  libinsighttoolkit5-dev libopenvdb-dev libboost-dev libnanovdb-dev
  # a Vulkan device in software, used where there is no other
  mesa-vulkan-drivers
  # tests
  libbenchmark-dev libgtest-dev vulkan-validationlayers)

# SPDX-License-Identifier: Apache-2.0
# The Debian 12 packages that building, testing and the demo need; the only list of them. What
# fetches this repository and runs these scripts comes first: apt-get install cmake git
# Programs that link the framework need these as well:
set(OCKHAM_LIBRARY_PACKAGES
  glslang-dev libcli11-dev libfmt-dev libglm-dev libopenexr-dev libspirv-cross-c-shared-dev
  libstb-dev libtinygltf-dev libvulkan-dev nlohmann-json3-dev zlib1g-dev)
# Volumes, each optional: medical formats; .vdb, which wants Boost's headers; .nvdb.
set(OCKHAM_ITK_PACKAGES libinsighttoolkit5-dev)
set(OCKHAM_OPENVDB_PACKAGES libopenvdb-dev libboost-dev)
set(OCKHAM_NANOVDB_PACKAGES libnanovdb-dev)

set(OCKHAM_PACKAGES
  # tools
  g++ ninja-build pkg-config glslang-tools
  # libraries
  ${OCKHAM_LIBRARY_PACKAGES} ${OCKHAM_ITK_PACKAGES} ${OCKHAM_OPENVDB_PACKAGES} ${OCKHAM_NANOVDB_PACKAGES}
  # a Vulkan device in software, used where there is no other
  mesa-vulkan-drivers
  # the viewer, optional: window, widgets, a font
  libglfw3-dev libimgui-dev fonts-dejavu-core
  # charts, and metrics in ONNX files, optional
  gnuplot-nox libopencv-dnn-dev
  # tests, those of the viewer in a virtual screen
  doxygen xdotool xvfb libbenchmark-dev libgtest-dev vulkan-validationlayers)

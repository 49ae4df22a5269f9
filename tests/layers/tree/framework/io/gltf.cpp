// SPDX-License-Identifier: Apache-2.0
#include "framework/scene_gpu/scene_gpu.hpp" // wrong

#include <OpenEXR/ImfHeader.h> // wrong
#include <stb/stb_image.h>
#include <tiny_gltf.h>

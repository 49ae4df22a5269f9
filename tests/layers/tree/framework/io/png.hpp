// SPDX-License-Identifier: Apache-2.0
#include <stb/stb_image.h> // wrong
#include <tiny_gltf.h>     // wrong

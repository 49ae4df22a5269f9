// SPDX-License-Identifier: Apache-2.0
#include "framework/scene/iso_material.hpp"

#include "framework/core/json_object.hpp"

#include <utility>

namespace ockham {
namespace {

VolumeView::Surface read_surface(const JsonObject& object) {
    object.warn_unknown({"base_color", "opacity", "metallic", "subsurface", "specular", "roughness",
        "specular_tint", "anisotropic", "sheen", "sheen_tint", "clearcoat", "clearcoat_gloss"});
    VolumeView::Surface surface;
    shader::IsoMaterial& m = surface.material;
    if (object.has("base_color")) {
        const auto c = object.numbers<3>("base_color", 0, 1, "three numbers from 0 to 1");
        m.base_color = glm::vec3(c[0], c[1], c[2]);
    }
    if (object.has("opacity")) {
        surface.opacity =
            static_cast<float>(object.number("opacity", 1e-6, 1, "a number above 0, at most 1"));
    }
    using Entry = std::pair<const char*, float*>;
    for (const auto& [key, value] :
        {Entry{"metallic", &m.metallic}, {"subsurface", &m.subsurface}, {"specular", &m.specular},
            {"roughness", &m.roughness}, {"specular_tint", &m.specular_tint},
            {"anisotropic", &m.anisotropic}, {"sheen", &m.sheen}, {"sheen_tint", &m.sheen_tint},
            {"clearcoat", &m.clearcoat}, {"clearcoat_gloss", &m.clearcoat_gloss}}) {
        if (object.has(key))
            *value = static_cast<float>(object.number(key, 0, 1, "a number from 0 to 1"));
    }
    return surface;
}

} // namespace

std::vector<VolumeView::Surface> load_iso_materials(const std::filesystem::path& path) {
    const nlohmann::json json = parse_json(path, "iso material");
    const JsonObject root(json, "iso material", path.string());
    if (!root.has("surfaces")) return {read_surface(root)};
    root.warn_unknown({"surfaces"});
    std::vector<VolumeView::Surface> surfaces;
    for (const JsonObject& object : root.objects("surfaces"))
        surfaces.push_back(read_surface(object));
    if (surfaces.empty()) root.refuse("surfaces", "an array of at least one material");
    return surfaces;
}

} // namespace ockham

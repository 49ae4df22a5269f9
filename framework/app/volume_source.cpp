// SPDX-License-Identifier: Apache-2.0
#include "framework/app/volume_source.hpp"

#include "framework/core/error.hpp"
#include "framework/core/file.hpp"
#include "framework/core/log.hpp"
#include "framework/graph/fingerprint.hpp"
#include "framework/io/image_file.hpp"
#include "framework/io/volume_file.hpp"
#include "framework/scene/iso_material.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <sstream>

namespace ockham {
namespace {

constexpr std::array<const char*, 4> kPresets{"ct-bone", "ct-soft", "mri", "smoke"};

/// Exactly `count` numbers, or Error(input).
std::vector<float> numbers(
    const char* flag, const std::string& text, std::size_t count, const char* expected) {
    std::vector<float> found = parse_numbers(text);
    if (found.size() != count) fail_input("--{}: found '{}', expected {}", flag, text, expected);
    return found;
}

std::string text_of(glm::dvec3 v, const char* separator) {
    return fmt::format("{:.4g}{}{:.4g}{}{:.4g}", v.x, separator, v.y, separator, v.z);
}

void log_volume(const Volume& volume) {
    const auto [low, high] = value_range(volume);
    log::info("{}: {} x {} x {} {}, {} mm apart, values {:.6g} to {:.6g}", volume.name,
        volume.dims.x, volume.dims.y, volume.dims.z, name_of(volume.type),
        text_of(volume.spacing_mm, " x "), low, high);
    for (const std::string& note : volume.notes) log::info("{}: {}", volume.name, note);
}

/// --transfer, --window, or what the values suggest.
TransferFunction choose_transfer(const VolumeOptions& o, const Volume& volume) {
    if (!o.transfer.empty() && !o.window.empty()) {
        fail_input("--window and --transfer both say what values look like; give one of them");
    }
    if (!o.window.empty()) {
        const char* expected = "LEVEL,WIDTH in data units, the width above 0";
        const std::vector<float> w = numbers("window", o.window, 2, expected);
        if (!(w[1] > 0)) fail_input("--window: found '{}', expected {}", o.window, expected);
        return window_transfer(w[0], w[1]);
    }
    if (std::ranges::find(kPresets, o.transfer) != kPresets.end())
        return preset_transfer(o.transfer, volume);
    if (!o.transfer.empty()) return load_transfer(o.transfer);

    TransferFunction transfer = default_transfer(volume);
    log::info("no --transfer: opacity {:.3g} up to {:.6g}, then to {:.3g} at {:.6g}",
        transfer.points.front().opacity, transfer.points.front().value,
        transfer.points.back().opacity, transfer.points.back().value);
    return transfer;
}

void set_light(const VolumeOptions& o, VolumeSource& source) {
    VolumeView& view = source.view;
    if (o.light.empty() && o.environment.empty()) {
        // Either alone shows little: a flat shape in a white world, or black shadows.
        view.light_direction = {0.5f, 0.7f, -0.6f};
        view.light_irradiance = glm::vec3(2.0f);
        view.environment = {0.12f, 0.17f, 0.26f};
        log::info("neither --light nor --environment: lit by a sun from above the viewer's left, "
                  "and a dim sky");
        return;
    }
    view.light_irradiance = view.environment = glm::vec3(0.0f); // what is not given is dark
    if (!o.light.empty()) {
        std::istringstream words(o.light);
        std::string direction, irradiance, more;
        words >> direction >> irradiance >> more;
        const std::vector<float> d = parse_numbers(direction), e = parse_numbers(irradiance);
        if (d.size() != 3 || e.size() != 3 || !more.empty() ||
            std::ranges::any_of(e, [](float value) { return value < 0; })) {
            fail_input("--light: found '{}', expected \"dx,dy,dz r,g,b\": the direction that light "
                       "travels, and its irradiance, at least 0",
                o.light);
        }
        view.light_direction = {d[0], d[1], d[2]};
        view.light_irradiance = {e[0], e[1], e[2]};
        if (view.light_direction == glm::vec3(0.0f))
            fail_input("--light: found '{}', whose direction has no length", o.light);
    }
    if (o.environment.ends_with(".exr") || o.environment.ends_with(".EXR")) {
        source.environment = load_image(o.environment);
    } else if (!o.environment.empty()) {
        view.environment = parse_color("environment", o.environment);
    }
}

void set_cuts(const VolumeOptions& o, VolumeView& view) {
    if (!o.crop.empty()) {
        const char* expected =
            "x0,x1,y0,y1,z0,z1, from 0 to 1 over the box, the lower of two first";
        const std::vector<float> c = numbers("crop", o.crop, 6, expected);
        for (int axis = 0; axis < 3; ++axis) {
            const float low = c[static_cast<std::size_t>(2 * axis)],
                        high = c[static_cast<std::size_t>(2 * axis + 1)];
            if (!(0 <= low && low < high && high <= 1))
                fail_input("--crop: found '{}', expected {}", o.crop, expected);
            view.crop_min[axis] = low;
            view.crop_max[axis] = high;
        }
    }
    if (o.clip_planes.size() > MAX_CLIP_PLANES) {
        fail_input("--clip-plane: found {} planes, expected at most {}", o.clip_planes.size(),
            MAX_CLIP_PLANES);
    }
    for (const std::string& text : o.clip_planes) {
        const std::vector<float> p = numbers("clip-plane", text, 4,
            "nx,ny,nz,d: what has nx x + ny y + nz z + d >= 0 in the world is kept");
        view.clip_planes.emplace_back(p[0], p[1], p[2], p[3]);
        if (p[0] == 0 && p[1] == 0 && p[2] == 0)
            fail_input("--clip-plane: found '{}', whose normal has no length", text);
    }
}

void set_surfaces(const VolumeOptions& o, const Volume& volume, VolumeView& view) {
    view.shading = o.shading == "phong"    ? SHADING_PHONG
                   : o.shading == "disney" ? SHADING_DISNEY
                                           : SHADING_LAMBERT;
    view.surface_gain = o.surface_gain;
    view.volume_gain = o.volume_gain;
    if (o.iso.empty()) {
        if (!o.iso_material.empty()) fail_input("--iso-material: there is no --iso to use it for");
        return;
    }
    const std::vector<float> values = parse_numbers(o.iso);
    if (values.empty() || values.size() > MAX_SURFACES) {
        fail_input("--iso: found '{}', expected 1 to {} values in data units, as 300,1200", o.iso,
            MAX_SURFACES);
    }
    std::vector<VolumeView::Surface> looks{{}};
    if (!o.iso_material.empty()) looks = load_iso_materials(o.iso_material);
    if (looks.size() > 1 && looks.size() != values.size()) {
        fail_input("--iso-material: '{}' has {} materials, but --iso {} values; expected one, or "
                   "one for each",
            o.iso_material, looks.size(), values.size());
    }
    const auto [low, high] = value_range(volume);
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (values[i] < low || values[i] > high) {
            log::warning("--iso {:.6g}: the volume has values from {:.6g} to {:.6g}, so this "
                         "surface is not seen",
                values[i], low, high);
        }
        VolumeView::Surface surface = looks[std::min(i, looks.size() - 1)];
        surface.value = values[i];
        view.surfaces.push_back(surface);
    }
}

} // namespace

void add_volume_options(Params& params, VolumeOptions& o) {
    const char* kVolume = "Volume";
    params.add("volume", &o.volume, volume_formats() + "; default builtin:cloud")
        .positional()
        .group(kVolume);
    params
        .add("environment", &o.environment,
            "radiance from all around, \"r,g,b\", or an equirectangular .exr, zenith at +z")
        .group(kVolume);
    add_volume_flags(params, o);
}

void add_volume_flags(Params& params, VolumeOptions& o) {
    const char* kVolume = "Volume";
    const char* kSurface = "Isosurfaces";
    const auto add = [&](const char* group, const char* name, Param::Target target,
                         std::string help) -> Param& {
        return params.add(name, target, std::move(help)).group(group);
    };
    add(kVolume, "transfer", &o.transfer,
        fmt::format("what values look like: a JSON file or {}; default: from the histogram",
            fmt::join(kPresets, ", ")));
    add(kVolume, "window", &o.window,
        "LEVEL,WIDTH in data units: opacity rises from 0 to 1 over the window");
    add(kVolume, "density-scale", &o.density_scale,
        "extinction where the opacity is 1; the longest side of the box is 1")
        .range(0, 1e6)
        .unit("per world unit");
    add(kVolume, "albedo", &o.albedo, "scattering albedo, times the colour").range(0, 1);
    add(kVolume, "phase-g", &o.phase_g, "mean cosine of the Henyey-Greenstein phase function")
        .range(-0.999, 0.999);
    add(kVolume, "light", &o.light,
        "\"dx,dy,dz r,g,b\": the direction that light travels, and its irradiance");
    add(kVolume, "crop", &o.crop, "x0,x1,y0,y1,z0,z1: the part to show, 0 to 1 over the box");
    add(kVolume, "clip-plane", &o.clip_planes,
        "nx,ny,nz,d: shows what has n p + d >= 0 in world units; repeatable");
    add(kVolume, "volume-gain", &o.volume_gain, "factor of the light from the medium")
        .range(0, 1e6);
    add(kSurface, "iso", &o.iso, "V[,V...]: surfaces at these values, in data units");
    add(kSurface, "iso-material", &o.iso_material, "JSON with their materials");
    add(kSurface, "shading", &o.shading, "how surfaces reflect")
        .choices({"lambert", "phong", "disney"});
    add(kSurface, "surface-gain", &o.surface_gain, "factor of the light from surfaces")
        .range(0, 1e6);
}

namespace {

class Printer {
public:
    template <class T>
    Printer& mix(const T* values, std::size_t count) {
        print_.mix(std::string_view(reinterpret_cast<const char*>(values), count * sizeof(T)));
        return *this;
    }
    std::string text() const { return fmt::format("{:016x}{:016x}", print_.high, print_.low); }

private:
    Fingerprint print_;
};

} // namespace

nlohmann::ordered_json fingerprints_of(const VolumeSource& source) {
    const Volume& v = source.volume;
    Printer volume, transfer, environment, materials;
    volume.mix(v.voxels.data(), v.voxels.size())
        .mix(&v.dims, 1)
        .mix(&v.type, 1)
        .mix(&v.spacing_mm, 1)
        .mix(&v.direction, 1)
        .mix(&v.value_scale, 1)
        .mix(&v.value_offset, 1);
    transfer.mix(source.transfer.points.data(), source.transfer.points.size());
    environment.mix(&source.view.environment, 1);
    for (std::size_t c = 0; c < source.environment.channels().size(); ++c) {
        const std::span<const float> plane = source.environment.plane(static_cast<int>(c));
        environment.mix(plane.data(), plane.size());
    }
    for (const VolumeView::Surface& surface : source.view.surfaces)
        materials.mix(&surface.opacity, 1).mix(&surface.material, 1);
    return {{"volume", volume.text()}, {"transfer function", transfer.text()},
        {"environment", environment.text()}, {"materials", materials.text()}};
}

VolumeSource load_volume_source(const VolumeOptions& o) {
    if (o.volume.size() > 1)
        fail_input("found {} volumes ('{}', '{}' ...), expected one", o.volume.size(), o.volume[0],
            o.volume[1]);
    VolumeSource source;
    set_cuts(o, source.view); // wrong flags show before the volume is read
    source.volume = load_volume(o.volume.empty() ? "builtin:cloud" : o.volume.front());
    log_volume(source.volume);
    update_transfer(o, source);
    update_view(o, source);
    return source;
}

void update_view(const VolumeOptions& o, VolumeSource& source) {
    VolumeSource next;
    next.view.density_scale = o.density_scale;
    next.view.albedo = o.albedo;
    next.view.phase_g = o.phase_g;
    set_cuts(o, next.view);
    set_surfaces(o, source.volume, next.view);
    set_light(o, next);
    source.view = std::move(next.view);
    source.environment = std::move(next.environment);
}

void update_transfer(const VolumeOptions& o, VolumeSource& source) {
    source.transfer = choose_transfer(o, source.volume);
}

} // namespace ockham

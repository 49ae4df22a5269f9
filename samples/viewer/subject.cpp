// SPDX-License-Identifier: Apache-2.0
#include "samples/viewer/subject.hpp"

#include "framework/core/error.hpp"
#include "framework/core/file.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdlib>

namespace ockham::viewer {

Kind kind_of(const std::vector<std::string>& sources) {
    const auto scenes = std::ranges::count_if(sources, names_scene);
    if (scenes == std::ssize(sources)) return Kind::surface;
    return scenes == 0 ? Kind::volume : Kind::both;
}

Subject::Subject(Kind which) : kind(which) {
    common.width = 1280;
    common.height = 720;
    options.volume.method.cache_scale = 4; // a person waits for it
    if (kind == Kind::surface)
        declare(params, options.surface);
    else if (kind == Kind::volume)
        declare(params, options.volume);
    else
        declare(params, options);
    add_view_flags(params, common);
    const char* kPicture = "Picture";
    params.add("exposure", &common.exposure, "exposure of what is shown, and of .png files")
        .range(-32, 32)
        .unit("stops")
        .group(kPicture);
    params.add("tonemap", &common.tonemap, "tone curve of what is shown, and of .png files")
        .choices({"none", "aces"})
        .group(kPicture);
    const char* kReport = "Reports";
    params.add("output", &common.output, "picture to write when the window closes: .exr or .png")
        .letter('o')
        .group(kReport)
        .transient();
    params.add("screenshot", &screenshot, ".png of the whole window, written when it closes")
        .group(kReport)
        .transient();
    params
        .add("reference", &common.reference,
            "picture (.exr or .png) to compare with; it may have another size")
        .group(kReport)
        .transient();
    params.add("frames", &frames, "close after so many steps of the whole picture; 0: by the user")
        .range(0, 1000000)
        .group("Run")
        .transient();
    params
        .add("orbit", &orbit,
            "turn the camera as a drag does for so many frames, print how many a second, and close")
        .range(0, 1000000)
        .group("Run")
        .transient();
    add_run_flags(params, common);
}

void Subject::open(gpu::Device& device) {
    technique.reset();
    if (kind == Kind::surface)
        technique = std::make_unique<SurfaceTechnique>(device, common, options.surface);
    else if (kind == Kind::volume)
        technique = std::make_unique<VolumeTechnique>(device, common, options.volume);
    else
        technique = std::make_unique<SurfaceVolumeTechnique>(device, common, options);
}

void Subject::set_sources(const std::vector<std::string>& sources) {
    (kind == Kind::surface     ? options.surface.scene.scenes
        : kind == Kind::volume ? options.volume.volume.volume
                               : options.world.inputs) = sources;
    common.camera.clear();
}

std::vector<std::string> positionals(int argc, char** argv) {
    const Subject all(Kind::both); // has the flags of all kinds
    std::vector<std::string> words;
    for (int i = 1; i < argc; ++i) {
        const std::string word = argv[i];
        const Param* param = word.starts_with("--") ? all.params.find(word.substr(2)) : nullptr;
        if (word == "-o" || (param && !param->is_flag()))
            ++i;
        else if (!word.starts_with("-"))
            words.push_back(word);
    }
    return words;
}

Kind kind_of_command(int argc, char** argv) {
    const std::vector<std::string> sources = positionals(argc, argv);
    if (!sources.empty()) return kind_of(sources);
    for (int i = 1; i < argc; ++i) {
        const std::string word = argv[i], flag = "--config";
        std::string file;
        if (word == flag && i + 1 < argc) file = argv[i + 1];
        if (word.starts_with(flag + "=")) file = word.substr(flag.size() + 1);
        if (file.empty()) continue;
        const nlohmann::json json = nlohmann::json::parse(read_text(file), nullptr, false);
        if (!json.is_object()) continue; // whoever reads it says so
        if (json.contains("input")) return Kind::both;
        if (json.contains("volume")) return Kind::volume;
    }
    return Kind::surface;
}

void save_run_file(const std::filesystem::path& path, Subject& subject, const std::string& camera,
    glm::ivec2 size) {
    nlohmann::json json = subject.params.to_json();
    json["camera"] = camera;
    json["width"] = size.x;
    json["height"] = size.y;
    if (subject.drawn) {
        const std::filesystem::path file =
            std::filesystem::absolute(path).replace_extension("").string() + "_transfer.json";
        save_transfer(file, *subject.drawn);
        json["transfer"] = file.string();
        json["window"] = "";
    }
    write_text(path, json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
}

void save_transfer(const std::filesystem::path& path, const TransferFunction& transfer) {
    nlohmann::ordered_json points = nlohmann::ordered_json::array();
    const auto list = [](glm::dvec3 v) { return nlohmann::ordered_json{v.x, v.y, v.z}; };
    for (const TransferPoint& point : transfer.points)
        points.push_back({{"value", point.value}, {"opacity", point.opacity},
            {"color", list(point.color)}, {"emission", list(point.emission)}});
    write_text(path, nlohmann::ordered_json{{"points", points}}.dump(2) + "\n");
}

std::filesystem::path session_path() {
    if (const char* config = std::getenv("XDG_CONFIG_HOME"); config && *config == '/')
        return std::filesystem::path(config) / "ockham" / "viewer.json";
    if (const char* home = std::getenv("HOME"); home && *home == '/')
        return std::filesystem::path(home) / ".config" / "ockham" / "viewer.json";
    return {};
}

} // namespace ockham::viewer

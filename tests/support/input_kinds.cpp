// SPDX-License-Identifier: Apache-2.0
#include "tests/support/input_kinds.hpp"

#include "framework/app/camera_path.hpp"
#include "framework/app/checkpoint.hpp"
#include "framework/app/cli.hpp"
#include "framework/app/volume_source.hpp"
#include "framework/core/error.hpp"
#include "framework/core/file.hpp"
#include "framework/core/json_object.hpp"
#include "framework/graph/compile.hpp"
#include "framework/graph/explain/dump.hpp"
#include "framework/graph/explain/plan_file.hpp"
#include "framework/graph/graph.hpp"
#include "framework/io/dicom_check.hpp"
#include "framework/io/gltf.hpp"
#include "framework/io/image_file.hpp"
#include "framework/io/rig.hpp"
#include "framework/io/volume_file.hpp"
#include "framework/io/volume_payload.hpp"
#include "framework/scene/iso_material.hpp"
#include "framework/scene/transfer_function.hpp"
#include "tests/support/volume_bytes.hpp"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfOutputFile.h>
#include <unistd.h>
#include <zlib.h>

#include <fstream>

namespace ockham::test {
namespace {

namespace fs = std::filesystem;

/// Bytes of what `write` writes to a path that ends in `name`.
template <class Write>
std::string bytes_of_file(const std::string& name, Write write) {
    const fs::path folder = fs::temp_directory_path() / fmt::format("ockham_inputs.{}", ::getpid());
    fs::create_directories(folder);
    write(folder / name);
    std::string bytes = read_text(folder / name);
    fs::remove_all(folder);
    return bytes;
}

/// Two triangles with everything that the reader knows, and what it leaves alone.
const char* const kGltf = R"({
    "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
    "extensionsUsed": ["KHR_lights_punctual", "KHR_texture_transform", "KHR_materials_ior"],
    "extensions": {"KHR_lights_punctual": {"lights": [
        {"type": "spot", "color": [1, 1, 1], "range": 3, "spot": {"innerConeAngle": 0.1}}]}},
    "nodes": [{"mesh": 0, "translation": [1, 2, 3], "children": [2]},
        {"camera": 0, "rotation": [0, 0, 0, 1], "extensions": {"KHR_lights_punctual": {"light": 0}}},
        {"camera": 1, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}],
    "cameras": [{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}},
        {"type": "orthographic", "orthographic": {"xmag": 3, "ymag": 2, "zfar": 9, "znear": 1}}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1, "NORMAL": 3},
        "indices": 2, "material": 0, "mode": 4}]}],
    "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "extensions":
        {"KHR_texture_transform": {"offset": [1, 2], "rotation": 1, "texCoord": 0}}}},
        "alphaMode": "MASK", "extensions": {"KHR_materials_ior": {"ior": 1.4}}}],
    "textures": [{"source": 0, "sampler": 0}], "samplers": [{"wrapS": 33071}],
    "images": [{"uri": "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAIAAAABCAYAAAD0In+KAAAAEUlEQVR4nGP4z8Dwn0tErgEADhwCu4IAMPwAAAAASUVORK5CYII="}],
    "skins": [{"joints": [0, 2]}],
    "animations": [{"samplers": [{"input": 4, "output": 5}],
        "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}]}],
    "accessors": [
        {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [2, 2, 0]},
        {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
        {"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"},
        {"componentType": 5126, "count": 4, "type": "VEC3", "sparse": {"count": 2,
            "indices": {"bufferView": 2, "componentType": 5123}, "values": {"bufferView": 0}}},
        {"componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1]},
        {"componentType": 5126, "count": 2, "type": "VEC3"}],
    "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 32},
        {"buffer": 0, "byteOffset": 80, "byteLength": 12}],
    "buffers": [{"byteLength": 92, "uri": "quad.bin"}]})";

std::string quad_bytes() {
    const float numbers[] = {0, 0, 0, 2, 0, 0, 2, 2, 0, 0, 2, 0, 0, 1, 1, 1, 1, 0, 0, 0};
    const std::uint16_t indices[] = {0, 1, 2, 0, 2, 3};
    return std::string(reinterpret_cast<const char*>(numbers), sizeof numbers) +
           std::string(reinterpret_cast<const char*>(indices), sizeof indices);
}

std::string u32(std::size_t value) { return ramp(1, static_cast<std::uint32_t>(value)); }

std::string glb() {
    nlohmann::json root = nlohmann::json::parse(kGltf);
    root["buffers"][0].erase("uri");
    std::string json = root.dump();
    json.resize((json.size() + 3) / 4 * 4, ' ');
    const std::string chunks = u32(json.size()) + "JSON" + json + u32(quad_bytes().size()) +
                               std::string("BIN\0", 4) + quad_bytes();
    return "glTF" + u32(2) + u32(12 + chunks.size()) + chunks;
}

Image small_picture() {
    Image image(9, 5, {"R", "G", "B"});
    for (int c = 0; c < 3; ++c)
        for (std::size_t i = 0; i < image.pixels(); ++i)
            image.plane(c)[i] = 0.02f * static_cast<float>(i) + 0.1f * static_cast<float>(c);
    image.metadata["ockham.command"] = "a test";
    return image;
}

std::string exr(Imf::Compression method) {
    const Image image = small_picture();
    return bytes_of_file("a.exr", [&](const fs::path& path) {
        Imf::Header header(image.width(), image.height());
        header.compression() = method;
        Imf::FrameBuffer frame;
        for (const char* name : {"B", "G", "R"}) {
            header.channels().insert(name, Imf::Channel(Imf::FLOAT));
            frame.insert(
                name, Imf::Slice(Imf::FLOAT,
                          reinterpret_cast<char*>(const_cast<float*>(image.plane(name).data())),
                          sizeof(float), sizeof(float) * image.width()));
        }
        Imf::OutputFile file(path.c_str(), header);
        file.setFrameBuffer(frame);
        file.writePixels(image.height());
    });
}

/// The checksums of a PNG's chunks.
std::string with_checksums(const std::string& png) {
    std::string result = png;
    for (std::size_t at = 8; at + 12 <= result.size();) {
        std::uint32_t length = 0;
        for (std::size_t i = 0; i < 4; ++i)
            length = length << 8 | static_cast<std::uint8_t>(result[at + i]);
        if (length > result.size() - at - 12) break;
        const auto sum = static_cast<std::uint32_t>(
            ::crc32(0, reinterpret_cast<const Bytef*>(result.data() + at + 4), length + 4));
        for (std::size_t i = 0; i < 4; ++i)
            result[at + 8 + length + i] = static_cast<char>(sum >> 8 * (3 - i));
        at += 12 + length;
    }
    return result;
}

const nlohmann::ordered_json kIdentity{{"program", "test"}, {"seed", 1}};

std::string checkpoint() {
    Checkpoint checkpoint{kIdentity, {{"frame", 0}, {"steps", 7}}, {}};
    checkpoint.resources.push_back({"sum", std::vector<std::byte>(64, std::byte{7})});
    checkpoint.resources.push_back({"cache", std::vector<std::byte>(9, std::byte{1})});
    return bytes_of_file("c", [&](const fs::path& path) { save_checkpoint(path, checkpoint); });
}

std::string plan_file() {
    Graph graph("small");
    ImageHandle picture = graph.create_image("picture", {VK_FORMAT_R8G8B8A8_UNORM, 8, 8, 1, 2, 1});
    BufferHandle counts = graph.create_persistent_buffer("counts", {1024});
    const Condition fog = graph.add_condition("fog");
    auto march = graph.add_compute_pass("march");
    picture = march.write("picture", picture);
    counts = march.read_write("counts", counts.range(256, 512));
    march.prefer(QueueWish::async_compute);
    {
        const GuardScope guard = graph.when(fog);
        graph.add_compute_pass("blur").read("picture", picture);
    }
    graph.export_resource(counts, "shown");
    return plan_json(graph.declaration(), compile(graph.declaration())).dump();
}

void load_run_file(const fs::path& path) {
    Params params;
    CommonOptions common;
    VolumeOptions volume;
    add_run_flags(params, common);
    add_view_flags(params, common);
    add_output_flags(params, common);
    add_volume_options(params, volume);
    std::string program = "test", flag = "--config", file = path.string();
    char* arguments[] = {program.data(), flag.data(), file.data(), nullptr};
    parse_command_line(3, arguments, "", params, common);
}

void load_any_volume(const fs::path& path) { load_volume(path.string()); }

void load_both_ways(const fs::path& path) {
    for (const bool strict : {true, false}) {
        try {
            load_gltf(path, {.strict = strict});
        } catch (const Error&) {
            if (!strict) throw;
        }
    }
}

void add_volumes(std::vector<InputKind>& kinds) {
    const std::string raw = ramp<std::int16_t>(24, -5);
    const std::string sidecar =
        R"({"file": "a.raw", "dims": [2, 3, 4], "type": "int16", "spacing_mm": [1, 1, 2],
            "direction": [1, 0, 0, 0, 1, 0, 0, 0, 1], "origin_mm": [0, 0, 0]})";
    kinds.push_back({"sidecar", "a.json", {sidecar}, {{"a.raw", raw}}, load_any_volume});
    const std::string packed =
        R"({"file": "a.raw.gz", "dims": [2, 3, 4], "type": "int16", "spacing_mm": [1, 1, 2]})";
    kinds.push_back({"raw_gz", "a.raw.gz", {gzip(raw)}, {{"a.json", packed}},
        [](const fs::path& path) { load_any_volume(path.parent_path() / "a.json"); }});
#if OCKHAM_WITH_ITK
    const std::string zlib = gzip(raw, 15);
    const Fields text{{"encoding", "ascii"}}, gz{{"encoding", "gzip"}};
    kinds.push_back({"nrrd", "a.nrrd",
        {nrrd(), nrrd(gz, gzip(raw)),
            nrrd(text, "1 2 3 4 5 6 7 8 9 10 11 12 1 2 3 4 5 6 7 8 9 0 1 2")},
        {}, load_any_volume});
    kinds.push_back({"nhdr", "a.nhdr", {nrrd({{"data file", "a.raw"}}, "")}, {{"a.raw", raw}},
        load_any_volume});
    kinds.push_back({"nifti", "a.nii", {nifti(), nifti(2, 1)}, {}, load_any_volume});
    kinds.push_back({"nifti_gz", "a.nii.gz", {nifti()}, {}, load_any_volume,
        [](const std::string& bytes) { return gzip(bytes); }});
    const Fields compressed{
        {"CompressedData", "True"}, {"CompressedDataSize", std::to_string(zlib.size())}};
    kinds.push_back({"meta", "a.mha", {meta(), meta(compressed, zlib)}, {}, load_any_volume});
    kinds.push_back({"meta_header", "a.mhd", {meta({{"ElementDataFile", "a.raw"}}, "")},
        {{"a.raw", raw}}, load_any_volume});
    kinds.push_back({"dicom", "a.dcm", {dicom({})}, {}, load_any_volume});
#endif
}

void add_pictures(std::vector<InputKind>& kinds) {
    const auto load = [](const fs::path& path) { load_image(path); };
    kinds.push_back({"exr", "a.exr",
        {exr(Imf::ZIP_COMPRESSION), exr(Imf::NO_COMPRESSION), exr(Imf::RLE_COMPRESSION),
            exr(Imf::PIZ_COMPRESSION), exr(Imf::PXR24_COMPRESSION), exr(Imf::B44_COMPRESSION),
            exr(Imf::DWAA_COMPRESSION)},
        {}, load});
    kinds.push_back({"png", "a.png",
        {bytes_of_file("a.png", [](const fs::path& path) { save_image(path, small_picture()); })},
        {}, load, with_checksums});
}

void add_configurations(std::vector<InputKind>& kinds) {
    kinds.push_back({"transfer", "a.json",
        {R"({"domain": [-1000, 2000], "points": [{"value": 150, "opacity": 0},
            {"value": 700, "opacity": 0.8, "color": [0.93, 0.86, 0.74]},
            {"value": 1500, "opacity": 1, "color": [1, 1, 1], "emission": [0, 0, 0]}]})"},
        {}, [](const fs::path& path) { load_transfer(path); }});
    kinds.push_back({"material", "a.json",
        {R"({"surfaces": [{"base_color": [0.8, 0.45, 0.36], "opacity": 0.3, "roughness": 0.4},
            {"base_color": [0.9, 0.8, 0.7], "clearcoat": 0.2, "sheen": 0.1}]})",
            R"({"metallic": 1, "anisotropic": 0.5})"},
        {}, [](const fs::path& path) { load_iso_materials(path); }});
    kinds.push_back({"rig", "a.json",
        {R"({"camera": {"position": [-11.5, 2.6, 0.35], "target": [8, 4.2, -0.6], "fov_y_degrees": 65},
            "background": [0.35, 0.55, 0.9], "ambient": [0.1, 0.115, 0.14],
            "sun": {"toward": [0.25, 1, -0.18], "irradiance": [6.5, 6, 5.2], "shadow": true},
            "points": [{"position": [1, 1, 5], "intensity": [1, 1, 1], "range": 6}]})"},
        {}, [](const fs::path& path) { load_rig(path); }});
    kinds.push_back({"camera_path", "a.json",
        {R"({"keys": [{"camera": "0,-2.6,0 0,0,0 30"}, {"camera": "1.8,-1.8,0.6 0,0,0 30"}]})"}, {},
        [](const fs::path& path) { load_camera_path(path, 5, UpAxis::z); }});
    kinds.push_back({"run_file", "a.json",
        {R"({"width": 64, "height": 48, "camera": "0,-2.6,0 0,0,0 30", "validation": "core",
            "quiet": true, "volume": ["builtin:cloud"], "albedo": 0.9, "clip-plane": ["0,0,1,0"]})"},
        {}, load_run_file});
    kinds.push_back({"checkpoint", "a.checkpoint", {checkpoint()}, {},
        [](const fs::path& path) { load_checkpoint(path, kIdentity); }});
    kinds.push_back({"plan_file", "a.json", {plan_file()}, {}, [](const fs::path& path) {
                         const PlanFile file = load_plan_file(parse_json(path, "plan file"));
                         compile(file.declaration, file.capabilities, file.policy);
                     }});
}

} // namespace

void InputKind::write_beside(const fs::path& folder) const {
    for (const auto& [other, bytes] : beside) {
        std::ofstream(folder / other, std::ios::binary) << bytes;
    }
}

std::vector<InputKind> volume_check_kinds() {
    const std::string raw = ramp<std::int16_t>(24, -5), zlib = gzip(raw, 15);
    const auto payload = [](const fs::path& path) {
        std::vector<std::string> notes;
        check_references(path);
        check_payload(path, {24, 48, "voxels"}, notes);
    };
    const auto dicom_walk = [](const fs::path& path) {
        if (is_dicom(path)) check_dicom(path);
    };
    const Fields gz{{"encoding", "gzip"}},
        compressed{{"CompressedData", "True"}, {"CompressedDataSize", std::to_string(zlib.size())}};
    return {{"check_nrrd", "a.nrrd", {nrrd(), nrrd(gz, gzip(raw))}, {}, payload},
        {"check_meta", "a.mha", {meta(), meta(compressed, zlib)}, {}, payload},
        {"check_nifti", "a.nii", {nifti(), nifti(2, 1)}, {}, payload},
        {"check_dicom", "a.dcm", {dicom({})}, {}, dicom_walk}};
}

const std::vector<InputKind>& input_kinds() {
    static const std::vector<InputKind> kKinds = [] {
        std::vector<InputKind> kinds;
        kinds.push_back({"gltf", "a.gltf", {kGltf}, {{"quad.bin", quad_bytes()}}, load_both_ways});
        kinds.push_back({"gltf_buffer", "quad.bin", {quad_bytes()}, {{"a.gltf", kGltf}},
            [](const fs::path& path) { load_both_ways(path.parent_path() / "a.gltf"); }});
        kinds.push_back({"glb", "a.glb", {glb()}, {}, load_both_ways});
        add_volumes(kinds);
        add_pictures(kinds);
        add_configurations(kinds);
        return kinds;
    }();
    return kKinds;
}

} // namespace ockham::test

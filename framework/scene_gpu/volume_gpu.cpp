// SPDX-License-Identifier: Apache-2.0
#include "framework/scene_gpu/volume_gpu.hpp"

#include "framework/core/error.hpp"
#include "framework/gpu/device.hpp"
#include "framework/gpu/transfer.hpp"
#include "framework/scene/voxels.hpp"
#include "framework/scene_gpu/imports.hpp"
#include "shaders/shared/volume.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <vector>

namespace ockham {
namespace {

/// How voxels are stored: texel = (voxel + shift) / largest.
struct Storage {
    VkFormat format;
    double shift = 0;
    double largest = 1;
};

/// Devices in software filter 8-bit texels in 8-bit arithmetic: lavapipe's field was a staircase,
/// off by up to 1.5 codes. There 8 bits are stored as 16.
bool widens(const gpu::Device& device, VoxelType type) {
    return type == VoxelType::uint8 && device.info().software;
}

Storage storage_of(const gpu::Device& device, VoxelType type) {
    switch (type) {
    case VoxelType::uint8:
        return {widens(device, type) ? VK_FORMAT_R16_UNORM : VK_FORMAT_R8_UNORM, 0, 255};
    case VoxelType::uint16:
        return {VK_FORMAT_R16_UNORM, 0, 65535};
    case VoxelType::int16:
        return {VK_FORMAT_R16_UNORM, 32768, 65535};
    case VoxelType::float32:
        break;
    }
    return {VK_FORMAT_R32_SFLOAT};
}

/// A volume of two voxels, the least and the greatest.
Volume extremes_of(const Volume& volume) {
    Volume out;
    out.name = volume.name;
    out.dims = {2, 1, 1};
    out.type = volume.type;
    out.value_scale = volume.value_scale;
    out.value_offset = volume.value_offset;
    with_voxels(volume, [&](auto voxels) {
        const auto [least, greatest] = std::minmax_element(voxels.begin(), voxels.end());
        for (const auto voxel : {*least, *greatest}) {
            const auto* bytes = reinterpret_cast<const std::byte*>(&voxel);
            out.voxels.insert(out.voxels.end(), bytes, bytes + sizeof(voxel));
        }
    });
    return out;
}

/// 16-bit texels of int16 voxels, or of uint8 ones that are to be widened.
std::vector<std::uint16_t> texels_of(const Volume& volume) {
    std::vector<std::uint16_t> out;
    out.reserve(volume.voxel_count());
    if (volume.type == VoxelType::int16) {
        for (const std::int16_t voxel : voxels_as<std::int16_t>(volume))
            out.push_back(static_cast<std::uint16_t>(voxel + 32768));
    } else {
        for (const std::uint8_t voxel : voxels_as<std::uint8_t>(volume))
            out.push_back(static_cast<std::uint16_t>(voxel * 257)); // / 65535 as voxel / 255
    }
    return out;
}

/// Walks through cells are stored between dispatches with 10 bits for each axis.
void check_size(const Volume& volume) {
    constexpr std::uint32_t kMostVoxels = 1022 * RANGE_CELL;
    for (int axis = 0; axis < 3; ++axis) {
        if (volume.dims[axis] <= kMostVoxels) continue;
        fail_input("volume {}: it has {} voxels along {}, and at most {} are supported; scale it "
                   "down or cut it",
            volume.name, volume.dims[axis], "xyz"[axis], kMostVoxels);
    }
}

/// Levels of opacity_max, one after the other.
std::vector<float> range_maxima(const TransferTable& table) {
    const std::size_t count = table.entries.size();
    std::vector<float> out;
    for (const glm::vec4& entry : table.entries) out.push_back(entry.w);
    for (std::size_t half = 1; 2 * half <= count; half *= 2) {
        const std::size_t below = out.size() - count;
        for (std::size_t i = 0; i < count; ++i) {
            out.push_back(std::max(out[below + i], out[below + std::min(i + half, count - 1)]));
        }
    }
    return out;
}

/// What chooses a texel of an equirectangular map by luminance times solid angle.
struct EnvironmentTable {
    std::vector<float> items; ///< as shaders/volume/environment.glsl lists them
    glm::dvec3 mean{0.0};     ///< over directions
};

/// Turns weights into cumulative shares that end with 1; without weight, all share alike.
void append_ends(std::vector<float>& out, const std::vector<double>& weights) {
    double total = 0, sum = 0;
    for (const double weight : weights) total += weight;
    for (std::size_t i = 0; i < weights.size(); ++i) {
        sum += total > 0 ? weights[i] / total : 1.0 / static_cast<double>(weights.size());
        out.push_back(static_cast<float>(std::min(sum, 1.0)));
    }
    // Rounding may leave the sum short of 1: the last entry that has any weight takes the rest.
    const float last = out.back();
    for (std::size_t i = out.size(); i-- > out.size() - weights.size() && out[i] == last;) {
        out[i] = 1.0f;
    }
}

EnvironmentTable environment_table(const std::vector<glm::vec4>& texels, glm::uvec2 size) {
    constexpr glm::dvec3 kLuminance(0.2126, 0.7152, 0.0722);
    std::vector<double> squares, rows, row(size.x); // squares of the sine of half the angle
    for (std::uint32_t y = 0; y <= size.y; ++y) {
        const double sine = std::sin(std::numbers::pi / 2 * y / size.y);
        squares.push_back(sine * sine);
    }
    const bool black = std::all_of(texels.begin(), texels.end(),
        [](const glm::vec4& texel) { return glm::vec3(texel) == glm::vec3(0.0f); });
    EnvironmentTable out;
    std::vector<float> columns;
    for (std::uint32_t y = 0; y < size.y; ++y) {
        const double share = (squares[y + 1] - squares[y]) / size.x; // of the sphere, each texel
        double sum = 0;
        for (std::uint32_t x = 0; x < size.x; ++x) {
            const glm::dvec3 radiance(texels[std::size_t{y} * size.x + x]);
            row[x] = black ? 1.0 : glm::dot(radiance, kLuminance);
            sum += row[x] * share;
            out.mean += radiance * share;
        }
        rows.push_back(sum);
        append_ends(columns, row);
    }
    const double sphere = 4 * std::numbers::pi, mean = glm::dot(out.mean, kLuminance);
    out.items.push_back(black ? 0.0f : static_cast<float>(1 / (sphere * mean)));
    out.items.push_back(black ? static_cast<float>(1 / sphere) : 0.0f);
    out.items.insert(out.items.end(), squares.begin(), squares.end());
    append_ends(out.items, rows);
    out.items.insert(out.items.end(), columns.begin(), columns.end());
    return out;
}

/// Throws Error(input) for what is no map of radiance.
std::vector<glm::vec4> environment_texels(const Image& map) {
    std::span<const float> planes[3];
    constexpr const char* names[3] = {"R", "G", "B"};
    for (int c = 0; c < 3; ++c) {
        const std::optional<int> channel = map.find(names[c]);
        if (!channel) {
            fail_input("environment map: it has no channel {}; expected R, G and B", names[c]);
        }
        planes[c] = map.plane(*channel);
    }
    std::vector<glm::vec4> out;
    for (std::size_t i = 0; i < map.pixels(); ++i) {
        const glm::vec3 texel(planes[0][i], planes[1][i], planes[2][i]);
        for (int c = 0; c < 3; ++c) {
            if (std::isfinite(texel[c]) && texel[c] >= 0) continue;
            const auto width = static_cast<std::size_t>(map.width());
            fail_input("environment map: channel {} of texel ({}, {}) is {}; radiance is finite "
                       "and not negative",
                names[c], i % width, i / width, texel[c]);
        }
        out.emplace_back(texel, 1.0f);
    }
    return out;
}

template <class T>
void fill_buffer(std::optional<gpu::Buffer>& buffer, gpu::Device& device, gpu::Uploader& uploader,
    const char* name, const std::vector<T>& values) {
    const std::span<const std::byte> bytes = std::as_bytes(std::span(values));
    if (!buffer || buffer->bytes() != bytes.size()) {
        buffer.emplace(device,
            gpu::BufferInfo{.bytes = bytes.size(),
                .usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                .name = name});
    }
    uploader.add(*buffer, bytes);
}

} // namespace

VolumeGpu::VolumeGpu(gpu::Device& device, const Volume& volume, const TransferFunction& transfer,
    const Image& environment)
    : device_(&device), extremes_(extremes_of(volume)) {
    check_size(volume);
    const Storage storage = storage_of(device, volume.type);
    texel_scale_ = 1.0 / (volume.value_scale * storage.largest);
    texel_offset_ = (storage.shift - volume.value_offset / volume.value_scale) / storage.largest;
    facts_.dims = volume.dims;
    facts_.cells = (volume.dims + glm::uvec3(RANGE_CELL - 1)) / glm::uvec3(RANGE_CELL);
    table_ = tabulate(transfer, extremes_);
    describe_transfer();
    gpu::Uploader uploader(device);
    make_volume(uploader, volume);
    make_tables(uploader);
    if (!environment.empty()) make_environment(uploader, environment);
    uploader.finish();
}

void VolumeGpu::make_volume(gpu::Uploader& uploader, const Volume& volume) {
    const bool one_slice = volume.dims.z == 1; // no 3D image: it would be a 2D one
    volume_.emplace(
        *device_, gpu::ImageInfo{.format = storage_of(*device_, volume.type).format,
                      .width = volume.dims.x,
                      .height = volume.dims.y,
                      .depth = one_slice ? 2 : volume.dims.z,
                      .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT,
                      .name = "volume"});
    std::vector<std::uint16_t> converted;
    std::span<const std::byte> texels = volume.voxels;
    if (volume.type == VoxelType::int16 || widens(*device_, volume.type)) {
        converted = texels_of(volume);
        texels = std::as_bytes(std::span(converted));
    }
    std::vector<std::byte> twice;
    if (one_slice) {
        for (int slice = 0; slice < 2; ++slice)
            twice.insert(twice.end(), texels.begin(), texels.end());
        texels = twice;
    }
    uploader.add(*volume_, 0, 0, texels);
    bytes_ += texels.size();
}

void VolumeGpu::make_environment(gpu::Uploader& uploader, const Image& map) {
    environment_size_ = {map.width(), map.height()};
    const std::uint64_t table_bytes =
        (map.pixels() + 2 * std::uint64_t{environment_size_.y} + 3) * sizeof(float);
    if (table_bytes > device_->limits().storage_bytes) {
        fail_device("environment map: the table that samples its {} x {} texels takes {} bytes, "
                    "but the device binds {} at a time; scale the map down",
            map.width(), map.height(), table_bytes, device_->limits().storage_bytes);
    }
    facts_.environment_map = true;
    const std::vector<glm::vec4> texels = environment_texels(map);
    const EnvironmentTable table = environment_table(texels, environment_size_);
    environment_mean_ = table.mean;
    environment_.emplace(
        *device_, gpu::ImageInfo{.format = VK_FORMAT_R32G32B32A32_SFLOAT,
                      .width = environment_size_.x,
                      .height = environment_size_.y,
                      .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT,
                      .name = "environment"});
    uploader.add(*environment_, 0, 0, std::as_bytes(std::span(texels)));
    fill_buffer(environment_table_, *device_, uploader, "environment_table", table.items);
    bytes_ += texels.size() * sizeof(glm::vec4) + environment_table_->bytes();
}

void VolumeGpu::make_tables(gpu::Uploader& uploader) {
    const auto fill = [&](std::optional<gpu::Buffer>& buffer, const char* name, bool wanted,
                          const auto& values) {
        if (buffer) bytes_ -= buffer->bytes();
        if (!wanted) return buffer.reset();
        fill_buffer(buffer, *device_, uploader, name, values);
        bytes_ += buffer->bytes();
    };
    fill(transfer_, "transfer", true, table_.entries);
    fill(emission_, "emission", facts_.emission, table_.emission);
    fill(opacity_max_, "opacity_max", !facts_.homogeneous, range_maxima(table_));
}

void VolumeGpu::describe_transfer() {
    // The table's ends are the volume's extremes, so every entry is between two of its values.
    const std::vector<glm::vec4>& entries = table_.entries;
    facts_.emission = !table_.emission.empty();
    facts_.homogeneous = std::all_of(entries.begin(), entries.end(),
        [&](const glm::vec4& entry) { return entry.w == entries.front().w; });
}

float VolumeGpu::texel_of(double value) const {
    return static_cast<float>(value * texel_scale_ + texel_offset_);
}

float VolumeGpu::max_opacity() const {
    return table_.max_opacity(table_.first, table_.last) * (1.0f + 0x1p-21f);
}

bool VolumeGpu::set_transfer(const TransferFunction& transfer) {
    const VolumeFacts before = facts_;
    const std::size_t entries = table_.entries.size();
    table_ = tabulate(transfer, extremes_);
    describe_transfer();
    gpu::Uploader uploader(*device_);
    make_tables(uploader);
    uploader.finish();
    return !(facts_ == before) || table_.entries.size() != entries;
}

VolumeHandles VolumeGpu::import(Graph& graph) const {
    return {import_image(graph, volume_), import_buffer(graph, transfer_),
        import_buffer(graph, emission_), import_buffer(graph, opacity_max_),
        import_image(graph, environment_), import_buffer(graph, environment_table_)};
}

void VolumeGpu::bind(Executor& executor, const VolumeHandles& handles) const {
    bind_import(executor, handles.volume, volume_);
    bind_import(executor, handles.transfer, transfer_);
    bind_import(executor, handles.emission, emission_);
    bind_import(executor, handles.opacity_max, opacity_max_);
    bind_import(executor, handles.environment, environment_);
    bind_import(executor, handles.environment_table, environment_table_);
}

} // namespace ockham

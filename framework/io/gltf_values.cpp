// SPDX-License-Identifier: Apache-2.0
#include "framework/io/gltf_values.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <string>

namespace ockham {
namespace {

using nlohmann::json;

/// Elements of all accessors together, which may share bytes: a small file could otherwise keep the
/// program busy for hours.
constexpr std::size_t kMaxElements = std::size_t{1} << 28;

/// Components as numbers, one element after the other; sparse elements are replaced.
class Elements {
public:
    Elements(const json& root, const GltfBuffers& buffers, const json& accessor)
        : type_(accessor["componentType"].get<int>()), bytes_(type_ <= 5121   ? 1
                                                              : type_ <= 5123 ? 2
                                                                              : 4),
          normalized_(accessor.value("normalized", false)), count_(accessor["count"]) {
        static const std::map<std::string, std::array<std::size_t, 2>> kShapes{{"SCALAR", {1, 1}},
            {"VEC2", {1, 2}}, {"VEC3", {1, 3}}, {"VEC4", {1, 4}}, {"MAT2", {2, 2}},
            {"MAT3", {3, 3}}, {"MAT4", {4, 4}}};
        const auto [columns, rows] = kShapes.at(accessor["type"].get<std::string>());
        rows_ = rows;
        components_ = columns * rows;
        // Columns of matrices begin at multiples of four bytes.
        column_bytes_ = columns == 1 ? rows * bytes_ : (rows * bytes_ + 3) / 4 * 4;
        element_bytes_ = columns * column_bytes_;
        has_data_ = take(root, buffers, accessor);
    }

    bool has_data() const { return has_data_; }
    bool is_float() const { return type_ == 5126; }
    /// Sparse indices do.
    bool is_increasing() const { return is_increasing_; }
    std::size_t count() const { return count_; }
    std::size_t components() const { return components_; }

    /// As stored: integers are not normalised.
    double raw(std::size_t element, std::size_t component) const {
        const std::byte* from = find(element);
        if (!from) return 0.0;
        from += component / rows_ * column_bytes_ + component % rows_ * bytes_;
        switch (type_) {
        case 5120:
            return load<std::int8_t>(from);
        case 5121:
            return load<std::uint8_t>(from);
        case 5122:
            return load<std::int16_t>(from);
        case 5123:
            return load<std::uint16_t>(from);
        case 5125:
            return load<std::uint32_t>(from);
        default:
            return double{load<float>(from)};
        }
    }

    /// glTF 2.0, 3.6.2.2.
    double at(std::size_t element, std::size_t component) const {
        const double value = raw(element, component);
        return normalized_ ? std::max(value / largest(), -1.0) : value;
    }

    /// The largest integer of the type; for indices it would restart a primitive.
    double largest() const {
        switch (type_) {
        case 5120:
            return 127.0;
        case 5121:
            return 255.0;
        case 5122:
            return 32767.0;
        case 5123:
            return 65535.0;
        default:
            return 4294967295.0;
        }
    }

private:
    template <class T>
    static T load(const std::byte* from) {
        T value;
        std::memcpy(&value, from, sizeof value);
        return value;
    }

    /// The first byte of a view, or null where its buffer has no data.
    static const std::byte* begin(const json& root, const GltfBuffers& buffers, const json& user) {
        const json& view = root["bufferViews"][user["bufferView"].get<std::size_t>()];
        const std::vector<std::byte>& buffer = buffers[view["buffer"].get<std::size_t>()];
        if (buffer.empty()) return nullptr;
        return buffer.data() + view.value("byteOffset", std::size_t{0}) +
               user.value("byteOffset", std::size_t{0});
    }

    bool take(const json& root, const GltfBuffers& buffers, const json& accessor) {
        if (accessor.contains("bufferView")) {
            data_ = begin(root, buffers, accessor);
            if (!data_) return false;
            const auto view = accessor["bufferView"].get<std::size_t>();
            stride_ = root["bufferViews"][view].value("byteStride", element_bytes_);
        }
        if (!accessor.contains("sparse")) return data_ != nullptr;
        const json& sparse = accessor["sparse"];
        const std::byte* indices = begin(root, buffers, sparse["indices"]);
        values_ = begin(root, buffers, sparse["values"]);
        if (!indices || !values_) return false;
        const int type = sparse["indices"]["componentType"].get<int>();
        replaced_.resize(sparse["count"]);
        for (std::size_t i = 0; i < replaced_.size(); ++i) {
            replaced_[i] = type == 5121   ? load<std::uint8_t>(indices + i)
                           : type == 5123 ? load<std::uint16_t>(indices + 2 * i)
                                          : load<std::uint32_t>(indices + 4 * i);
        }
        is_increasing_ = std::adjacent_find(replaced_.begin(), replaced_.end(),
                             [](auto a, auto b) { return a >= b; }) == replaced_.end();
        return true;
    }

    const std::byte* find(std::size_t element) const {
        const auto found = std::lower_bound(replaced_.begin(), replaced_.end(), element);
        if (found != replaced_.end() && *found == element) {
            return values_ + static_cast<std::size_t>(found - replaced_.begin()) * element_bytes_;
        }
        return data_ ? data_ + element * stride_ : nullptr;
    }

    int type_;
    std::size_t bytes_;
    bool normalized_;
    std::size_t count_;
    std::size_t rows_ = 1, components_ = 1, column_bytes_ = 0, element_bytes_ = 0, stride_ = 0;
    const std::byte* data_ = nullptr;
    const std::byte* values_ = nullptr;
    std::vector<std::uint32_t> replaced_;
    bool has_data_ = false;
    bool is_increasing_ = true;
};

const json kNothing;

const json& get(const json& object, const char* key) {
    if (!object.is_object()) return kNothing;
    const auto found = object.find(key);
    return found == object.end() ? kNothing : *found;
}

class ValueChecker {
public:
    ValueChecker(const json& root, const GltfBuffers& buffers, const GltfFindings& findings)
        : root_(root), buffers_(buffers), findings_(findings) {}

    void check_all() const {
        refuse_too_many();
        const std::size_t count = get(root_, "accessors").size();
        for (std::size_t i = 0; i < count; ++i) check_bounds(i);
        const std::vector<double> limits = fewest_joints();
        for (std::size_t i = 0; i < limits.size(); ++i) {
            for (const json& primitive : root_["meshes"][i]["primitives"]) {
                check_primitive(primitive, limits[i]);
            }
        }
        for (const json& skin : get(root_, "skins")) {
            if (skin.contains("inverseBindMatrices")) check_matrices(skin["inverseBindMatrices"]);
        }
        for (const json& source : get(root_, "animations")) check_animation(source);
    }

private:
    Elements elements(const json& index) const {
        return {root_, buffers_, root_["accessors"][index.get<std::size_t>()]};
    }

    [[noreturn]] void refuse(
        const json& index, std::size_t element, double value, const char* expected) const {
        findings_.refuse("accessors[{}]: element {} has {}, expected {}", index.dump(), element,
            value, expected);
    }

    [[noreturn]] void refuse_influence(
        std::size_t set, std::size_t vertex, double value, const char* expected) const {
        findings_.refuse("JOINTS_{0} or WEIGHTS_{0}: vertex {1} has {2}, expected {3}", set, vertex,
            value, expected);
    }

    void refuse_too_many() const {
        std::size_t sum = 0;
        for (const json& accessor : get(root_, "accessors")) {
            sum += accessor["count"].get<std::size_t>();
        }
        if (sum > kMaxElements) {
            findings_.fatal(
                "its accessors have {} elements, --strict looks at {} at most", sum, kMaxElements);
        }
    }

    /// Finite, and `min` and `max` as declared: glTF 2.0, 3.6.2.5.
    void check_bounds(std::size_t index) const {
        const Elements values = elements(index);
        if (!values.has_data()) return;
        if (!values.is_increasing()) {
            findings_.refuse("accessors[{}].sparse: its indices do not increase", index);
        }
        constexpr double kInfinity = std::numeric_limits<double>::infinity();
        std::array<double, 16> low, high;
        low.fill(kInfinity);
        high.fill(-kInfinity);
        for (std::size_t i = 0; i < values.count(); ++i) {
            for (std::size_t c = 0; c < values.components(); ++c) {
                const double value = values.raw(i, c);
                if (!std::isfinite(value)) refuse(index, i, value, "finite numbers");
                low[c] = std::min(low[c], value);
                high[c] = std::max(high[c], value);
            }
        }
        const json& accessor = root_["accessors"][index];
        for (std::size_t c = 0; c < values.components(); ++c) {
            check_bound(accessor, "min", index, c, low[c], values.is_float());
            check_bound(accessor, "max", index, c, high[c], values.is_float());
        }
    }

    void check_bound(const json& accessor, const char* key, std::size_t index, std::size_t c,
        double found, bool is_float) const {
        const json& bound = get(accessor, key);
        if (bound.is_null()) return;
        const double declared = bound[c].get<double>();
        const double rounded = is_float ? double{static_cast<float>(declared)} : declared;
        if (rounded == found) return;
        findings_.refuse(
            "accessors[{}].{}[{}] is {}, its data has {}", index, key, c, declared, found);
    }

    // Meshes

    void check_primitive(const json& primitive, double joint_limit) const {
        const json& attributes = primitive["attributes"];
        if (const auto found = attributes.find("NORMAL"); found != attributes.end()) {
            check_unit(*found, 3);
        }
        if (const auto found = attributes.find("TANGENT"); found != attributes.end()) {
            check_unit(*found, 3);
            const Elements values = elements(*found);
            for (std::size_t i = 0; values.has_data() && i < values.count(); ++i) {
                if (std::abs(values.at(i, 3)) != 1.0) {
                    refuse(*found, i, values.at(i, 3), "a sign of 1 or -1");
                }
            }
        }
        for (const auto& [name, index] : attributes.items()) {
            if (name.starts_with("COLOR_")) check_clamped(index);
        }
        if (primitive.contains("indices")) check_indices(primitive);
        check_influences(attributes, joint_limit);
    }

    /// To the accuracy that Khronos' validator asks for.
    void check_unit(const json& index, std::size_t components) const {
        const Elements values = elements(index);
        for (std::size_t i = 0; values.has_data() && i < values.count(); ++i) {
            double square = 0.0;
            for (std::size_t c = 0; c < components; ++c) {
                square += values.at(i, c) * values.at(i, c);
            }
            const double length = std::sqrt(square);
            if (!(std::abs(length - 1.0) <= 0.00674)) refuse(index, i, length, "a length of 1");
        }
    }

    void check_clamped(const json& index) const {
        const Elements values = elements(index);
        for (std::size_t i = 0; values.has_data() && i < values.count(); ++i) {
            for (std::size_t c = 0; c < values.components(); ++c) {
                const double value = values.at(i, c);
                if (value < 0.0 || value > 1.0) refuse(index, i, value, "0 to 1");
            }
        }
    }

    void check_indices(const json& primitive) const {
        const json& index = primitive["indices"];
        const Elements values = elements(index);
        const json& attributes = primitive["attributes"];
        const json& some = *attributes.begin();
        const auto vertices = root_["accessors"][some.get<std::size_t>()]["count"].get<double>();
        for (std::size_t i = 0; values.has_data() && i < values.count(); ++i) {
            const double value = values.raw(i, 0);
            if (value == values.largest()) refuse(index, i, value, "less: it restarts primitives");
            if (value >= vertices) refuse(index, i, value, "the index of a vertex");
        }
    }

    /// Joints that there are, each once in a vertex, with weights of sum 1: glTF 2.0, 3.7.3.
    void check_influences(const json& attributes, double limit) const {
        std::vector<Elements> joints, weights;
        for (std::size_t set = 0;; ++set) {
            const auto joint = attributes.find(fmt::format("JOINTS_{}", set));
            const auto weight = attributes.find(fmt::format("WEIGHTS_{}", set));
            if (joint == attributes.end() || weight == attributes.end()) break;
            joints.push_back(elements(*joint));
            weights.push_back(elements(*weight));
            if (!joints.back().has_data() || !weights.back().has_data()) return;
        }
        if (joints.empty()) return;
        for (std::size_t vertex = 0; vertex < joints[0].count(); ++vertex) {
            double sum = 0.0, used = 0.0;
            std::set<double> seen;
            for (std::size_t i = 0; i < 4 * joints.size(); ++i) {
                const double joint = joints[i / 4].raw(vertex, i % 4);
                const double weight = weights[i / 4].at(vertex, i % 4);
                if (joint >= limit) refuse_influence(i / 4, vertex, joint, "a joint of the skin");
                if (weight < 0.0) refuse_influence(i / 4, vertex, weight, "weights from 0");
                if (weight > 0.0 && !seen.insert(joint).second) {
                    refuse_influence(i / 4, vertex, joint, "each joint once");
                }
                sum += weight;
                used += weight > 0.0;
            }
            // To the accuracy that Khronos' validator asks for.
            if (std::abs(sum - 1.0) > 2e-7 * used + 1e-9) {
                refuse_influence(0, vertex, sum, "weights that sum to 1");
            }
        }
    }

    /// For each mesh, of the skins that move it.
    std::vector<double> fewest_joints() const {
        std::vector<double> limits(
            get(root_, "meshes").size(), std::numeric_limits<double>::infinity());
        for (const json& node : get(root_, "nodes")) {
            if (!node.contains("skin") || !node.contains("mesh")) continue;
            const json& skin = root_["skins"][node["skin"].get<std::size_t>()];
            double& limit = limits[node["mesh"].get<std::size_t>()];
            limit = std::min(limit, static_cast<double>(skin["joints"].size()));
        }
        return limits;
    }

    // Skins and animations

    void check_matrices(const json& index) const {
        const Elements values = elements(index);
        for (std::size_t i = 0; values.has_data() && i < values.count(); ++i) {
            for (std::size_t column = 0; column < 4; ++column) {
                const double value = values.raw(i, 4 * column + 3);
                if (value != (column == 3 ? 1.0 : 0.0)) {
                    refuse(index, i, value, "a last row of 0, 0, 0, 1");
                }
            }
        }
    }

    void check_animation(const json& source) const {
        for (const json& sampler : source["samplers"]) {
            const Elements times = elements(sampler["input"]);
            for (std::size_t i = 0; times.has_data() && i < times.count(); ++i) {
                const double time = times.raw(i, 0);
                if (time < 0.0) refuse(sampler["input"], i, time, "times from 0");
                if (i > 0 && time <= times.raw(i - 1, 0)) {
                    refuse(sampler["input"], i, time, "times that increase");
                }
            }
        }
        for (const json& channel : source["channels"]) {
            if (get(channel["target"], "path") != "rotation") continue;
            const json& sampler = source["samplers"][channel["sampler"].get<std::size_t>()];
            check_rotations(sampler["output"], get(sampler, "interpolation") == "CUBICSPLINE");
        }
    }

    /// Splines have a tangent before and after each value.
    void check_rotations(const json& index, bool is_spline) const {
        const Elements values = elements(index);
        const std::size_t step = is_spline ? 3 : 1;
        for (std::size_t i = step / 2; values.has_data() && i < values.count(); i += step) {
            double square = 0.0;
            for (std::size_t c = 0; c < 4; ++c) square += values.at(i, c) * values.at(i, c);
            const double length = std::sqrt(square);
            if (!(std::abs(length - 1.0) <= 0.00769)) refuse(index, i, length, "a length of 1");
        }
    }

    const json& root_;
    const GltfBuffers& buffers_;
    const GltfFindings& findings_;
};

} // namespace

void check_gltf_values(const json& root, const GltfBuffers& buffers, const GltfFindings& findings) {
    ValueChecker(root, buffers, findings).check_all();
}

} // namespace ockham

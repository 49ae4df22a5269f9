// SPDX-License-Identifier: Apache-2.0
#include "samples/metrics/onnx_inputs.hpp"

#include <algorithm>
#include <cstdint>
#include <optional>

namespace ockham {
namespace {

/// One field of a protobuf message (protobuf.dev, "Encoding").
struct Field {
    std::uint64_t number = 0;
    std::string_view bytes; ///< of fields with a length; others are skipped
};

class Message {
public:
    explicit Message(std::string_view bytes) : rest_(bytes) {}

    /// Nothing at the end, and where the message is damaged.
    std::optional<Field> next() {
        const std::optional<std::uint64_t> key = varint();
        if (!key) return std::nullopt;
        Field field{.number = *key >> 3, .bytes = {}};
        switch (*key & 7) {
        case 0:
            return varint() ? std::optional(field) : std::nullopt;
        case 1:
            return take(8) ? std::optional(field) : std::nullopt;
        case 5:
            return take(4) ? std::optional(field) : std::nullopt;
        case 2:
            if (const auto size = varint()) {
                if (const auto bytes = take(*size)) return Field{field.number, *bytes};
            }
        }
        return std::nullopt;
    }

private:
    std::optional<std::string_view> take(std::uint64_t size) {
        if (size > rest_.size()) return std::nullopt;
        const std::string_view bytes = rest_.substr(0, static_cast<std::size_t>(size));
        rest_.remove_prefix(bytes.size());
        return bytes;
    }
    std::optional<std::uint64_t> varint() {
        std::uint64_t value = 0;
        for (unsigned shift = 0; shift < 64; shift += 7) {
            const auto byte = take(1);
            if (!byte) return std::nullopt;
            const auto bits = static_cast<unsigned char>(byte->front());
            value |= std::uint64_t{bits & 0x7fu} << shift;
            if (bits < 0x80) return value;
        }
        return std::nullopt;
    }
    std::string_view rest_;
};

/// All fields of that number.
std::vector<std::string_view> fields(std::string_view message, std::uint64_t number) {
    std::vector<std::string_view> found;
    Message reader(message);
    while (const std::optional<Field> field = reader.next())
        if (field->number == number) found.push_back(field->bytes);
    return found;
}

std::string first(const std::vector<std::string_view>& found) {
    return found.empty() ? std::string() : std::string(found.front());
}

} // namespace

std::vector<std::string> onnx_inputs(std::string_view file) {
    // ModelProto.graph 7; GraphProto.initializer 5, input 11; TensorProto.name 8,
    // ValueInfoProto.name 1 (onnx.proto, IR version 3 and later).
    std::vector<std::string> names, weights;
    for (const std::string_view graph : fields(file, 7)) {
        for (const std::string_view tensor : fields(graph, 5))
            weights.push_back(first(fields(tensor, 8)));
        for (const std::string_view input : fields(graph, 11))
            names.push_back(first(fields(input, 1)));
    }
    std::erase_if(names, [&](const std::string& name) {
        return name.empty() || std::find(weights.begin(), weights.end(), name) != weights.end();
    });
    return names;
}

} // namespace ockham

// SPDX-License-Identifier: Apache-2.0
// Small passes with known results, from which the tests of the runtime make graphs.
#pragma once

#include "framework/runtime/commands.hpp"

#include <algorithm>
#include <string>
#include <utility>

namespace ockham::test {

/// numbers[i] = factor i + offset, over all of the part.
inline BufferHandle add_numbers(Graph& graph, std::string name, BufferPart buffer,
    std::uint32_t offset = 0, std::uint32_t factor = 1) {
    const std::uint64_t rest = graph.desc(buffer.handle).bytes - buffer.part.offset;
    const auto count = static_cast<std::uint32_t>(std::min(buffer.part.bytes, rest) / 4);
    PassBuilder pass = graph.add_compute_pass(std::move(name));
    const BufferHandle result = pass.write("numbers", buffer);
    pass.record([=](Commands& commands) {
        const std::uint32_t push[] = {count, offset};
        commands.dispatch_over(
            {.shader = "test/number.comp", .specialization = {{0, factor}}, .push = as_push(push)},
            {count, 1, 1});
    });
    return result;
}

/// target[i] = source[i] + 1
inline BufferHandle add_one(
    Graph& graph, std::string name, BufferPart source, BufferHandle target) {
    const auto count = static_cast<std::uint32_t>(graph.desc(target).bytes / 4);
    PassBuilder pass = graph.add_compute_pass(std::move(name));
    pass.read("source", source);
    target = pass.write("target", target);
    pass.record([=](Commands& commands) {
        commands.dispatch_over({.shader = "test/add_one.comp"}, {count, 1, 1});
    });
    return target;
}

/// marks[i] += value
inline BufferHandle add_mark(
    Graph& graph, std::string name, BufferHandle marks, std::uint32_t value) {
    const auto count = static_cast<std::uint32_t>(graph.desc(marks).bytes / 4);
    PassBuilder pass = graph.add_compute_pass(std::move(name));
    marks = pass.read_write("marks", marks);
    pass.record([=](Commands& commands) {
        commands.dispatch_over({.shader = "test/mark.comp", .push = as_push(value)}, {count, 1, 1});
    });
    return marks;
}

/// target(x, y) = x + 100 y + offset, over one mip of one layer.
inline ImageHandle add_gradient(
    Graph& graph, std::string name, ImagePart target, float offset = 0) {
    const ImageDesc desc = graph.desc(target.handle);
    PassBuilder pass = graph.add_compute_pass(std::move(name));
    const ImageHandle result = pass.write("target", target);
    pass.record([=](Commands& commands) {
        commands.dispatch_over({.shader = "test/gradient.comp", .push = as_push(offset)},
            {desc.width, desc.height, 1});
    });
    return result;
}

} // namespace ockham::test

// SPDX-License-Identifier: Apache-2.0
#include "framework/core/log.hpp"

#include <atomic>
#include <cstdio>
#include <mutex>

namespace ockham::log {
namespace {

std::atomic<Level> threshold{Level::info};
std::mutex mutex;
std::function<void(Level, std::string_view)> sink;

const char* prefix(Level level) {
    switch (level) {
    case Level::warning:
        return "warning: ";
    case Level::error:
        return "error: ";
    default:
        return "";
    }
}

} // namespace

void set_level(Level level) { threshold = level; }

void set_sink(std::function<void(Level, std::string_view)> new_sink) {
    std::scoped_lock lock(mutex);
    sink = std::move(new_sink);
}

void write(Level level, std::string_view text) {
    if (level < threshold.load()) return;
    std::scoped_lock lock(mutex);
    if (sink) return sink(level, text);
    fmt::print(stderr, "{}{}\n", prefix(level), text);
}

} // namespace ockham::log

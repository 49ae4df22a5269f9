// SPDX-License-Identifier: Apache-2.0
#include "samples/chart/store.hpp"

#include "framework/core/error.hpp"
#include "framework/core/file.hpp"
#include "framework/core/log.hpp"
#include "framework/core/version.hpp"

#include <fcntl.h>
#include <nlohmann/json.hpp>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>

namespace ockham::chart {
namespace {

constexpr std::uint64_t kFnvBasis = 0xcbf29ce484222325u, kFnvPrime = 0x100000001b3u;

std::uint64_t fnv(std::string_view text, std::uint64_t hash = kFnvBasis) {
    for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * kFnvPrime;
    return hash;
}

nlohmann::ordered_json to_json(const Job& job, const Repeat& repeat) {
    nlohmann::ordered_json rows = nlohmann::ordered_json::array();
    for (const Row& row : repeat.rows) {
        nlohmann::ordered_json values = nlohmann::ordered_json::object();
        for (const auto& [name, value] : row.values)
            if (std::isfinite(value)) values[name] = value;
        rows.push_back({{"knob", row.knob}, {"values", values}});
    }
    return {{"key", job.key()}, {"suite", job.suite}, {"scene", job.scene}, {"series", job.series},
        {"setting", job.setting}, {"inputs", job.inputs}, {"commit", commit()},
        {"command", job.command}, {"pictures", repeat.pictures}, {"rows", rows}};
}

Repeat repeat_of(const nlohmann::json& line) {
    Repeat repeat;
    for (const nlohmann::json& row : line.at("rows"))
        repeat.rows.push_back({row.at("knob").get<double>(), row.at("values").get<Values>()});
    repeat.pictures = line.at("pictures").get<std::map<std::string, std::string>>();
    return repeat;
}

std::string digits(std::uint64_t hash) { return fmt::format("{:016x}", hash); }

std::string folder_listing(const std::filesystem::path& folder) {
    std::vector<std::string> lines;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
        if (!entry.is_regular_file()) continue;
        lines.push_back(fmt::format("{} {} {}\n", entry.path().string(), entry.file_size(),
            entry.last_write_time().time_since_epoch().count()));
    }
    std::sort(lines.begin(), lines.end());
    return fmt::format("{}", fmt::join(lines, ""));
}

} // namespace

std::string Job::key() const {
    std::uint64_t hash = fnv(commit());
    for (const std::string* part : {&suite, &scene, &series, &setting, &inputs})
        hash = fnv(*part, fnv(std::string_view("\0", 1), hash));
    return digits(hash);
}

Spread spread(std::vector<double> values) {
    check(!values.empty(), "a spread of at least one value");
    std::sort(values.begin(), values.end());
    const auto quantile = [&](double q) {
        const double at = q * static_cast<double>(values.size() - 1);
        const auto below = static_cast<std::size_t>(at);
        const std::size_t above = std::min(below + 1, values.size() - 1);
        return values[below] + (at - static_cast<double>(below)) * (values[above] - values[below]);
    };
    if (values.size() < 4) return {values.front(), quantile(0.5), values.back()};
    return {quantile(0.25), quantile(0.5), quantile(0.75)};
}

Store::Store(std::filesystem::path folder) : folder_(std::move(folder)) {
    std::error_code error;
    std::filesystem::create_directories(folder_, error);
    const std::filesystem::path path = folder_ / "measured.jsonl";
    file_ = ::open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
    if (file_ < 0) {
        fail_input("cannot write '{}': {}; name a folder for --out that can be written",
            path.string(), error ? error.message() : std::strerror(errno));
    }
    try {
        if (::flock(file_, LOCK_EX | LOCK_NB) != 0) {
            fail_input("'{}' is in use by another chart; wait for it, or name another folder for "
                       "--out",
                path.string());
        }
        load(path);
    } catch (...) {
        ::close(file_); // no destructor runs
        throw;
    }
}

Store::~Store() {
    if (file_ >= 0) ::close(file_);
}

void Store::load(const std::filesystem::path& path) {
    const std::string text = read_text(path);
    std::size_t begin = 0;
    for (int number = 1;; ++number) {
        const std::size_t end = text.find('\n', begin);
        if (end == std::string::npos) break;
        try {
            const auto line = nlohmann::json::parse(
                text.begin() + static_cast<long>(begin), text.begin() + static_cast<long>(end));
            repeats_[line.at("key").get<std::string>()].push_back(repeat_of(line));
        } catch (const nlohmann::json::exception&) {
            fail_input("{}:{} is no measurement; delete the line, or begin another folder",
                path.string(), number);
        }
        begin = end + 1;
    }
    if (begin == text.size()) return;
    log::info("{}: cut off a line that an interrupted run left unfinished", path.string());
    std::error_code error;
    std::filesystem::resize_file(path, begin, error);
    if (error) fail_input("cannot write '{}': {}", path.string(), error.message());
}

const std::vector<Repeat>& Store::repeats(const Job& job) const {
    static const std::vector<Repeat> kNone;
    const auto found = repeats_.find(job.key());
    return found == repeats_.end() ? kNone : found->second;
}

void Store::add(const Job& job, const Repeat& repeat) {
    const nlohmann::ordered_json json = to_json(job, repeat);
    const std::string line = json.dump() + "\n";
    // One write: a line is there in full, or it is the unfinished last one.
    const ssize_t written = ::write(file_, line.data(), line.size());
    if (written != static_cast<ssize_t>(line.size()) || ::fsync(file_) != 0) {
        fail_input("cannot write '{}': {}", (folder_ / "measured.jsonl").string(),
            written < 0 ? std::strerror(errno) : "the disk is full");
    }
    repeats_[job.key()].push_back(repeat_of(json));
}

std::vector<Point> points_of(const Store& store, const std::vector<Job>& jobs) {
    std::vector<Point> points;
    for (const Job& job : jobs) {
        const std::size_t first = points.size();
        for (const Repeat& repeat : store.repeats(job)) {
            for (std::size_t i = 0; i < repeat.rows.size(); ++i) {
                const Row& row = repeat.rows[i];
                if (first + i == points.size())
                    points.push_back({.job = &job, .knob = row.knob, .values = {}});
                for (const auto& [name, value] : row.values)
                    points[first + i].values[name].push_back(value);
            }
        }
    }
    return points;
}

std::string fingerprint(std::string_view text) { return digits(fnv(text)); }

std::string fingerprint_of(const std::string& scene) {
    if (scene.starts_with("builtin:")) return scene;
    std::filesystem::path path(scene);
    if (path.extension() == ".gltf") path = path.has_parent_path() ? path.parent_path() : ".";
    try {
        if (std::filesystem::is_directory(path)) return fingerprint(folder_listing(path));
    } catch (const std::filesystem::filesystem_error& error) {
        fail_input("cannot read '{}': {}", scene, error.code().message());
    }
    const std::vector<std::byte> bytes = read_file(path);
    return fingerprint({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

} // namespace ockham::chart

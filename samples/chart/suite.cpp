// SPDX-License-Identifier: Apache-2.0
#include "samples/chart/suite.hpp"

#include "framework/core/error.hpp"
#include "framework/core/false_color.hpp"
#include "framework/core/log.hpp"
#include "framework/image_error/image_error.hpp"
#include "framework/io/png.hpp"

#include <cmath>
#include <fstream>
#include <thread>

namespace ockham::chart {
namespace {

/// A repeat that is missing.
struct Open {
    const Job* job;
    std::unique_ptr<Subject> subject;
    std::size_t done;
};

std::size_t wanted(const Job& job, const Context& context) {
    return static_cast<std::size_t>(job.repeats > 0 ? job.repeats : context.options.repeats);
}

/// Pictures lie there before the line that names them.
std::map<std::string, std::string> keep_pictures(
    const Job& job, Subject& subject, const std::filesystem::path& folder) {
    std::map<std::string, std::string> files;
    for (const auto& [name, picture] : subject.pictures()) {
        std::filesystem::create_directories(folder / "pictures");
        const std::string file = fmt::format("pictures/{}_{}.png", job.key(), name);
        save_png_srgb(folder / file, picture.width, picture.height, picture.rgb);
        files[name] = file;
    }
    return files;
}

/// One job after the other, in turns; false: interrupted.
bool measure_in_turns(std::vector<Open>& group, const Context& context, Store& store,
    std::size_t& done, Progress& progress) {
    for (bool more = true; more;) {
        more = false;
        for (Open& open : group) {
            if (open.done >= wanted(*open.job, context)) continue;
            Repeat repeat{.rows = open.subject->measure(), .pictures = {}};
            if (interrupted()) return false;
            if (open.done == 0)
                repeat.pictures = keep_pictures(*open.job, *open.subject, store.folder());
            store.add(*open.job, repeat);
            progress.update(++done);
            more |= ++open.done < wanted(*open.job, context);
        }
    }
    return true;
}

} // namespace

gpu::Device& Context::device() {
    if (!device_) {
        device_ = std::make_unique<gpu::Device>(device_options(options.common));
        watch_shaders(*device_, options.common);
    }
    return *device_;
}

std::string Context::device_text() {
    const gpu::DeviceInfo& info = device().info();
    return info.name + ", " + info.driver_version;
}

std::string Context::device_name() const { return device_ ? device_->info().name : ""; }

Picture to_picture(const Image& linear, float exposure_ev) {
    Picture picture{.width = linear.width(), .height = linear.height(), .rgb = {}};
    picture.rgb.resize(3 * linear.pixels());
    const float gain = std::exp2(exposure_ev);
    for (std::size_t c = 0; c < 3; ++c) {
        const std::span<const float> plane = linear.plane(std::string_view("RGB").substr(c, 1));
        for (std::size_t i = 0; i < plane.size(); ++i) {
            picture.rgb[3 * i + c] =
                static_cast<std::uint8_t>(std::lround(255 * srgb_encode(gain * plane[i])));
        }
    }
    return picture;
}

Picture error_picture(const Image& test, const Image& reference, float scale) {
    return {test.width(), test.height(),
        false_color(image_error(test, reference).map.plane(0), 0.0f, 1.0f / scale)};
}

std::string cpu_name() {
    std::ifstream in("/proc/cpuinfo");
    std::string model = "unknown processor";
    for (std::string line; std::getline(in, line);) {
        if (!line.starts_with("model name")) continue;
        model = line.substr(line.find(':') + 2);
        break;
    }
    return fmt::format("{}, {} cores", model, std::thread::hardware_concurrency());
}

bool run_suites(const std::vector<std::unique_ptr<Suite>>& suites, Context& context, Store& store) {
    std::vector<std::vector<Job>> missing;
    std::size_t repeats = 0, kept = 0;
    for (const auto& suite : suites) {
        missing.emplace_back();
        for (Job& job : suite->jobs()) {
            const std::size_t has = store.repeats(job).size(), wants = wanted(job, context);
            kept += std::min(has, wants);
            if (has >= wants) continue;
            repeats += wants - has;
            missing.back().push_back(std::move(job));
        }
    }
    log::info("{} measurements to make, {} kept from before", repeats, kept);
    std::size_t done = 0;
    Progress progress("measurement", repeats, context.options.common.quiet);
    for (std::size_t s = 0; s < suites.size(); ++s) {
        const std::vector<Job>& jobs = missing[s];
        for (std::size_t i = 0; i < jobs.size();) {
            std::vector<Open> group;
            const std::string scene = jobs[i].scene;
            for (; i < jobs.size() && jobs[i].scene == scene; ++i) {
                if (interrupted()) return false;
                if (group.size() == suites[s]->together()) break;
                group.push_back(
                    {&jobs[i], suites[s]->open(jobs[i]), store.repeats(jobs[i]).size()});
            }
            if (!measure_in_turns(group, context, store, done, progress)) return false;
        }
    }
    return true;
}

} // namespace ockham::chart

// SPDX-License-Identifier: Apache-2.0
#include "samples/chart/aa_choice.hpp"

#include "framework/core/error.hpp"
#include "framework/core/json_object.hpp"

#include <algorithm>
#include <cmath>

namespace ockham {

extern const char* const kAaChart; ///< aa_chart.json

namespace {

constexpr double kLargest = 1e9;

AaChart parse(const nlohmann::json& json, const std::string& file) {
    const JsonObject root(json, "chart of anti-aliasing", file);
    AaChart chart;
    chart.m = static_cast<std::uint32_t>(root.number("m", 2, 8, "a window width"));
    chart.device = root.text("device");
    for (const JsonObject& one : root.objects("classes")) {
        AaClass scenes{.name = one.text("name"), .entries = {}};
        for (const JsonObject& entry : one.objects("entries")) {
            scenes.entries.push_back({entry.number("lambda", 1e-12, 1, "a price above 0"),
                entry.number("samples_percent", 1e-3, 100, "a share of all samples"),
                entry.number("psnr", 0, 999, "decibels"),
                entry.number("total_gpu_ms", 1e-9, kLargest, "milliseconds")});
        }
        const auto by_lambda = [](const auto& a, const auto& b) { return a.lambda < b.lambda; };
        std::sort(scenes.entries.begin(), scenes.entries.end(), by_lambda);
        if (scenes.entries.size() < 2) one.refuse("entries", "at least two");
        chart.classes.push_back(std::move(scenes));
    }
    if (chart.classes.empty()) root.refuse("classes", "at least one");
    return chart;
}

/// One quantity over log lambda, never rising with it.
class Falling {
public:
    Falling(const AaClass& scenes, double AaClass::Entry::*value) {
        for (const AaClass::Entry& entry : scenes.entries) {
            x_.push_back(std::log(entry.lambda));
            y_.push_back(entry.*value);
        }
        // The nearest sequence that falls: neighbours that rise are averaged (isotonic regression).
        std::vector<double> mean;
        std::vector<std::size_t> size;
        for (const double y : y_) {
            mean.push_back(y), size.push_back(1);
            while (mean.size() > 1 && mean[mean.size() - 2] < mean.back()) {
                const std::size_t a = size[size.size() - 2], b = size.back();
                const double sum = mean[mean.size() - 2] * static_cast<double>(a) +
                                   mean.back() * static_cast<double>(b);
                mean.pop_back(), size.pop_back();
                mean.back() = sum / static_cast<double>(a + b), size.back() = a + b;
            }
        }
        std::size_t i = 0;
        for (std::size_t block = 0; block < mean.size(); ++block)
            for (std::size_t k = 0; k < size[block]; ++k) y_[i++] = mean[block];
    }

    double at(double lambda) const {
        const double x = std::log(lambda);
        if (x <= x_.front()) return y_.front();
        if (x >= x_.back()) return y_.back();
        const auto above =
            static_cast<std::size_t>(std::upper_bound(x_.begin(), x_.end(), x) - x_.begin());
        const double t = (x - x_[above - 1]) / (x_[above] - x_[above - 1]);
        return std::lerp(y_[above - 1], y_[above], t);
    }
    /// The largest lambda whose value is at least `y`; the smallest there is where none is.
    double last_at_least(double y) const {
        for (std::size_t i = y_.size(); i-- > 0;) {
            if (y_[i] < y) continue;
            if (i + 1 == y_.size()) return std::exp(x_.back());
            return std::exp(std::lerp(x_[i], x_[i + 1], (y_[i] - y) / (y_[i] - y_[i + 1])));
        }
        return std::exp(x_.front());
    }
    /// The smallest lambda whose value is at most `y`; the largest there is where none is.
    double first_at_most(double y) const {
        for (std::size_t i = 0; i < y_.size(); ++i) {
            if (y_[i] > y) continue;
            if (i == 0) return std::exp(x_.front());
            return std::exp(std::lerp(x_[i - 1], x_[i], (y_[i - 1] - y) / (y_[i - 1] - y_[i])));
        }
        return std::exp(x_.back());
    }
    double most() const { return y_.front(); }
    double least() const { return y_.back(); }

private:
    std::vector<double> x_, y_;
};

} // namespace

AaChart load_aa_chart(const std::filesystem::path& path) {
    return parse(parse_json(path, "chart of anti-aliasing"), path.string());
}

AaChart builtin_aa_chart() { return parse(nlohmann::json::parse(kAaChart), "built-in chart"); }

std::string to_json(const AaChart& chart) {
    nlohmann::ordered_json json{{"m", chart.m}, {"device", chart.device}};
    json["classes"] = nlohmann::ordered_json::array();
    for (const AaClass& scenes : chart.classes) {
        nlohmann::ordered_json entries = nlohmann::ordered_json::array();
        for (const AaClass::Entry& entry : scenes.entries) {
            entries.push_back({{"lambda", entry.lambda}, {"samples_percent", entry.samples_percent},
                {"psnr", entry.psnr}, {"total_gpu_ms", entry.total_gpu_ms}});
        }
        json["classes"].push_back({{"name", scenes.name}, {"entries", entries}});
    }
    return json.dump(1) + "\n";
}

const AaClass& class_of(const AaChart& chart, const AaProbe& probe) {
    check(!chart.classes.empty() && probe.samples_percent > 0, "classes and a probe");
    const auto distance = [&](const AaClass& scenes) {
        const double share = Falling(scenes, &AaClass::Entry::samples_percent).at(probe.lambda);
        return std::abs(std::log(share / probe.samples_percent));
    };
    return *std::min_element(chart.classes.begin(), chart.classes.end(),
        [&](const AaClass& a, const AaClass& b) { return distance(a) < distance(b); });
}

AaChoice predict(const AaClass& scenes, const AaProbe& probe, double lambda) {
    const Falling ms(scenes, &AaClass::Entry::total_gpu_ms);
    return {.class_name = scenes.name,
        .lambda = lambda,
        .psnr = Falling(scenes, &AaClass::Entry::psnr).at(lambda),
        .total_gpu_ms = probe.total_gpu_ms * ms.at(lambda) / ms.at(probe.lambda)};
}

AaChoice choose_by_psnr(const AaChart& chart, const AaProbe& probe, double decibels) {
    const AaClass& scenes = class_of(chart, probe);
    const Falling psnr(scenes, &AaClass::Entry::psnr);
    AaChoice choice = predict(scenes, probe, psnr.last_at_least(decibels));
    choice.reached = psnr.most() >= decibels;
    return choice;
}

AaChoice choose_by_time(const AaChart& chart, const AaProbe& probe, double milliseconds) {
    const AaClass& scenes = class_of(chart, probe);
    const Falling ms(scenes, &AaClass::Entry::total_gpu_ms);
    const double scale = ms.at(probe.lambda) / probe.total_gpu_ms;
    AaChoice choice = predict(scenes, probe, ms.first_at_most(milliseconds * scale));
    choice.reached = ms.least() <= milliseconds * scale;
    return choice;
}

} // namespace ockham

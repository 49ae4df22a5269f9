// SPDX-License-Identifier: Apache-2.0
#include "samples/chart/picture_metrics.hpp"

#include "framework/core/error.hpp"
#include "framework/core/file.hpp"
#include "framework/core/log.hpp"
#include "framework/io/image_file.hpp"
#include "samples/chart/suite.hpp"
#include "samples/metrics/network_metric.hpp"
#include "samples/metrics/vmaf.hpp"

#include <nlohmann/json.hpp>

#include <memory>

namespace ockham::chart {
namespace {

constexpr const char* kFile = "metrics.json";

/// What an earlier run has found; nothing where the file is missing or damaged.
std::map<std::string, double> read_known(const std::filesystem::path& path) {
    if (!std::filesystem::exists(path)) return {};
    const nlohmann::json json = nlohmann::json::parse(read_text(path), nullptr, false);
    std::map<std::string, double> known;
    if (!json.is_object()) return known;
    for (const auto& [key, value] : json.items())
        if (value.is_number()) known[key] = value.get<double>();
    return known;
}

} // namespace

PictureMetrics::PictureMetrics(const ChartOptions& options)
    : folder_(options.out), known_(read_known(options.out / kFile)) {
    try {
        const auto vmaf = std::make_shared<Vmaf>(options.ffmpeg, options.vmaf_model);
        metrics_.push_back({"vmaf", fmt::format("VMAF ({})", vmaf->made_by()), Better::more,
            [vmaf](
                const Image& test, const Image& reference) { return (*vmaf)(test, reference); }});
        manifest_.emplace_back("VMAF", vmaf->made_by());
    } catch (const Error& error) {
        if (!options.ffmpeg.empty() || !options.vmaf_model.empty()) throw;
        manifest_.emplace_back("left out", error.what());
    }
    if (options.onnx.empty()) {
        manifest_.emplace_back("left out", "networks, such as LPIPS: no --onnx");
        return;
    }
    const auto network = std::make_shared<NetworkMetric>(options.onnx);
    metrics_.push_back({"network", network->name(), Better::less,
        [network](
            const Image& test, const Image& reference) { return (*network)(test, reference); }});
    manifest_.emplace_back("network", network->name());
}

std::optional<double> PictureMetrics::of(const Metric& metric, const std::filesystem::path& test,
    const std::filesystem::path& reference) {
    try {
        const std::string key =
            fmt::format("{} {} {}", metric.title, fingerprint_of((folder_ / test).string()),
                fingerprint_of((folder_ / reference).string()));
        if (const auto found = known_.find(key); found != known_.end()) return found->second;
        const double value =
            metric.measure(load_image(folder_ / test), load_image(folder_ / reference));
        known_[key] = value;
        write_text(folder_ / kFile, nlohmann::json(known_).dump(1) + "\n");
        return value;
    } catch (const Error& error) {
        log::warning("{}: {}", test.string(), error.what());
        return std::nullopt;
    }
}

std::optional<Table> PictureMetrics::table(
    const std::string& suite, const std::vector<Wipe>& wipes) {
    Table table{.name = suite + "_metrics",
        .title = "What other programs' metrics say of the pictures",
        .columns = {"pictures", "picture"},
        .rows = {},
        .caption = "Of the kept PNGs, against the picture that the error maps are against. VMAF: a "
                   "film of one frame, so that equal pictures score 97.4; its model is of films of "
                   "1080 lines."};
    for (const Metric& metric : metrics_) table.columns.push_back(metric.title);
    for (const Wipe& wipe : wipes)
        for (const Wipe::Side& side : wipe.sides) {
            if (side.reference.empty()) continue;
            std::vector<std::string> row{wipe.title, side.label};
            for (const Metric& metric : metrics_) {
                const auto value = of(metric, side.picture, side.reference);
                row.push_back(value ? fmt::format("{:.4g}", *value) : std::string());
            }
            table.rows.push_back(std::move(row));
        }
    if (metrics_.empty() || table.rows.empty()) return std::nullopt;
    return table;
}

} // namespace ockham::chart

// SPDX-License-Identifier: Apache-2.0
#include "samples/metrics/vmaf.hpp"

#include "framework/core/error.hpp"
#include "framework/core/file.hpp"
#include "framework/core/process.hpp"
#include "framework/image_error/image_error.hpp"
#include "samples/metrics/one_line.hpp"

#include <nlohmann/json.hpp>

#include <cmath>
#include <cstdlib>

namespace ockham {
namespace {

namespace fs = std::filesystem;

constexpr int kLeastSide = 16; ///< four halvings in VIF and ADM

std::string or_environment(const std::string& given, const char* variable, const char* otherwise) {
    if (!given.empty()) return given;
    const char* value = std::getenv(variable);
    return value != nullptr && *value != 0 ? value : otherwise;
}

/// One frame of YUV4MPEG2, its chroma grey: no model looks at it, and nobody has to convert.
std::string film(const Image& linear) {
    const Image picture = displayed(linear);
    std::string file = fmt::format(
        "YUV4MPEG2 W{} H{} F25:1 Ip A1:1 C444\nFRAME\n", picture.width(), picture.height());
    const auto r = picture.plane("R"), g = picture.plane("G"), b = picture.plane("B");
    for (std::size_t i = 0; i < picture.pixels(); ++i) {
        const float luma = 0.2126f * r[i] + 0.7152f * g[i] + 0.0722f * b[i];
        file += static_cast<char>(std::lround(16 + 219 * (std::isfinite(luma) ? luma : 1.0f)));
    }
    return file.append(2 * picture.pixels(), static_cast<char>(128));
}

/// The frame's score and libvmaf's version, out of its log.
std::pair<double, std::string> read_log(const fs::path& path) {
    const nlohmann::json log = nlohmann::json::parse(read_text(path));
    return {log.at("frames").at(0).at("metrics").at("vmaf").get<double>(),
        log.at("version").get<std::string>()};
}

} // namespace

Vmaf::Vmaf(const std::string& ffmpeg, const fs::path& model)
    : program_(or_environment(ffmpeg, "OCKHAM_FFMPEG", "ffmpeg")),
      model_(or_environment(model.string(), "OCKHAM_VMAF_MODEL", "")) {
    const std::optional<fs::path> program = find_program(program_);
    if (!program) fail_input("VMAF: there is no program '{}'", program_);
    program_ = program->string();
    const ProcessResult help = run_process({program_, "-hide_banner", "-h", "filter=libvmaf"});
    if (help.exit_code != 0 || help.text.find("model") == std::string::npos)
        fail_input("VMAF: '{}' is no FFmpeg with libvmaf", program_);
    names_paths_ = help.text.find(" model  ") != std::string::npos;
    if (!model_.empty()) {
        model_ = fs::absolute(model_);
        (void)read_file(model_); // says what is wrong with it
    }
    Image grey(64, 64, {"R", "G", "B"});
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x)
            for (int c = 0; c < 3; ++c) grey.at(x, y, c) = (x / 8 + y / 8) % 2 == 0 ? 0.2f : 0.6f;
    made_by_ = fmt::format("{}, libvmaf {}",
        model_.empty() ? std::string("its own model") : model_.filename().string(),
        measure(grey, grey).version);
}

double Vmaf::operator()(const Image& test, const Image& reference) const {
    return measure(test, reference).score;
}

Vmaf::Measured Vmaf::measure(const Image& test, const Image& reference) const {
    if (test.width() != reference.width() || test.height() != reference.height())
        fail_input("VMAF: the picture has {} x {} pixels, the reference {} x {}", test.width(),
            test.height(), reference.width(), reference.height());
    if (std::min(test.width(), test.height()) < kLeastSide)
        fail_input("VMAF: found {} x {} pixels, it needs {} x {} or more", test.width(),
            test.height(), kLeastSide, kLeastSide);
    // Names inside the filter have a syntax of their own: none of the user's gets there.
    const TemporaryFolder folder;
    write_text(folder.path() / "test.y4m", film(test));
    write_text(folder.path() / "reference.y4m", film(reference));
    std::string filter = "libvmaf=log_fmt=json:log_path=log.json";
    if (!model_.empty()) {
        const std::string name = "model" + model_.extension().string();
        fs::create_symlink(model_, folder.path() / name);
        fs::create_symlink(model_.string() + ".model", folder.path() / (name + ".model"));
        filter += (names_paths_ ? ":model=path=" : ":model_path=") + name;
    }
    const ProcessResult result =
        run_process({program_, "-hide_banner", "-nostdin", "-i", "test.y4m", "-i", "reference.y4m",
                        "-lavfi", filter, "-f", "null", "-"},
            folder.path());
    try {
        if (result.exit_code == 0) {
            auto [score, version] = read_log(folder.path() / "log.json");
            return {score, std::move(version)};
        }
    } catch (const std::exception&) { // said below, with all that FFmpeg said
    }
    fail_input("VMAF: '{}' gave no score{}: {}", program_,
        model_.empty() ? " with libvmaf's own model" : " with '" + model_.string() + "'",
        one_line(result.text));
}

} // namespace ockham

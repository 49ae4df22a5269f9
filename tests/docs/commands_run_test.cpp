// SPDX-License-Identifier: Apache-2.0
// The commands of the pages, run in the folder of somebody who has what they name: small pictures,
// few steps, and data made up here. Those of scans and simulations run where OCKHAM_DATA_DIR is.
#include "framework/core/file.hpp"
#include "tests/docs/commands.hpp"
#include "tests/support/program_test.hpp"
#include "tests/support/volume_bytes.hpp"

#include <fmt/format.h>

#include <map>
#include <regex>

namespace ockham {
namespace {

namespace fs = std::filesystem;

using test::Command, test::commands_of, test::documents, test::kRoot, test::parts_of,
    test::words_of;

/// Programs and flags whose commands are parsed only, and why.
const std::map<std::string, std::string> kNotRun{
    {"viewer", "needs a window: tests/samples/viewer_test.cpp has one"},
    {"chart", "takes minutes: tests/samples/chart_program_test.cpp charts tiny pictures"},
    {"--vmaf", "needs FFmpeg with libvmaf: tests/samples/metrics_test.cpp"},
    {"--onnx", "needs a trained network: tests/samples/metrics_test.cpp makes one up"}};

/// Results of commands that pages take as given.
const std::map<std::string, std::string> kResults{
    {"before.json", "adaptive_aa --method ssaa --plan before.json"},
    {"after.json", "adaptive_aa --plan after.json"}, {"plan.json", "adaptive_aa --plan plan.json"},
    {"all.exr", "adaptive_aa --method ssaa -o all.exr"},
    {"adaptive.png", "adaptive_aa -o adaptive.png"},
    {"layers.exr", "adaptive_aa --aov -o layers.exr"},
    {"studio.exr", "adaptive_aa builtin:sky --method none -o studio.exr"}};

/// Scans and simulations.
bool needs_data(const std::string& word) {
    static const std::regex kData(
        R"(.*\.vdb|(cranium_ct|engine|brainweb_t1|smoke_flame|bi2o3_c0)\.json)");
    return std::regex_match(word, kData);
}

/// Of 8 x 8 x 8 voxels from -1000 to 1555, as CT has them.
std::string scan() {
    std::string voxels;
    for (int i = 0; i < 512; ++i)
        voxels += test::ramp<std::int16_t>(1, static_cast<std::int16_t>(5 * i - 1000));
    return test::nrrd({{"sizes", "8 8 8"}}, voxels);
}

std::string as_glb(std::string json) {
    const auto u32 = [](std::size_t value) {
        return test::ramp<std::uint32_t>(1, static_cast<std::uint32_t>(value));
    };
    json.resize((json.size() + 3) / 4 * 4, ' ');
    return "glTF" + u32(2) + u32(20 + json.size()) + u32(json.size()) + "JSON" + json;
}

/// JSON files whose text a page shows: "`x.json` is `{...}`", or a block after <!-- file: x.json
/// -->.
std::map<std::string, std::string> shown_files(const fs::path& page) {
    std::string text = read_text(page);
    std::map<std::string, std::string> files;
    for (const char* pattern : {R"(`(\w+\.json)`\s+is\s+`(\{[^`]*\})`)",
             "<!-- file: (\\w+\\.json) -->\n```json\n([^`]*)```"}) {
        const std::regex shown(pattern);
        for (std::sregex_iterator it(text.begin(), text.end(), shown), end; it != end; ++it)
            files[(*it)[1]] = (*it)[2];
    }
    return files;
}

/// Less of what takes long: the numbers of flags, and flags where there are none.
std::string lessened(const std::string& part) {
    static const std::map<std::string, std::string> kLess{{"--width", "64"}, {"--height", "48"},
        {"--steps", "2"}, {"--frames", "2"}, {"--turntable", "2"}, {"--repeats", "1"},
        {"--time", "1"}};
    static const std::map<std::string, std::vector<std::string>> kAdded{
        {"adaptive_aa", {"--width", "--height"}}, {"volume_gi", {"--width", "--height", "--steps"}},
        {"surface_volume", {"--width", "--height", "--steps"}},
        {"aa_table", {"--width", "--height", "--repeats"}},
        {"aa_curve", {"--width", "--height", "--repeats"}}};
    std::string result = part;
    for (const auto& [flag, value] : kLess)
        result = std::regex_replace(result, std::regex(flag + R"( [\d.]+)"), flag + " " + value);
    const auto added = kAdded.find(part.substr(0, part.find(' ')));
    if (added == kAdded.end()) return result;
    for (const std::string& flag : added->second) {
        const bool chosen = flag == "--steps" && part.find("--target-psnr ") != std::string::npos;
        if (!chosen && part.find(flag + " ") == std::string::npos)
            result += " " + flag + " " + kLess.at(flag);
    }
    return result;
}

class CommandsOfPage : public test::ProgramTest, public testing::WithParamInterface<fs::path> {
protected:
    CommandsOfPage() : ProgramTest("docs_commands_run") {
        fs::create_directory_symlink(kRoot / "shaders", folder / "shaders");
        const std::string scene = read_text(kRoot / "tests/docs/commands/my_scene.gltf");
        for (const char* name : {"my_scene.gltf", "scene.gltf", "room.gltf"})
            write_text(folder / name, scene);
        write_text(folder / "scene.glb", as_glb(scene));
        fs::copy(kRoot / "samples/surface_volume/plinth.gltf", folder);
        for (const char* name : {"my_scan.nrrd", "scan.nrrd", "ct.nrrd", "head.nrrd"})
            write_text(folder / name, scan());
        write_text(folder / "scan.nii.gz", test::gzip(test::nifti()));
        fs::create_directory(folder / "dicom_folder");
        write_text(folder / "dicom_folder/a.dcm", test::dicom({}));
#ifdef OCKHAM_DATA_DIR
        const fs::path volumes = fs::path(OCKHAM_DATA_DIR) / "volumes";
        for (const auto& entry : fs::directory_iterator(volumes))
            fs::create_symlink(entry.path(), folder / entry.path().filename());
        for (const char* name : {"smoke.vdb", "fire.vdb", "plume.vdb"})
            fs::create_symlink(volumes / "bump64.vdb", folder / name);
#endif
        for (const fs::path& page : documents()) write_shown(page);
        write_shown(GetParam()); // its own win
    }
    void write_shown(const fs::path& page) {
        for (const auto& [name, text] : shown_files(page)) write_text(folder / name, text);
    }
    /// `part`: a program and its arguments.
    void expect_success(const std::string& where, const std::string& part) {
        const std::string program = part.substr(0, part.find(' '));
        const test::Result result = run(part.substr(program.size()), "", program);
        const bool over_budget = program == "plan_diff" && result.exit_code == 1;
        EXPECT_TRUE(result.exit_code == 0 || over_budget) << where << ": " << part << "\n"
                                                          << result.exit_code << "\n"
                                                          << result.text;
    }
    std::string reason_not_to_run(const std::vector<std::string>& words) const {
        for (const std::string& word : words) {
            if (const auto found = kNotRun.find(word); found != kNotRun.end()) return found->second;
            if (needs_data(word) && !fs::exists(folder / word)) return "needs OCKHAM_DATA_DIR";
        }
        return "";
    }
    void provide(const std::string& name) {
        const auto result = kResults.find(name);
        if (result == kResults.end() || fs::exists(folder / name)) return;
        expect_success(name, lessened(result->second));
    }
};

TEST_P(CommandsOfPage, Run) {
    for (const Command& command : commands_of(GetParam(), words_of(OCKHAM_PROGRAMS))) {
        for (const std::string& part : parts_of(command.text)) {
            const std::vector<std::string> words = words_of(part);
            if (const std::string reason = reason_not_to_run(words); !reason.empty()) {
                fmt::print("not run: {}: {}\n", part, reason);
                break;
            }
            for (std::size_t i = 1; i < words.size(); ++i)
                if (words[i - 1] != "-o") provide(words[i]);
            expect_success(command.where, lessened(part));
        }
    }
}

std::vector<fs::path> pages_with_commands() {
    std::vector<fs::path> pages;
    for (const fs::path& page : documents())
        if (!commands_of(page, words_of(OCKHAM_PROGRAMS)).empty()) pages.push_back(page);
    return pages;
}

INSTANTIATE_TEST_SUITE_P(Docs, CommandsOfPage, testing::ValuesIn(pages_with_commands()),
    [](const testing::TestParamInfo<fs::path>& page) {
        return std::regex_replace(
            page.param.lexically_relative(kRoot).string(), std::regex(R"(\W)"), "_");
    });

} // namespace
} // namespace ockham
